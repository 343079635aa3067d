//! Colours at given points of the surface, as the texels of a texture map show them.
//!
//! Shading is that of pixels (`pixel_shading`), but coarser levels of the sample are chosen by the side of a
//! texel: a texture map is filtered once more by whatever draws it.

use rayon::prelude::*;

use crate::error::Result;
use crate::render::known_weights::KnownWeights;
use crate::render::pixel_shading::{Workspace, shade};
use crate::render::plan::PlannedFrame;
use crate::render::raster::Hit;
use crate::render::renderer::Renderer;
use crate::render::vertex_shading::Scene;
use crate::render::vertex_shadows::VertexShadows;

/// Points that one task shades.
const CHUNK: usize = 1 << 10;

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
        let progress = self.progress();
        let shadows = &mut VertexShadows::default();
        let of_vertices = self.visibility_of_all(&frame.lights, shadows);
        let visibility = self.pixel_visibility(&of_vertices);
        let scene = Scene {
            shows_inside: false,
            ..self.scene(&frame.view, &frame.lights, KnownWeights::default())
        };
        progress.begin("texels", hits.len() as u64);
        let mut colors = vec![[0.0; 3]; hits.len()];
        colors
            .par_chunks_mut(CHUNK)
            .zip(hits.par_chunks(CHUNK))
            .try_for_each_init(Workspace::default, |work, (colors, hits)| {
                let Workspace { points, shading } = work;
                for (color, hit) in colors.iter_mut().zip(hits) {
                    if !hit.is_surface() {
                        continue;
                    }
                    points.forget();
                    let mut point = points.see(&scene, hit);
                    let vertices = scene.map.mesh.triangles[hit.triangle as usize];
                    for (corner, vertex) in point.corners.iter_mut().zip(vertices) {
                        let ratio = texel / scene.map.texel_at(vertex as usize);
                        corner.detail = ratio.log2().max(0.0) as f32;
                    }
                    let shaded = shade(&scene, visibility, &point, points, shading);
                    *color = shaded.color.truncate().to_array();
                }
                progress.advance(hits.len() as u64)
            })?;
        progress.end();
        Ok(colors)
    }
}
