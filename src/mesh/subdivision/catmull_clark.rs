//! One step of Catmull-Clark subdivision, and where its vertices tend to.
//!
//! Catmull and Clark 1978: recursively generated B-spline surfaces on arbitrary topological meshes. Halstead,
//! Kass and DeRose 1993 §3 for the limit. Boundaries are cubic B-splines of their own, and a boundary vertex
//! of one face alone, a corner, stays where it is.

use std::ops::{Add, Mul};

use super::quad_mesh::QuadMesh;
use crate::mesh::topology::NONE;

/// What can be carried by subdivision: positions in space, in the plane, numbers.
pub trait Value: Copy + Default + Add<Output = Self> + Mul<f64, Output = Self> {}

impl<T: Copy + Default + Add<Output = T> + Mul<f64, Output = T>> Value for T {}

/// The sums round one vertex.
#[derive(Clone, Copy, Default)]
struct Around<T> {
    faces: u32,
    /// Each neighbour along an edge, once for each face that has the edge.
    neighbors: T,
    /// The corners opposite in its faces.
    diagonals: T,
    /// The middles of its faces.
    middles: T,
    /// Neighbours along the boundary.
    boundary: T,
    is_boundary: bool,
}

fn middle<T: Value>(quad: [u32; 4], values: &[T]) -> T {
    let [a, b, c, d] = quad.map(|vertex| values[vertex as usize]);
    (a + b + c + d) * 0.25
}

fn around<T: Value>(mesh: &QuadMesh, values: &[T]) -> Vec<Around<T>> {
    let mut sums = vec![Around::default(); mesh.vertices];
    for quad in &mesh.quads {
        let corners = quad.map(|vertex| values[vertex as usize]);
        let middle = middle(*quad, values);
        for k in 0..4 {
            let sum: &mut Around<T> = &mut sums[quad[k] as usize];
            sum.faces += 1;
            sum.neighbors = sum.neighbors + corners[(k + 1) % 4] + corners[(k + 3) % 4];
            sum.diagonals = sum.diagonals + corners[(k + 2) % 4];
            sum.middles = sum.middles + middle;
        }
    }
    for half_edge in 0..mesh.opposite.len() {
        if mesh.opposite[half_edge] == NONE {
            let [a, b] = mesh.ends(half_edge as u32);
            for (vertex, other) in [(a, b), (b, a)] {
                let sum = &mut sums[vertex as usize];
                sum.boundary = sum.boundary + values[other as usize];
                sum.is_boundary = true;
            }
        }
    }
    sums
}

/// The values at the vertices of [`refined`]: old vertices first, then a vertex per edge, then one per
/// quadrilateral.
pub fn refined_values<T: Value>(mesh: &QuadMesh, values: &[T]) -> Vec<T> {
    let vertex = |(sum, &own): (&Around<T>, &T)| {
        if sum.faces <= 1 {
            return own;
        }
        if sum.is_boundary {
            return own * 0.75 + sum.boundary * 0.125;
        }
        let n = f64::from(sum.faces);
        (sum.middles + sum.neighbors * 0.5) * (1.0 / (n * n)) + own * ((n - 2.0) / n)
    };
    let sums = around(mesh, values);
    let mut fine: Vec<T> = sums.iter().zip(values).map(vertex).collect();
    for half_edge in 0..mesh.opposite.len() as u32 {
        if !mesh.is_first(half_edge) {
            continue;
        }
        let [a, b] = mesh.ends(half_edge);
        let ends = (values[a as usize] + values[b as usize]) * 0.5;
        fine.push(match mesh.opposite[half_edge as usize] {
            NONE => ends,
            twin => {
                let [near, far] = [half_edge, twin].map(|of| mesh.quads[of as usize / 4]);
                ends * 0.5 + (middle(near, values) + middle(far, values)) * 0.25
            }
        });
    }
    fine.extend(mesh.quads.iter().map(|&quad| middle(quad, values)));
    fine
}

/// Every quadrilateral cut in four. Quadrilateral 4·q + k holds corner k of q, as its own corner k: all four
/// lie as q does.
pub fn refined(mesh: &QuadMesh) -> QuadMesh {
    let half_edges = mesh.opposite.len();
    let mut edge_vertices = vec![NONE; half_edges];
    let mut vertices = mesh.vertices as u32;
    for half_edge in 0..half_edges as u32 {
        let twin = mesh.opposite[half_edge as usize];
        if mesh.is_first(half_edge) {
            edge_vertices[half_edge as usize] = vertices;
            vertices += 1;
        } else {
            edge_vertices[half_edge as usize] = edge_vertices[twin as usize];
        }
    }
    let mut quads = Vec::with_capacity(4 * mesh.quads.len());
    let mut opposite = Vec::with_capacity(4 * half_edges);
    for (q, corners) in mesh.quads.iter().enumerate() {
        for k in 0..4 {
            let (mut child, mut twins) = ([0; 4], [NONE; 4]);
            let (next, before) = ((k + 1) % 4, (k + 3) % 4);
            child[k] = corners[k];
            child[next] = edge_vertices[4 * q + k];
            child[(k + 2) % 4] = vertices + q as u32;
            child[before] = edge_vertices[4 * q + before];
            // The first half of side k meets the second half of the side across.
            twins[k] = half_of(mesh.opposite[4 * q + k], 1);
            twins[before] = half_of(mesh.opposite[4 * q + before], 0);
            twins[next] = (4 * (4 * q + next) + before) as u32;
            twins[(k + 2) % 4] = (4 * (4 * q + before) + k) as u32;
            quads.push(child);
            opposite.extend(twins);
        }
    }
    QuadMesh {
        vertices: vertices as usize + mesh.quads.len(),
        quads,
        opposite,
    }
}

/// The first (0) or second (1) half of a half-edge, among the refined half-edges.
fn half_of(half_edge: u32, half: u32) -> u32 {
    match half_edge {
        NONE => NONE,
        _ => {
            let (quad, side) = (half_edge / 4, half_edge % 4);
            4 * (4 * quad + (side + half) % 4) + side
        }
    }
}

/// The values of the smooth surface at the vertices.
pub fn limit_values<T: Value>(mesh: &QuadMesh, values: &[T]) -> Vec<T> {
    let limit = |(sum, &own): (&Around<T>, &T)| {
        if sum.faces <= 1 {
            return own;
        }
        if sum.is_boundary {
            return own * (2.0 / 3.0) + sum.boundary * (1.0 / 6.0);
        }
        let n = f64::from(sum.faces);
        (own * (n * n) + sum.neighbors * 2.0 + sum.diagonals) * (1.0 / (n * (n + 5.0)))
    };
    around(mesh, values).iter().zip(values).map(limit).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::subdivision::quad_mesh;
    use glam::{DVec2, DVec3};

    fn grid(columns: u32, rows: u32) -> (QuadMesh, Vec<DVec2>) {
        let at = |x: u32, y: u32| y * (columns + 1) + x;
        let quads = (0..rows).flat_map(|y| {
            (0..columns).map(move |x| [at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)])
        });
        let points = (0..=rows)
            .flat_map(|y| (0..=columns).map(move |x| DVec2::new(f64::from(x), f64::from(y))));
        let points: Vec<DVec2> = points.collect();
        (QuadMesh::new(points.len(), quads.collect()), points)
    }

    /// The cube of side 2 round zero.
    fn cube() -> (QuadMesh, Vec<DVec3>) {
        let corner = |k: u32| {
            let sign = |bit: bool| if bit { 1.0 } else { -1.0 };
            let right = k % 4 == 1 || k % 4 == 2;
            DVec3::new(sign(right), sign(k % 4 >= 2), sign(k >= 4))
        };
        (quad_mesh::tests::cube(), (0..8).map(corner).collect())
    }

    #[test]
    fn a_regular_grid_stays_where_it_is() {
        let (mut mesh, mut points) = grid(3, 2);
        for step in 1..4 {
            points = refined_values(&mesh, &points);
            mesh = refined(&mesh);
            let limit = limit_values(&mesh, &points);
            let side = 0.5_f64.powi(step);
            for quad in &mesh.quads {
                let [a, b, c, d] = quad.map(|vertex| points[vertex as usize]);
                assert_eq!([b - a, d - a], [DVec2::X * side, DVec2::Y * side]);
                assert_eq!(c - a, DVec2::splat(side));
                assert!(limit[quad[0] as usize].distance(a) < 1e-12);
            }
        }
    }

    #[test]
    fn a_cube_has_the_points_that_the_rules_say() {
        let (mesh, points) = cube();
        let fine = refined_values(&mesh, &points);
        // 8 vertices, 12 edges, 6 faces.
        assert_eq!(fine.len(), 26);
        // Vertex: (F + 2R + 0)/3 with F = 1/3 and R = 2/3 of the corner.
        for (vertex, corner) in fine[..8].iter().zip(&points) {
            assert!(vertex.distance(*corner * (5.0 / 9.0)) < 1e-12);
        }
        // Edge: the mean of its ends and two face middles, (0, ¾, ¾) and its like.
        for edge in &fine[8..20] {
            let mut parts = edge.abs().to_array();
            parts.sort_by(f64::total_cmp);
            assert_eq!(parts, [0.0, 0.75, 0.75]);
        }
        for face in &fine[20..] {
            assert_eq!(face.abs().element_sum(), 1.0);
        }
        // Limit of a corner c: its neighbours sum to c, and so do its diagonals to −c: (9 + 4 − 1) / 24 of c.
        for (limit, corner) in limit_values(&mesh, &points).iter().zip(&points) {
            assert!(limit.distance(*corner * 0.5) < 1e-12, "{limit}");
        }
    }

    #[test]
    fn limits_are_those_of_further_steps() {
        let (mut mesh, mut points) = cube();
        points[3] *= 1.7;
        let limit = limit_values(&mesh, &points);
        for _ in 0..6 {
            points = refined_values(&mesh, &points);
            mesh = refined(&mesh);
        }
        for (limit, found) in limit.iter().zip(&points) {
            assert!(limit.distance(*found) < 1e-3, "{limit} and {found}");
        }
        let last = limit_values(&mesh, &points);
        for (limit, found) in limit.iter().zip(&last) {
            assert!(limit.distance(*found) < 1e-12);
        }
    }

    #[test]
    fn refined_quadrilaterals_know_their_neighbors() {
        for (mesh, euler) in [(grid(3, 2).0, 1), (cube().0, 2)] {
            let fine = refined(&refined(&mesh));
            assert_eq!(fine, QuadMesh::new(fine.vertices, fine.quads.clone()));
            assert_eq!(fine.quads.len(), 16 * mesh.quads.len());
            let counted = fine.vertices as i64 - fine.edges() as i64 + fine.quads.len() as i64;
            assert_eq!(counted, euler);
        }
    }
}
