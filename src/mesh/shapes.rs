//! Meshes with a formula: flat grids, cylinders, spheres, tori. For benchmarks, examples and
//! tests against closed forms.

use std::collections::HashMap;
use std::f32::consts::TAU;

use glam::Vec3;

use crate::mesh::triangle_mesh::TriangleMesh;

/// A flat grid in the plane z = 0 of `columns` × `rows` squares of side `step`, seen from +z,
/// vertices row by row from the origin.
pub fn grid(columns: u32, rows: u32, step: f32) -> TriangleMesh {
    let positions = (0..=rows)
        .flat_map(|y| (0..=columns).map(move |x| Vec3::new(x as f32, y as f32, 0.0) * step))
        .collect();
    let at = |x: u32, y: u32| y * (columns + 1) + x;
    TriangleMesh {
        positions,
        triangles: quads(columns, rows, at),
    }
}

/// An open cylinder round z: `around` flat sides, `rings` rings of height `step`.
pub fn cylinder(around: u32, rings: u32, radius: f32, step: f32) -> TriangleMesh {
    let positions = (0..=rings)
        .flat_map(|y| {
            (0..around).map(move |x| {
                let (sin, cos) = (x as f32 / around as f32 * TAU).sin_cos();
                Vec3::new(radius * cos, radius * sin, y as f32 * step)
            })
        })
        .collect();
    let at = |x: u32, y: u32| y * around + x % around;
    TriangleMesh {
        positions,
        triangles: quads(around, rings, at),
    }
}

/// A torus round z with `around` × `across` vertices, radii of its axis and of its tube.
pub fn torus(around: u32, across: u32, axis: f32, tube: f32) -> TriangleMesh {
    let positions = (0..across)
        .flat_map(|y| {
            let (tube_sin, tube_cos) = (y as f32 / across as f32 * TAU).sin_cos();
            (0..around).map(move |x| {
                let (sin, cos) = (x as f32 / around as f32 * TAU).sin_cos();
                let radius = axis + tube * tube_cos;
                Vec3::new(radius * cos, radius * sin, tube * tube_sin)
            })
        })
        .collect();
    let at = |x: u32, y: u32| y % across * around + x % around;
    TriangleMesh {
        positions,
        triangles: quads(around, across, at),
    }
}

/// The unit sphere, an icosahedron subdivided `subdivisions` times.
pub fn icosphere(subdivisions: u32) -> TriangleMesh {
    let mut mesh = icosahedron();
    for _ in 0..subdivisions {
        mesh = midpoints(&mesh);
        for position in &mut mesh.positions {
            *position = position.normalize();
        }
    }
    mesh
}

fn icosahedron() -> TriangleMesh {
    let golden = f32::midpoint(1.0, 5f32.sqrt());
    // Place the corners on three golden rectangles.
    let mut positions = Vec::new();
    for (one, other) in [
        (1.0, golden),
        (-1.0, golden),
        (1.0, -golden),
        (-1.0, -golden),
    ] {
        positions.push(Vec3::new(0.0, one, other).normalize());
        positions.push(Vec3::new(one, other, 0.0).normalize());
        positions.push(Vec3::new(other, 0.0, one).normalize());
    }
    // Join any three that are near each other, facing outwards.
    let mut triangles = Vec::new();
    let near = |a: usize, b: usize| positions[a].dot(positions[b]) > 0.4;
    for a in 0..12 {
        for b in a + 1..12 {
            for c in b + 1..12 {
                if near(a, b) && near(b, c) && near(a, c) {
                    let outward = (positions[b] - positions[a])
                        .cross(positions[c] - positions[a])
                        .dot(positions[a]);
                    let [a, b, c] = [a, b, c].map(|v| v as u32);
                    triangles.push(if outward > 0.0 { [a, b, c] } else { [a, c, b] });
                }
            }
        }
    }
    TriangleMesh {
        positions,
        triangles,
    }
}

/// Every triangle cut in four at the middles of its edges.
pub fn midpoints(mesh: &TriangleMesh) -> TriangleMesh {
    let mut positions = mesh.positions.clone();
    let mut middles: HashMap<(u32, u32), u32> = HashMap::new();
    let mut middle = |a: u32, b: u32| {
        *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
            positions.push(positions[a as usize].midpoint(positions[b as usize]));
            positions.len() as u32 - 1
        })
    };
    let mut triangles = Vec::with_capacity(mesh.triangles.len() * 4);
    for &[a, b, c] in &mesh.triangles {
        let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
        triangles.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
    }
    TriangleMesh {
        positions,
        triangles,
    }
}

fn quads(columns: u32, rows: u32, at: impl Fn(u32, u32) -> u32) -> Vec<[u32; 3]> {
    let mut triangles = Vec::with_capacity(2 * columns as usize * rows as usize);
    for y in 0..rows {
        for x in 0..columns {
            let [a, b, c, d] = [at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)];
            triangles.push([a, b, c]);
            triangles.push([a, c, d]);
        }
    }
    triangles
}
