//! The charts of a mesh's texture coordinates: triangles that are connected in the texture, separated by seams.

use glam::Vec2;

use crate::mesh::topology::{NONE, Topology, find, join, next};
use crate::mesh::triangle_mesh::TriangleMesh;

/// A mesh's texture coordinates, chart by chart.
pub struct TextureCharts<'a> {
    /// Texture coordinates of each triangle's corners.
    pub uvs: &'a [[Vec2; 3]],
    /// The chart of each triangle; [`NONE`] without texture coordinates.
    pub charts: Vec<u32>,
    /// Half-edges across which the texture does not continue.
    pub seams: Vec<bool>,
}

impl<'a> TextureCharts<'a> {
    /// Finds the charts: triangles belong together where an edge has the same coordinates on both sides.
    pub fn new(triangles: &[[u32; 3]], uvs: &'a [[Vec2; 3]]) -> Self {
        let topology = Topology::new(triangles);
        let corner = |half_edge: u32| uvs[half_edge as usize / 3][half_edge as usize % 3];
        let mut root: Vec<u32> = (0..triangles.len() as u32).collect();
        let mut seams = vec![false; topology.opposite.len()];
        for (half_edge, &twin) in topology.opposite.iter().enumerate() {
            if twin == NONE {
                continue;
            }
            let edge = half_edge as u32;
            // NaN is equal to nothing: triangles without coordinates are charts of their own.
            let goes_on = corner(edge) == corner(next(twin)) && corner(next(edge)) == corner(twin);
            match goes_on {
                true => join(&mut root, edge / 3, twin / 3),
                false => seams[half_edge] = has_uvs(uvs, edge) || has_uvs(uvs, twin),
            }
        }
        let charts = (0..triangles.len() as u32)
            .map(|t| match has_uvs(uvs, 3 * t) {
                true => find(&mut root, t),
                false => NONE,
            })
            .collect();
        Self { uvs, charts, seams }
    }

    /// How many charts there are.
    pub fn count(&self) -> usize {
        let mut charts: Vec<u32> = self.charts.iter().copied().filter(|&c| c != NONE).collect();
        charts.sort_unstable();
        charts.dedup();
        charts.len()
    }

    /// The length of all seams on their mesh, each counted once.
    pub fn seam_length(&self, mesh: &TriangleMesh) -> f64 {
        let seams = self.seams.iter().enumerate().filter(|(_, seam)| **seam);
        let length = |(half_edge, _): (usize, &bool)| {
            let corners = mesh.corners(half_edge / 3);
            f64::from(corners[half_edge % 3].distance(corners[(half_edge + 1) % 3]))
        };
        0.5 * seams.map(length).sum::<f64>()
    }
}

fn has_uvs(uvs: &[[Vec2; 3]], half_edge: u32) -> bool {
    uvs[half_edge as usize / 3].iter().all(|uv| uv.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seams_part_charts() {
        let triangles = [[0, 1, 2], [2, 1, 3], [2, 3, 4]];
        let corner = |v: u32| Vec2::new(v as f32, 0.0);
        let mut uvs = triangles.map(|t| t.map(corner));
        assert_eq!(TextureCharts::new(&triangles, &uvs).count(), 1);
        uvs[2] = uvs[2].map(|uv| uv + Vec2::Y);
        let charts = TextureCharts::new(&triangles, &uvs);
        assert_eq!(charts.count(), 2);
        assert_eq!(charts.seams.iter().filter(|&&seam| seam).count(), 2);
        uvs[2][0] = Vec2::NAN;
        let charts = TextureCharts::new(&triangles, &uvs);
        assert_eq!((charts.count(), charts.charts[2]), (1, NONE));
    }
}
