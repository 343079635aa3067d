//! The bake of a surface texton map, onto a mesh with texture coordinates.

use crate::btf::sample::Sample;
use crate::cli::bake_maps::Arguments;
use crate::cli::bake_maps::target::TexturedTarget;
use crate::cli::outcome::Outcome;
use crate::cli::session::Session;
use crate::cli::transfer::describe;
use crate::error::Result;
use crate::format::id::ContentId;
use crate::maps::vertex_map::SurfaceTextonMap;
use crate::mesh::atlas::padding;
use crate::render::sweep::{Inputs, with_renderer};
use crate::textures::folder::write_set;
use crate::textures::model::{ModelOptions, Subject};
use crate::textures::transfer::PADDED;

impl Arguments {
    pub(super) fn bake_map(&self, sample: &Sample, session: &Session) -> Result<Outcome> {
        let (progress, side) = (session.progress(), self.resolution());
        // Lay out the texels, and find the point of the map that each shows.
        let map = SurfaceTextonMap::read(&self.map)?;
        self.check_memory(side, sample)?;
        let target = TexturedTarget::new(&map, self.mesh.as_deref(), self.unwrap, side, progress)?;
        let placed = target.placed(&map, progress)?;
        let inside = target.points.inside();
        // Shade these points.
        let texel = (target.surface.mesh.area() / inside.max(1) as f64).sqrt();
        let inputs = Inputs {
            sample,
            map: &map,
            map_id: &ContentId::of_file(&self.map)?,
            cover: None,
            folder: crate::format::atomic::parent(&self.output),
            force: self.force,
        };
        let (colors, parallax) = with_renderer(
            &inputs,
            &self.shading(),
            progress,
            |renderer, frames| match frames.first() {
                Some(frame) => renderer.texel_colors(frame, &placed.hits, texel),
                None => Ok(Vec::new()),
            },
        )?;
        // Write the padded textures and the model.
        let pairs = padding(&target.points, &target.atlas, &target.surface.mesh, PADDED);
        let is_inside = |texel| target.points.is_inside(texel);
        let textures = self.textures([side; 2], colors, &pairs, is_inside);
        let subject = Subject {
            surface: &target.surface,
            origin: map.header.origin,
            texel,
            is_lit: true,
        };
        let model = ModelOptions::default();
        let (folder, from) = (&self.output, &map.header.sample);
        let written = write_set(folder, &subject, from, &textures, &model, progress)?;
        // Tell what was made.
        Ok(describe(&written, folder)
            .line(parallax.describe())
            .figure("parallax", parallax.heights.is_some())
            .line(format!(
                "{inside} texels in {} charts, {texel:.4} mesh units each",
                target.atlas.charts
            ))
            .line(format!(
                "no texel lies farther than {:.2e} mesh units from the map's surface",
                placed.farthest
            ))
            .figure("texels", inside)
            .figure("charts", target.atlas.charts)
            .figure("texel", texel)
            .figure("farthest", placed.farthest))
    }
}
