//! A texel for a chart that contains no texel's centre.

use glam::{DVec2, Vec3};

use super::charts::Atlas;
use super::texel_points::{TexelPoints, ring};
use crate::mesh::surface_bvh::{SurfacePoint, nearest_in_triangle};
use crate::mesh::triangle_mesh::TriangleMesh;

/// A chart that contains no texel's centre.
pub(super) struct StrayChart {
    pub(super) chart: u32,
    /// Its centre of area in the texture.
    centre: DVec2,
    triangles: Vec<u32>,
}

/// The charts without a texel, ascending.
pub(super) fn find(mesh: &TriangleMesh, atlas: &Atlas, points: &TexelPoints) -> Vec<StrayChart> {
    let mut has_texel = vec![false; atlas.charts];
    for texel in 0..points.triangle.len() {
        if let Some(chart) = points.chart(atlas, texel) {
            has_texel[chart as usize] = true;
        }
    }
    let mut triangles_of: Vec<Vec<u32>> = vec![Vec::new(); atlas.charts];
    for triangle in 0..mesh.triangles.len() {
        let chart = atlas.chart_of[triangle] as usize;
        if !has_texel[chart] {
            triangles_of[chart].push(triangle as u32);
        }
    }
    let strays = triangles_of.into_iter().enumerate();
    strays
        .filter(|(_, triangles)| !triangles.is_empty())
        .map(|(chart, triangles)| StrayChart {
            chart: chart as u32,
            centre: centre_of(atlas, &triangles),
            triangles,
        })
        .collect()
}

/// The centre of area of some triangles in the texture.
fn centre_of(atlas: &Atlas, triangles: &[u32]) -> DVec2 {
    let (mut sum, mut whole) = (DVec2::ZERO, 0.0);
    for &triangle in triangles {
        let [a, b, c] = atlas.corners(triangle as usize);
        let area = (b - a).perp_dot(c - a).abs();
        sum += area * (a + b + c) / 3.0;
        whole += area;
    }
    match whole > 0.0 {
        true => sum / whole,
        false => atlas.corners(triangles[0] as usize)[0],
    }
}

impl StrayChart {
    /// The texel nearest the chart's centre.
    pub(super) fn nearest_texel(&self, points: &TexelPoints) -> usize {
        let [row, column] = self.nearest(points);
        row as usize * points.width as usize + column as usize
    }

    fn nearest(&self, points: &TexelPoints) -> [i64; 2] {
        let place = points.place(self.centre).round();
        let within = |at: f64, end: u32| at.clamp(0.0, f64::from(end - 1)) as i64;
        [
            within(place.y, points.height),
            within(place.x, points.width),
        ]
    }

    /// The texel of no chart nearest the chart's centre; ties to the first.
    pub(super) fn nearest_free_texel(&self, points: &TexelPoints) -> Option<usize> {
        let [row, column] = self.nearest(points);
        let place = points.place(self.centre);
        let farthest = i64::from(points.width.max(points.height));
        let mut best: Option<(f64, usize)> = None;
        for reach in 0..=farthest {
            // Texels of this ring are no nearer than reach − 1/2.
            if best.is_some_and(|(distance, _)| distance < (reach as f64 - 0.5).max(0.0)) {
                break;
            }
            for [drow, dcolumn] in ring(reach) {
                let (row, column) = (row + drow, column + dcolumn);
                let texel = points.texel_at(row, column);
                let Some(texel) = texel.filter(|&t| !points.is_inside(t)) else {
                    continue;
                };
                let distance = place.distance(DVec2::new(column as f64, row as f64));
                if best.is_none_or(|held| (distance, texel) < held) {
                    best = Some((distance, texel));
                }
            }
        }
        best.map(|(_, texel)| texel)
    }

    /// The point of the chart that is nearest a texel's centre in the texture.
    pub(super) fn point_at(
        &self,
        atlas: &Atlas,
        mesh: &TriangleMesh,
        points: &TexelPoints,
        texel: usize,
    ) -> SurfacePoint {
        let centre = points.centre(texel);
        let mut best = (f32::INFINITY, self.triangles[0], [1.0, 0.0, 0.0]);
        for &triangle in &self.triangles {
            let corners = atlas.corners(triangle as usize);
            let flat = corners.map(|corner| (corner - centre).as_vec2().extend(0.0));
            let (weights, place) = nearest_in_triangle(Vec3::ZERO, &flat);
            if place.length_squared() < best.0 {
                best = (place.length_squared(), triangle, weights);
            }
        }
        let (_, triangle, weights) = best;
        let corners = mesh.corners(triangle as usize);
        SurfacePoint {
            triangle,
            weights,
            position: (0..3).map(|k| corners[k] * weights[k]).sum(),
        }
    }
}
