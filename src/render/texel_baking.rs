//! Colours at given points of the surface, as the texels of a texture map show them.
//!
//! Shading is that of pixels (`pixel_shading`) where points lie between the vertices of a map, and that of vertices
//! (`vertex_shading`) where points have texture coordinates of their own. Coarser levels of the sample are chosen
//! by the side of a texel in both: a texture map is filtered once more by whatever draws it.

use glam::{Vec3, Vec4};
use rayon::prelude::*;

use crate::error::Result;
use crate::maps::vertex_map::SurfaceTextonMap;
use crate::progress::Progress;
use crate::render::cover::Cover;
use crate::render::fill::RAYS;
use crate::render::known_weights::KnownWeights;
use crate::render::light::Light;
use crate::render::occlusion::{Occluders, RayOrigin};
use crate::render::parallax::PatchReach;
use crate::render::pixel_shading::{Workspace, shade_hit};
use crate::render::plan::PlannedFrame;
use crate::render::raster::Hit;
use crate::render::renderer::Renderer;
use crate::render::vertex_shading::{ShadingScene, shade, sites_of};
use crate::render::vertex_shadows::VertexShadows;

/// Points that one task shades.
const CHUNK: usize = 1 << 10;
/// Lights that points of their own are shaded by in one go: bounds the memory for what reaches them.
const LIGHTS_AT_ONCE: usize = 8;

/// Points of the surface that have texture coordinates of their own.
#[derive(Clone, Copy)]
pub struct OwnPoints<'a> {
    /// The points as vertices, without triangles.
    pub map: &'a SurfaceTextonMap,
    /// The normal of the flat triangle that each lies on, of any length.
    pub facets: &'a [Vec3],
    /// A plain colour below the texture, where it is transparent; with an entry per point.
    pub cover: Option<&'a Cover>,
    /// Pairs of points that lie side by side on the surface, each once.
    pub neighbors: &'a [[u32; 2]],
}

impl Renderer<'_> {
    /// Linear radiance, red to blue, at each point for a frame's view and lights; black where nothing is hit.
    /// `texel` is the side of a texel in mesh units. Points that face away from the view are shaded as it
    /// grazes them.
    pub fn texel_colors(
        &self,
        frame: &PlannedFrame,
        hits: &[Hit],
        texel: f64,
    ) -> Result<Vec<[f32; 3]>> {
        // Set up the scene.
        let progress = self.progress();
        let shadows = &mut VertexShadows::default();
        let of_vertices = self.visibility_of_all(&frame.lights, shadows);
        let visibility = self.pixel_visibility(&of_vertices);
        let scene = ShadingScene {
            side: Some(texel),
            shows_inside: false,
            ..self.scene(&frame.view, &frame.lights, KnownWeights::default())
        };
        // Shade chunks of texels in parallel.
        progress.begin("texels", hits.len() as u64);
        let mut colors = vec![[0.0; 3]; hits.len()];
        colors
            .par_chunks_mut(CHUNK)
            .zip(hits.par_chunks(CHUNK))
            .try_for_each_init(Workspace::default, |work, (colors, hits)| {
                for (color, hit) in colors.iter_mut().zip(hits) {
                    if hit.is_surface() {
                        let shaded = shade_hit(&scene, visibility, hit, work);
                        *color = shaded.color.truncate().to_array();
                    }
                }
                progress.advance(hits.len() as u64)
            })?;
        progress.end();
        Ok(colors)
    }

    /// The same at points of their own, each from its own texture coordinate, which nothing mixes with those of its
    /// neighbours. The renderer's map casts the shadows, found at each point.
    pub fn point_colors(
        &self,
        frame: &PlannedFrame,
        points: OwnPoints<'_>,
        texel: f64,
    ) -> Result<Vec<[f32; 3]>> {
        // Set up the scene with the points' own surroundings.
        let progress = self.progress();
        let patches = self
            .has_parallax()
            .then(|| PatchReach::of_edges(points.map, points.neighbors));
        let found = self.scene(&frame.view, &frame.lights, KnownWeights::default());
        let open = found.openness.and(found.occluders);
        let open = open.map(|occluders| openness_of(occluders, points, progress));
        let whole = ShadingScene {
            patches: patches.as_ref(),
            map: points.map,
            cover: points.cover,
            openness: open.as_deref(),
            side: Some(texel),
            ..found
        };
        // Shade some lights at a time, so that their visibilities fit into memory.
        let sites = sites_of(points.map, whole.lookup.grid(), |_| true);
        let mut colors = vec![Vec4::ZERO; sites.len()];
        progress.begin("texels", frame.lights.len() as u64);
        for (part, lights) in frame.lights.chunks(LIGHTS_AT_ONCE).enumerate() {
            let scene = ShadingScene {
                lights,
                fill: whole.fill.filter(|_| part == 0),
                ..whole
            };
            let reaches: Vec<Vec<f32>> = lights
                .iter()
                .map(|light| reaches(&scene, points.facets, light))
                .collect();
            progress.check()?;
            let reaches: Vec<&[f32]> = reaches.iter().map(Vec::as_slice).collect();
            for (site, shaded) in sites.iter().zip(shade(&scene, &reaches, &sites)) {
                colors[site.vertex as usize] += shaded;
            }
            progress.advance(lights.len() as u64)?;
        }
        progress.end();
        Ok(colors
            .into_iter()
            .map(|color| color.truncate().to_array())
            .collect())
    }
}

/// The open share of the hemisphere above the triangle that each point lies on.
fn openness_of(occluders: &Occluders, points: OwnPoints, progress: Progress<'_>) -> Vec<f32> {
    let all = points.map.mesh.positions.par_iter().zip(points.facets);
    let open = |(turn, (&point, facet)): (usize, (&Vec3, &Vec3))| {
        if progress.is_interrupted() {
            return 1.0;
        }
        let normal = facet.normalize_or(points.map.normals[turn]);
        occluders.openness(point, normal, RayOrigin::Point, RAYS, turn as u32)
    };
    all.enumerate().with_min_len(CHUNK).map(open).collect()
}

/// The share of a light that reaches each point, by rays that leave the side of its triangle that faces the light.
fn reaches(scene: &ShadingScene, facets: &[Vec3], light: &Light) -> Vec<f32> {
    let points = scene.map.mesh.positions.par_iter().zip(facets).enumerate();
    let reaches = |(turn, (&point, facet)): (usize, (&Vec3, &Vec3))| {
        let incidence = light.at(point);
        let is_lit = scene.map.normals[turn].dot(incidence.towards) > 0.0;
        if !is_lit || scene.progress.is_interrupted() {
            return 0.0;
        }
        let facet = facet.normalize_or_zero();
        let side = match facet.dot(incidence.towards) < 0.0 {
            true => -facet,
            false => facet,
        };
        let (ray_origin, turn) = (RayOrigin::Point, turn as u32);
        scene.visibility(light, &incidence, point, side, ray_origin, turn)
    };
    points.with_min_len(CHUNK).map(reaches).collect()
}
