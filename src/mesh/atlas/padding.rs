//! Texels outside charts, and the texels inside that continue the surface there.

use glam::Vec3;
use rayon::prelude::*;

use super::charts::Atlas;
use super::texel_points::{TexelPoints, ring};
use crate::mesh::geodesic::Geodesics;
use crate::mesh::surface_bvh::{SurfaceBvh, SurfacePoint};
use crate::mesh::topology::Topology;
use crate::mesh::triangle_mesh::TriangleMesh;

/// For every texel outside charts within `reach` texels of one: (it, a texel inside that stands for it).
///
/// Where the surface continues across the chart's border, that is the texel nearest to the place on the surface that
/// lies as far beyond the border; elsewhere the nearest texel of the chart.
pub fn padding(
    points: &TexelPoints,
    atlas: &Atlas,
    mesh: &TriangleMesh,
    reach: u32,
) -> Vec<(u32, u32)> {
    let topology = Topology::new(&mesh.triangles);
    let across = Across::new(points, atlas, mesh, &topology);
    (0..points.triangle.len())
        .into_par_iter()
        .filter(|&texel| !points.is_inside(texel))
        .filter_map(|texel| {
            let nearest = nearest_inside(points, texel, reach)?;
            let inside = across.texel_beyond(nearest, texel).unwrap_or(nearest);
            Some((texel as u32, inside as u32))
        })
        .collect()
}

/// The texel inside a chart nearest to one, no farther than `reach`; ties to the first.
fn nearest_inside(points: &TexelPoints, texel: usize, reach: u32) -> Option<usize> {
    let width = points.width as usize;
    let (row, column) = ((texel / width) as i64, (texel % width) as i64);
    let mut best: Option<(i64, usize)> = None;
    for reach in 1..=i64::from(reach) {
        if best.is_some_and(|(square, _)| square <= reach * reach) {
            break;
        }
        for [drow, dcolumn] in ring(reach) {
            let other = points.texel_at(row + drow, column + dcolumn);
            if let Some(other) = other.filter(|&other| points.is_inside(other)) {
                let found = (drow * drow + dcolumn * dcolumn, other);
                best = Some(best.map_or(found, |best| best.min(found)));
            }
        }
    }
    let farthest = i64::from(reach) * i64::from(reach);
    best.filter(|&(square, _)| square <= farthest)
        .map(|(_, other)| other)
}

/// Finds the texels on the far side of charts' borders.
pub struct Across<'a> {
    points: &'a TexelPoints,
    atlas: &'a Atlas,
    geodesics: Geodesics<'a>,
    /// The texels inside charts, and a small piece of the surface at each.
    inside: Vec<u32>,
    tree: SurfaceBvh,
}

/// The size of the piece of surface that stands for a texel, as a share of the mean texel's.
const PIECE: f64 = 0.01;

impl<'a> Across<'a> {
    /// For the texels of one image.
    pub fn new(
        points: &'a TexelPoints,
        atlas: &'a Atlas,
        mesh: &'a TriangleMesh,
        topology: &'a Topology,
    ) -> Self {
        let inside = |&texel: &u32| points.is_inside(texel as usize);
        let inside: Vec<u32> = (0..points.triangle.len() as u32).filter(inside).collect();
        let size = PIECE * (mesh.area() / inside.len().max(1) as f64).sqrt();
        let pieces: Vec<[Vec3; 3]> = inside
            .par_iter()
            .map(|&texel| piece(points, mesh, texel as usize, size as f32))
            .collect();
        Self {
            points,
            atlas,
            geodesics: Geodesics { mesh, topology },
            inside,
            tree: SurfaceBvh::of_corners(&pieces),
        }
    }

    /// The texel inside a chart that lies where texel `place` would lie if the chart of texel `from` went on;
    /// `None` where the surface ends.
    pub fn texel_beyond(&self, from: usize, place: usize) -> Option<usize> {
        let start = self.points.surface_point(self.geodesics.mesh, from);
        self.nearest_texel(&self.beyond(&start, self.points.centre(place))?)
    }

    /// The surface point at a texture coordinate of the chart of `start`, were the chart to continue: along a
    /// straight line, with the texture's scale at `start`.
    pub fn beyond(&self, start: &SurfacePoint, uv: glam::DVec2) -> Option<SurfacePoint> {
        let step = uv - self.atlas.uv(start);
        let [along_u, along_v] = self
            .atlas
            .jacobian(self.geodesics.mesh, start.triangle as usize);
        let way = along_u * step.x + along_v * step.y;
        self.geodesics
            .trace(start, way.as_vec3(), way.length() as f32)
    }

    /// The texel of any chart that lies nearest to a surface point in space, on the side that faces as the
    /// surface does there.
    pub fn nearest_texel(&self, point: &SurfacePoint) -> Option<usize> {
        let corners = self.geodesics.mesh.corners(point.triangle as usize);
        let nearest = self.tree.nearest_alike(point.position, &corners)?;
        Some(self.inside[nearest.triangle as usize] as usize)
    }
}

/// A triangle of the surface at a texel, with legs of length `size`.
fn piece(points: &TexelPoints, mesh: &TriangleMesh, texel: usize, size: f32) -> [Vec3; 3] {
    let at = points.surface_point(mesh, texel);
    let [a, b, c] = mesh.corners(at.triangle as usize);
    let x = (b - a).normalize_or_zero();
    let y = (c - a).reject_from_normalized(x).normalize_or_zero();
    [(-1.0, -1.0), (2.0, -1.0), (-1.0, 2.0)]
        .map(|(along, across)| at.position + (x * along + y * across) * (size / 3.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;
    use crate::mesh::topology::NONE;
    use glam::Vec2;

    /// A flat strip of 16 × 8 units, cut in the middle; the halves lie one above the other in the texture.
    fn cut_strip() -> (TriangleMesh, Atlas) {
        let mesh = shapes::grid(16, 8, 1.0);
        let uvs: Vec<_> = (0..mesh.triangles.len())
            .map(|t| {
                let middle: Vec3 = mesh.corners(t).iter().sum::<Vec3>() / 3.0;
                let at = match middle.x < 8.0 {
                    true => Vec2::new(4.0, 4.0),
                    false => Vec2::new(4.0 - 8.0, 20.0),
                };
                mesh.corners(t)
                    .map(|corner| (corner.truncate() + at) / 32.0)
            })
            .collect();
        let atlas = Atlas::of_uvs(&mesh, &uvs).unwrap();
        (mesh, atlas)
    }

    #[test]
    fn texels_across_the_border_continue_the_surface() {
        let (mesh, atlas) = cut_strip();
        assert_eq!(atlas.charts, 2);
        let points = TexelPoints::new(&mesh, &atlas, 32, 32).unwrap();
        let pairs = padding(&points, &atlas, &mesh, 3);
        let position = |texel: usize| points.surface_point(&mesh, texel).position;
        let mut crossed = 0;
        for &(outside, inside) in &pairs {
            let (outside, inside) = (outside as usize, inside as usize);
            assert_eq!(
                (points.triangle[outside], points.triangle[inside] == NONE),
                (NONE, false)
            );
            let uv = points.centre(outside).as_vec2() * 32.0;
            // The lower half continues to the right, the upper one to the left.
            let lower = uv.y < 16.0;
            let right = lower && uv.x > 12.0 && (4.0..12.0).contains(&uv.y);
            let left = !lower && uv.x < 4.0 && (20.0..28.0).contains(&uv.y);
            if right || left {
                let at = match lower {
                    true => uv - 4.0,
                    false => uv - Vec2::new(-4.0, 20.0),
                };
                let apart = position(inside).truncate().distance(at);
                assert!(apart < 1e-4, "{uv} {apart}");
                crossed += 1;
            } else {
                let own = nearest_inside(&points, outside, 3).unwrap();
                assert_eq!(own, inside, "{uv}");
            }
        }
        assert_eq!(crossed, 2 * 3 * 8);
        assert!(pairs.windows(2).all(|pair| pair[0].0 < pair[1].0));
        // Each half is padded on all sides; corners are rounded.
        let around = 4 * 3 * 8 + 4 * 4;
        assert_eq!(pairs.len(), 2 * around);
    }
}
