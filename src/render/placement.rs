//! Checks of cameras and point lights against the surface: inside it, or on it.

use std::collections::HashSet;

use glam::DVec3;
use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::mesh::triangle_mesh::TriangleMesh;
use crate::progress::Progress;
use crate::render::bounds::Bounds;
use crate::render::light::Origin;
use crate::render::plan::PlannedFrame;

/// Refuses point lights on the surface; warns of lights and cameras inside a closed one.
pub fn check(
    mesh: &TriangleMesh,
    bounds: &Bounds,
    frames: &[PlannedFrame],
    progress: Progress<'_>,
) -> Result<()> {
    let mut known = HashSet::new();
    for frame in frames {
        let number = frame.number;
        // Check each point light once.
        for light in &frame.lights {
            let Origin::Point { position, .. } = light.origin else {
                continue;
            };
            if !known.insert(position.to_array().map(f64::to_bits)) {
                continue;
            }
            let distance = distance(mesh, position);
            if distance < 1e-5 * bounds.radius {
                return Err(Error::data(
                    format!("frame {number}, point light"),
                    format!("{position} lies on the surface"),
                )
                .expected("a place off the surface"));
            }
            if is_inside(mesh, bounds, position) {
                progress.warn(format!(
                    "frame {number}: the point light at {position} is inside the mesh and lights \
                     nothing that is seen from outside"
                ));
            }
        }
        // Check each camera once.
        let camera = frame.view.camera.position;
        let is_new = known.insert(camera.to_array().map(|x| (x + 0.0).to_bits()));
        if frame.view.is_perspective() && is_new && is_inside(mesh, bounds, camera) {
            progress.warn(format!(
                "frame {number}: the camera at {camera} is inside the mesh"
            ));
        }
    }
    Ok(())
}

/// Triangles summed by one task; fixed, so that sums do not depend on the thread count.
const CHUNK: usize = 1 << 12;

/// Whether a closed mesh surrounds a point: its winding number, the solid angle of all triangles
/// over 4π (van Oosterom and Strackee 1983), is nearer to ±1 than to 0.
fn is_inside(mesh: &TriangleMesh, bounds: &Bounds, point: DVec3) -> bool {
    if !bounds.contain(point) {
        return false;
    }
    let sums: Vec<f64> = mesh
        .triangles
        .par_chunks(CHUNK)
        .map(|triangles| {
            triangles
                .iter()
                .map(|t| solid_angle(t.map(|v| mesh.positions[v as usize].as_dvec3() - point)))
                .sum()
        })
        .collect();
    let winding = sums.iter().sum::<f64>() / (4.0 * std::f64::consts::PI);
    winding.abs() > 0.75
}

fn solid_angle([a, b, c]: [DVec3; 3]) -> f64 {
    let (la, lb, lc) = (a.length(), b.length(), c.length());
    let above = a.dot(b.cross(c));
    let below = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
    2.0 * above.atan2(below)
}

/// The distance from a point to the nearest triangle.
fn distance(mesh: &TriangleMesh, point: DVec3) -> f64 {
    (0..mesh.triangles.len())
        .into_par_iter()
        .map(|t| distance_to_triangle(mesh.corners(t).map(|p| p.as_dvec3() - point)))
        .reduce(|| f64::INFINITY, f64::min)
}

/// The distance from the origin to a triangle: to its plane where the foot lies inside, else to the
/// nearest edge.
fn distance_to_triangle([a, b, c]: [DVec3; 3]) -> f64 {
    let normal = (b - a).cross(c - a);
    let edges = [(a, b), (b, c), (c, a)];
    let inside = edges.iter().all(|(p, q)| normal.dot(p.cross(*q)) >= 0.0);
    if inside && normal.length_squared() > 0.0 {
        return normal.dot(a).abs() / normal.length();
    }
    let to_edge = |(p, q): &(DVec3, DVec3)| {
        let along = *q - *p;
        let foot = (-p.dot(along) / along.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        (*p + along * foot).length()
    };
    edges.iter().map(to_edge).fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    fn octahedron() -> TriangleMesh {
        TriangleMesh {
            positions: vec![Vec3::X, Vec3::Y, Vec3::Z, -Vec3::X, -Vec3::Y, -Vec3::Z],
            triangles: vec![
                [0, 1, 2],
                [1, 3, 2],
                [3, 4, 2],
                [4, 0, 2],
                [1, 0, 5],
                [3, 1, 5],
                [4, 3, 5],
                [0, 4, 5],
            ],
        }
    }

    #[test]
    fn insides_and_distances_of_an_octahedron() {
        let mesh = octahedron();
        let bounds = Bounds::of(&mesh).unwrap();
        assert!(is_inside(&mesh, &bounds, DVec3::splat(0.1)));
        assert!(!is_inside(&mesh, &bounds, DVec3::splat(0.4)));
        assert!(!is_inside(&mesh, &bounds, DVec3::splat(2.0)));
        let third = 1.0 / 3f64.sqrt();
        assert!((distance(&mesh, DVec3::ZERO) - third).abs() < 1e-6);
        assert!((distance(&mesh, DVec3::X * 3.0) - 2.0).abs() < 1e-6);
        assert!(distance(&mesh, DVec3::splat(1.0 / 3.0)) < 1e-7);
    }
}
