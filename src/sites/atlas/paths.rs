//! Straight paths over smoothed geometry from one site to the samples of its neighbourhood (Ying 2001 §4.1).

use glam::{Quat, Vec2, Vec3};

use super::geometry::Geometry;
use super::texels::LevelTexels;
use crate::error::Result;
use crate::mesh::geodesic::Geodesics;
use crate::mesh::smoothing::smoothed;
use crate::mesh::surface_bvh::SurfacePoint;
use crate::mesh::triangle_mesh::TriangleMesh;
use crate::progress::Progress;

/// Detail smaller than this share of a texel is smoothed away. The paper leaves it open.
const SMOOTHED: f32 = 0.5;

/// The mesh that is marched on at a level; `texel` is the level's, in mesh units.
pub fn marched_mesh(
    geometry: &Geometry<'_>,
    texel: f64,
    progress: Progress<'_>,
) -> Result<TriangleMesh> {
    let distance = SMOOTHED * texel as f32;
    smoothed(geometry.mesh, &geometry.rings, distance, progress)
}

/// Paths from one site.
pub struct Paths<'a> {
    geodesics: Geodesics<'a>,
    mesh: &'a TriangleMesh,
    from: SurfacePoint,
    /// Directions of the texture on the triangle of departure.
    along: [Vec3; 2],
    spacing: f32,
}

impl<'a> Paths<'a> {
    /// From a site over a smoothed copy of the mesh.
    pub fn new(
        (geometry, marched): (&'a Geometry<'_>, &'a TriangleMesh),
        level: &LevelTexels,
        site: usize,
    ) -> Self {
        let geodesics = Geodesics {
            mesh: marched,
            topology: &geometry.topology,
        };
        let from = level.point(geometry, site);
        let frame = level.frames[site];
        let normal = geodesics
            .mesh
            .area_normal(from.triangle as usize)
            .normalize_or(frame.n);
        let turn = Quat::from_rotation_arc(frame.n, normal);
        Self {
            geodesics,
            mesh: geometry.mesh,
            from,
            along: [turn * frame.s, turn * frame.t],
            spacing: level.spacing[site],
        }
    }

    /// The end of the path to a sample; `None` beyond the surface.
    pub fn end(&self, offset: Vec2) -> Option<SurfacePoint> {
        let direction = self.along[0] * offset.x + self.along[1] * offset.y;
        let length = offset.length() * self.spacing;
        let end = self.geodesics.trace(&self.from, direction, length)?;
        let corners = self.mesh.corners(end.triangle as usize);
        Some(SurfacePoint {
            position: (0..3).map(|k| corners[k] * end.weights[k]).sum(),
            ..end
        })
    }
}
