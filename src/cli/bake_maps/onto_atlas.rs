//! The bake of an atlas, into its own texels: each is shaded by its own texture coordinate.

use crate::btf::sample::Sample;
use crate::cli::atlas::{AtlasInput, Look};
use crate::cli::bake_maps::Arguments;
use crate::cli::outcome::Outcome;
use crate::cli::session::Session;
use crate::cli::transfer::describe;
use crate::error::Result;
use crate::render::memory::table_bytes;
use crate::render::parallax::Decision;
use crate::render::sweep::{Inputs, with_renderer};
use crate::render::texel_baking::OwnPoints;
use crate::textures::folder::write_lit;
use crate::textures::memory::bytes_to_bake;
use crate::textures::texel_sites::TexelSites;
use crate::textures::texture::Texture;
use crate::textures::transfer::Canvas;

impl Arguments {
    pub(super) fn bake_atlas(&self, sample: &Sample, session: &Session) -> Result<Outcome> {
        let progress = session.progress();
        let look = Look {
            surface_color: self.surface_color,
            ..Look::default()
        };
        let table = table_bytes(&self.shading(), sample);
        let atlas = AtlasInput::read(&self.map, look, |description| {
            bytes_to_bake(description).saturating_add(table)
        })?;
        let canvas = Canvas::new(&atlas.map, 1).map_err(|error| error.in_file(&self.map))?;
        let (colors, parallax) = self.colors(sample, &atlas, &canvas.sites(), session)?;
        let size = [atlas.map.width, atlas.map.height];
        let points = canvas.points();
        let is_inside = |texel| points.is_inside(texel);
        let mut textures = self.textures(size, colors, canvas.padding(), is_inside);
        // What is not covered has its holes in the model.
        let holes = atlas.alpha.filter(|_| self.surface_color.is_none());
        textures.extend(holes);
        let written = write_lit(&self.output, &atlas.map, &textures, progress)?;
        let (inside, charts) = (points.inside(), atlas.map.atlas().charts);
        Ok(describe(&written, &self.output)
            .line(parallax.describe())
            .figure("parallax", parallax.heights.is_some())
            .line(format!("{inside} texels in {charts} charts"))
            .figure("texels", inside)
            .figure("charts", charts))
    }

    /// The colour of every texel, black outside charts.
    fn colors(
        &self,
        sample: &Sample,
        atlas: &AtlasInput,
        sites: &TexelSites,
        session: &Session,
    ) -> Result<(Vec<[f32; 3]>, Decision)> {
        let progress = session.progress();
        // What casts shadows.
        let (map, _) = atlas
            .decorated(progress)
            .map_err(|error| error.in_file(&self.map))?;
        let inputs = Inputs {
            sample,
            map: &map,
            map_id: &atlas.id,
            cover: None,
            folder: crate::format::atomic::parent(&self.output),
            force: self.force,
        };
        let alpha = |alpha: &Texture| {
            let numbers = sites.texels.iter().map(|&at| alpha.numbers[at as usize]);
            numbers.map(|share| share.clamp(0.0, 1.0)).collect()
        };
        let cover = atlas.cover(atlas.alpha.as_ref().map(alpha));
        let points = OwnPoints {
            map: &sites.map,
            facets: &sites.facets,
            cover: cover.as_ref(),
            neighbors: &sites.neighbors(atlas.map.width),
        };
        let side = atlas.side();
        let (shaded, parallax) = with_renderer(
            &inputs,
            &self.shading(),
            progress,
            |renderer, frames| match frames.first() {
                Some(frame) => renderer.point_colors(frame, points, side),
                None => Ok(Vec::new()),
            },
        )?;
        let mut colors = vec![[0.0; 3]; atlas.map.len()];
        for (&texel, color) in sites.texels.iter().zip(shaded) {
            colors[texel as usize] = color;
        }
        Ok((colors, parallax))
    }
}
