//! The faces of one level.

use glam::Vec3;
use rayon::prelude::*;

use crate::mesh::topology::{NONE, Topology};
use crate::mesh::triangle_mesh::TriangleMesh;

/// The triangles of a mesh, each a site.
#[derive(Clone, Debug, PartialEq)]
pub struct FaceLevel {
    /// The mesh; a face is a triangle of it.
    pub mesh: TriangleMesh,
    /// Neighbours across edges.
    pub topology: Topology,
    /// Whether each face is white; no two faces across an edge are alike.
    pub white: Vec<bool>,
    /// Barycentres, in mesh units.
    pub centers: Vec<Vec3>,
    /// Areas, in mesh units squared.
    pub areas: Vec<f32>,
}

/// Distances between the centres of faces that share an edge, in mesh units.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AdjacentDistances {
    /// Their mean; 0 for faces that share no edge.
    pub mean: f64,
    /// The largest; 0 for faces that share no edge.
    pub largest: f64,
}

/// Half-edges summed by one thread.
const BLOCK: usize = 1 << 14;

impl FaceLevel {
    /// The faces of a manifold mesh and their two colours.
    pub fn new(mesh: TriangleMesh, white: Vec<bool>) -> Self {
        let faces = (0..mesh.triangles.len()).into_par_iter();
        let measured = faces.map(|face| {
            let center = mesh.corners(face).into_iter().sum::<Vec3>() / 3.0;
            let area = 0.5 * mesh.area_normal_f64(face).length();
            (center, area as f32)
        });
        let (centers, areas) = measured.unzip();
        Self {
            topology: Topology::new(&mesh.triangles),
            mesh,
            white,
            centers,
            areas,
        }
    }

    /// Faces in all.
    pub fn count(&self) -> usize {
        self.mesh.triangles.len()
    }

    /// The distance between the centres of two faces, in mesh units.
    #[inline]
    pub fn distance(&self, one: usize, other: usize) -> f64 {
        let [one, other] = [one, other].map(|face| self.centers[face].as_dvec3());
        one.distance(other)
    }

    /// How far apart faces are that share an edge.
    pub fn adjacent_distances(&self) -> AdjacentDistances {
        let of_block = |(block, twins): (usize, &[u32])| {
            let (mut sum, mut count, mut largest) = (0.0, 0u64, 0f64);
            for (index, &twin) in twins.iter().enumerate() {
                let half_edge = block * BLOCK + index;
                if twin != NONE && half_edge < twin as usize {
                    let distance = self.distance(half_edge / 3, twin as usize / 3);
                    sum += distance;
                    count += 1;
                    largest = largest.max(distance);
                }
            }
            (sum, count, largest)
        };
        let blocks = self.topology.opposite.par_chunks(BLOCK).enumerate();
        let blocks: Vec<(f64, u64, f64)> = blocks.map(of_block).collect();
        let sum: f64 = blocks.iter().map(|block| block.0).sum();
        let count: u64 = blocks.iter().map(|block| block.1).sum();
        AdjacentDistances {
            mean: if count > 0 { sum / count as f64 } else { 0.0 },
            largest: blocks.iter().map(|block| block.2).fold(0.0, f64::max),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    #[test]
    fn squares_cut_in_two_have_their_distances() {
        let level = FaceLevel::new(shapes::grid(3, 2, 3.0), vec![true; 12]);
        assert_eq!(level.count(), 12);
        assert!(level.areas.iter().all(|&area| area == 4.5));
        assert!(level.centers[0].distance(Vec3::new(2.0, 1.0, 0.0)) < 1e-6);
        // Across a diagonal √2, across a side √5: 6 diagonals, 7 inner sides.
        let distances = level.adjacent_distances();
        let mean = (6.0 * 2f64.sqrt() + 7.0 * 5f64.sqrt()) / 13.0;
        assert!((distances.mean - mean).abs() < 1e-6);
        assert!((distances.largest - 5f64.sqrt()).abs() < 1e-6);
    }
}
