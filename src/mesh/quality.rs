//! How even a mesh is, and how far it lies from another surface: the two aims of Turk 1992.

use glam::Vec3;
use rayon::prelude::*;
use serde::Serialize;

use crate::mesh::rings::angle_between;
use crate::mesh::surface_bvh::SurfaceBvh;
use crate::mesh::triangle_mesh::TriangleMesh;

/// Evenness of edges and angles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Evenness {
    /// Mean edge length, mesh units.
    pub mean_edge: f64,
    /// Standard deviation of edge lengths over their mean.
    pub edge_variation: f64,
    /// The smallest angle of a triangle, in degrees, that 99 % of triangles reach.
    pub smallest_angle_of_99_percent: f64,
}

/// Measures a mesh; zeros for one without triangles.
pub fn evenness(mesh: &TriangleMesh) -> Evenness {
    if mesh.triangles.is_empty() {
        return Evenness::default();
    }
    // Measure the edges, each once.
    let mut edges: Vec<(u32, u32)> = mesh
        .triangles
        .iter()
        .flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)])
        .map(|(a, b)| (a.min(b), a.max(b)))
        .collect();
    edges.par_sort_unstable();
    edges.dedup();
    let at = |v: u32| mesh.positions[v as usize].as_dvec3();
    let lengths: Vec<f64> = edges.iter().map(|&(a, b)| at(a).distance(at(b))).collect();
    let count = lengths.len() as f64;
    let mean = lengths.iter().sum::<f64>() / count;
    let variance = lengths
        .iter()
        .map(|length| (length - mean).powi(2))
        .sum::<f64>()
        / count;
    // Measure the angles.
    let mut angles: Vec<f64> = (0..mesh.triangles.len())
        .map(|t| smallest_angle(mesh, t))
        .collect();
    angles.sort_unstable_by(f64::total_cmp);
    Evenness {
        mean_edge: mean,
        edge_variation: variance.sqrt() / mean,
        smallest_angle_of_99_percent: angles[angles.len() / 100].to_degrees(),
    }
}

fn smallest_angle(mesh: &TriangleMesh, triangle: usize) -> f64 {
    let [a, b, c] = mesh.corners(triangle).map(Vec3::as_dvec3);
    angle_between(b - a, c - a)
        .min(angle_between(c - b, a - b))
        .min(angle_between(a - c, b - c))
}

/// The largest distance from either surface to the other (Hausdorff), sampled at all vertices,
/// edge middles and triangle centroids of both.
pub fn hausdorff(one: &TriangleMesh, other: &TriangleMesh) -> f32 {
    farthest(one, &SurfaceBvh::new(other)).max(farthest(other, &SurfaceBvh::new(one)))
}

fn farthest(from: &TriangleMesh, to: &SurfaceBvh) -> f32 {
    (0..from.triangles.len())
        .into_par_iter()
        .map(|triangle| {
            let [a, b, c] = from.corners(triangle);
            let samples = [
                a,
                b,
                c,
                a.midpoint(b),
                b.midpoint(c),
                c.midpoint(a),
                (a + b + c) / 3.0,
            ];
            let distance = |p: Vec3| to.nearest(p).map_or(0.0, |near| near.position.distance(p));
            samples.into_iter().map(distance).fold(0.0, f32::max)
        })
        .reduce(|| 0.0, f32::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    #[test]
    fn a_grid_of_squares_has_known_measures() {
        let mesh = shapes::grid(200, 200, 1.0);
        let found = evenness(&mesh);
        assert!((found.smallest_angle_of_99_percent - 45.0).abs() < 1e-6);
        assert!((found.mean_edge - (2.0 + 2f64.sqrt()) / 3.0).abs() < 0.01);
    }

    #[test]
    fn distances_count_both_ways() {
        let plate = shapes::grid(4, 4, 1.0);
        let mut larger = shapes::grid(6, 4, 1.0);
        assert_eq!(hausdorff(&plate, &larger), 2.0);
        assert_eq!(hausdorff(&larger, &plate), 2.0);
        larger.positions.iter_mut().for_each(|p| p.z = 0.5);
        assert!((hausdorff(&plate, &larger) - 4.25f32.sqrt()).abs() < 1e-6);
    }
}
