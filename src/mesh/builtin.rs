//! The built-in mesh: a kettlebell — a closed surface with a handle (genus 1) and curvature of
//! both signs, polygonized from an implicit function by surface nets (Gibson 1998).

use std::collections::HashMap;

use glam::{IVec3, Vec3};

use crate::mesh::triangle_mesh::TriangleMesh;

/// Surface area of the kettlebell, in its own units; sets the grid's step for a vertex count.
const AREA: f32 = 16.6;
/// Vertices a surface net has for every step² of area, over all slopes of the surface.
const VERTICES_PER_CELL: f32 = 1.4;
/// Half the sides of the box the surface lies in, and its centre.
const HALF_BOX: Vec3 = Vec3::new(1.15, 1.65, 1.15);
const CENTER: Vec3 = Vec3::new(0.0, 0.55, 0.0);
/// How often vertices are evened out and put back on the surface.
const RELAXATIONS: usize = 8;

/// A kettlebell of about `vertices` vertices, standing on y = −1, handle up; sizes in units of the
/// body's radius.
pub fn kettlebell(vertices: usize) -> TriangleMesh {
    let step = (VERTICES_PER_CELL * AREA / vertices.max(100) as f32).sqrt();
    let mut mesh = surface_net(kettlebell_distance, step);
    for _ in 0..RELAXATIONS {
        even_out(&mut mesh);
        project(&mut mesh, kettlebell_distance);
    }
    mesh
}

/// Below 0 inside; near the surface about the distance to it.
fn kettlebell_distance(p: Vec3) -> f32 {
    let body = p.length() - 1.0;
    let around = Vec3::new(p.x, p.y - 1.25, 0.0);
    let handle = (around.length() - 0.62).hypot(p.z) - 0.2;
    smooth_minimum(body, handle, 0.3)
}

/// The smaller of two distances, with a fillet of width `blend` between the shapes.
fn smooth_minimum(a: f32, b: f32, blend: f32) -> f32 {
    let overlap = (blend - (a - b).abs()).max(0.0) / blend;
    a.min(b) - 0.25 * blend * overlap * overlap
}

/// Puts a vertex in every grid cell the surface crosses, and a quad round every crossed edge.
fn surface_net(distance: impl Fn(Vec3) -> f32, step: f32) -> TriangleMesh {
    let cells = (2.0 * HALF_BOX / step).ceil().as_ivec3();
    let corner = |at: IVec3| CENTER - HALF_BOX + at.as_vec3() * step;
    let sides = (cells + 1).as_usizevec3();
    let flat = |at: IVec3| (at.z as usize * sides.y + at.y as usize) * sides.x + at.x as usize;
    let mut values = Vec::with_capacity(sides.x * sides.y * sides.z);
    for at in lattice(cells + 1) {
        values.push(distance(corner(at)));
    }
    let mut mesh = TriangleMesh::default();
    let mut vertex_of_cell = HashMap::new();
    for cell in lattice(cells) {
        let value = |offset: IVec3| values[flat(cell + offset)];
        if let Some(crossing) = mean_crossing(value) {
            vertex_of_cell.insert(cell, mesh.positions.len() as u32);
            mesh.positions.push(corner(cell) + crossing * step);
        }
    }
    for at in lattice(cells) {
        for axis in 0..3 {
            let mut next = at;
            next[axis] += 1;
            let (here, there) = (values[flat(at)], values[flat(next)]);
            if (here < 0.0) != (there < 0.0) {
                push_quad(&mut mesh, &vertex_of_cell, at, axis, here < 0.0);
            }
        }
    }
    mesh
}

/// All points of a lattice, x fastest.
fn lattice(sides: IVec3) -> impl Iterator<Item = IVec3> {
    (0..sides.z).flat_map(move |z| {
        (0..sides.y).flat_map(move |y| (0..sides.x).map(move |x| IVec3::new(x, y, z)))
    })
}

/// The mean of the points where the surface crosses a unit cell's edges.
fn mean_crossing(value: impl Fn(IVec3) -> f32) -> Option<Vec3> {
    let (mut sum, mut crossings) = (Vec3::ZERO, 0);
    for from in lattice(IVec3::splat(2)) {
        for axis in (0..3).filter(|&axis| from[axis] == 0) {
            let mut to = from;
            to[axis] = 1;
            let (a, b) = (value(from), value(to));
            if (a < 0.0) != (b < 0.0) {
                sum += from.as_vec3().lerp(to.as_vec3(), a / (a - b));
                crossings += 1;
            }
        }
    }
    (crossings > 0).then(|| sum / crossings as f32)
}

/// The quad of the four cells round the edge from `at` along `axis`, as two triangles.
fn push_quad(
    mesh: &mut TriangleMesh,
    vertex_of_cell: &HashMap<IVec3, u32>,
    at: IVec3,
    axis: usize,
    leaving: bool,
) {
    let mut steps = [IVec3::ZERO; 2];
    steps[0][(axis + 1) % 3] = 1;
    steps[1][(axis + 2) % 3] = 1;
    let [u, v] = steps;
    let around = [at - u - v, at - v, at, at - u];
    let corners = around.map(|cell| vertex_of_cell.get(&cell).copied());
    let [Some(a), Some(b), Some(c), Some(d)] = corners else {
        return;
    };
    let [a, b, c, d] = if leaving { [a, b, c, d] } else { [a, d, c, b] };
    let length = |from: u32, to: u32| {
        mesh.positions[from as usize].distance_squared(mesh.positions[to as usize])
    };
    if length(a, c) <= length(b, d) {
        mesh.triangles.extend([[a, b, c], [a, c, d]]);
    } else {
        mesh.triangles.extend([[a, b, d], [b, c, d]]);
    }
}

/// Moves every vertex halfway to the mean of its neighbours.
fn even_out(mesh: &mut TriangleMesh) {
    let mut sums = vec![(Vec3::ZERO, 0u32); mesh.positions.len()];
    for &[a, b, c] in &mesh.triangles {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            let sum = &mut sums[to as usize];
            sum.0 += mesh.positions[from as usize];
            sum.1 += 1;
        }
    }
    for (position, (sum, count)) in mesh.positions.iter_mut().zip(sums) {
        *position = position.lerp(sum / count.max(1) as f32, 0.5);
    }
}

/// Puts every vertex back on the surface by Newton steps along the gradient.
fn project(mesh: &mut TriangleMesh, distance: impl Fn(Vec3) -> f32) {
    const H: f32 = 1e-3;
    for position in &mut mesh.positions {
        for _ in 0..2 {
            let p = *position;
            let slope = |axis: Vec3| (distance(p + axis * H) - distance(p - axis * H)) / (2.0 * H);
            let gradient = Vec3::new(slope(Vec3::X), slope(Vec3::Y), slope(Vec3::Z));
            *position -= gradient * (distance(p) / gradient.length_squared().max(1e-6));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashMap;

    #[test]
    fn the_kettlebell_is_closed_oriented_and_has_one_handle() {
        let mesh = kettlebell(6000);
        let mut edges: HashMap<(u32, u32), u32> = HashMap::new();
        for &[a, b, c] in &mesh.triangles {
            for edge in [(a, b), (b, c), (c, a)] {
                *edges.entry(edge).or_default() += 1;
            }
        }
        assert!(
            edges.values().all(|&times| times == 1),
            "an edge is used twice one way"
        );
        assert!(
            edges.keys().all(|&(a, b)| edges.contains_key(&(b, a))),
            "an open edge"
        );
        let euler =
            mesh.positions.len() as i64 - edges.len() as i64 / 2 + mesh.triangles.len() as i64;
        assert_eq!(euler, 0);
        assert!(
            (5000..7000).contains(&mesh.positions.len()),
            "{}",
            mesh.positions.len()
        );
    }

    #[test]
    fn vertices_lie_on_the_surface_and_triangles_face_outwards() {
        let mesh = kettlebell(2000);
        let volume: f32 = (0..mesh.triangles.len())
            .map(|t| {
                let [a, b, c] = mesh.corners(t);
                a.dot(b.cross(c)) / 6.0
            })
            .sum();
        assert!((4.2..5.2).contains(&volume), "{volume}");
        for &position in &mesh.positions {
            assert!(kettlebell_distance(position).abs() < 1e-3);
        }
        assert!(
            (mesh.area() as f32 / AREA - 1.0).abs() < 0.1,
            "{}",
            mesh.area()
        );
    }
}
