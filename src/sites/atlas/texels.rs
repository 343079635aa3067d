//! The texels of one level: which are sites, where they lie, and how the texture lies there.

use glam::Vec3;
use rayon::prelude::*;

use super::geometry::Geometry;
use crate::mesh::atlas::TexelPoints;
use crate::mesh::frame::Frame;
use crate::mesh::surface_bvh::SurfacePoint;
use crate::mesh::topology::NONE;

/// The texels of one level.
#[derive(Clone, Debug, PartialEq)]
pub struct LevelTexels {
    /// The surface point of every texel.
    pub points: TexelPoints,
    /// The texel of each site, ascending.
    pub texels: Vec<u32>,
    /// The site of each texel, [`NONE`] outside all charts.
    pub sites: Vec<u32>,
    /// Where each site lies.
    pub positions: Vec<Vec3>,
    /// Each site's texture frame.
    pub frames: Vec<Frame>,
    /// Mesh units per texel of the texture at each site, on this level, its scale included.
    pub spacing: Vec<f32>,
}

impl LevelTexels {
    /// The texels of a level; one texel of the texture is `texel` mesh units where the scale is 1.
    pub fn new(geometry: &Geometry<'_>, points: TexelPoints, texel: f64) -> Self {
        let inside = |&texel: &u32| points.is_inside(texel as usize);
        let texels: Vec<u32> = (0..points.triangle.len() as u32).filter(inside).collect();
        let mut sites = vec![NONE; points.triangle.len()];
        for (site, &texel) in texels.iter().enumerate() {
            sites[texel as usize] = site as u32;
        }
        let at = |&texel: &u32| points.surface_point(geometry.mesh, texel as usize);
        let positions = texels.par_iter().map(|texel| at(texel).position).collect();
        let frames = texels
            .par_iter()
            .map(|texel| geometry.frame(&at(texel)))
            .collect();
        let spacing = texels
            .par_iter()
            .map(|of| texel as f32 * geometry.scale_at(&at(of)))
            .collect();
        Self {
            points,
            texels,
            sites,
            positions,
            frames,
            spacing,
        }
    }

    /// The surface point of a site.
    pub fn point(&self, geometry: &Geometry<'_>, site: usize) -> SurfacePoint {
        let texel = self.texels[site] as usize;
        self.points.surface_point(geometry.mesh, texel)
    }

    /// The chart of a site.
    pub fn chart(&self, geometry: &Geometry<'_>, site: usize) -> u32 {
        let triangle = self.points.triangle[self.texels[site] as usize];
        geometry.atlas.chart_of[triangle as usize]
    }

    /// The surface area of each site's texel, in mesh units squared.
    pub fn areas(&self, geometry: &Geometry<'_>) -> Vec<f32> {
        let texels = f64::from(self.points.width) * f64::from(self.points.height);
        let area = |&texel: &u32| {
            let triangle = self.points.triangle[texel as usize] as usize;
            let [along_u, along_v] = geometry.atlas.jacobian(geometry.mesh, triangle);
            (along_u.cross(along_v).length() / texels) as f32
        };
        self.texels.par_iter().map(area).collect()
    }

    /// A vector from a site in its (s, t) plane, in texels of the texture.
    pub fn seen_from(&self, site: usize, vector: Vec3) -> [f32; 2] {
        let seen = self.frames[site].frame_from_mesh(vector) / self.spacing[site];
        [seen.x, seen.y]
    }
}
