//! An atlas as an input of commands that draw it: its map, and the images that change its look.

use std::fs;
use std::path::{Path, PathBuf};

use crate::byte_size::ByteSize;
use crate::cli::machine::available_memory;
use crate::error::{Error, Result};
use crate::exemplar::channels::ChannelKind;
use crate::format::id::ContentId;
use crate::maps::atlas_map::{ATLAS_FOLDER, AtlasMap, Description};
use crate::maps::vertex_map::SurfaceTextonMap;
use crate::progress::Progress;
use crate::render::cover::Cover;
use crate::textures::atlas_surface::texel_of;
use crate::textures::decorated::{Decorated, Shape, decorated};
use crate::textures::folder::read_channel;
use crate::textures::surface_color::SurfaceColor;
use crate::textures::texture::Texture;

/// Whether a path is an atlas.
pub(in crate::cli) fn is_atlas(path: &Path) -> bool {
    path.join(ATLAS_FOLDER.description).is_file()
}

/// The files of an atlas; none for anything else.
pub(in crate::cli) fn files(path: &Path) -> Vec<PathBuf> {
    match is_atlas(path) {
        true => ATLAS_FOLDER.files(path),
        false => Vec::new(),
    }
}

/// Refuses an atlas for which this machine has too little memory; `bytes` are what the work on it takes.
pub(in crate::cli) fn check_memory(
    path: &Path,
    description: &Description,
    bytes: u64,
) -> Result<()> {
    fits(description, bytes, available_memory())
        .map_err(|error| error.in_file(&path.join(ATLAS_FOLDER.description)))
}

fn fits(description: &Description, bytes: u64, available: Option<ByteSize>) -> Result<()> {
    let Some(available) = available.filter(|available| bytes > available.0) else {
        return Ok(());
    };
    let found = format!(
        "{}×{} texels, which take about {} with their textures",
        description.width,
        description.height,
        ByteSize(bytes)
    );
    Err(Error::data("width, height", found)
        .expected(format!("at most {available}, the memory that is free now"))
        .advice("synthesize it with a lower --resolution"))
}

/// How an atlas is drawn.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::cli) struct Look {
    /// Mesh units per unit of its height channel.
    pub(in crate::cli) displace: Option<f64>,
    /// What shows where its alpha says that the texture is transparent, in place of holes.
    pub(in crate::cli) surface_color: Option<SurfaceColor>,
}

impl Look {
    /// The options that were given, as a command line has them.
    pub(in crate::cli) fn options(&self) -> String {
        let displace = self.displace.map(|amount| format!(" --displace {amount}"));
        let color = self
            .surface_color
            .map(|color| format!(" --surface-color '{color}'"));
        displace.unwrap_or_default() + &color.unwrap_or_default()
    }
}

/// An atlas that was read.
pub(in crate::cli) struct AtlasInput {
    pub(in crate::cli) map: AtlasMap,
    pub(in crate::cli) alpha: Option<Texture>,
    heights: Option<Texture>,
    look: Look,
    /// The id of all that is drawn, options included.
    pub(in crate::cli) id: ContentId,
}

impl AtlasInput {
    /// Reads an atlas; refuses options that its channels leave without effect, and one that there is too little
    /// memory for: `bytes` says how much the work on it takes.
    pub(in crate::cli) fn read(
        path: &Path,
        look: Look,
        bytes: impl FnOnce(&Description) -> u64,
    ) -> Result<Self> {
        let description = AtlasMap::read_description(path)?;
        check_memory(path, &description, bytes(&description))?;
        let channel = |kind| read_channel(path, &description, kind);
        let alpha = channel(ChannelKind::Alpha)?;
        if let Some(color) = look.surface_color {
            color.check_seen_through(alpha.as_ref(), &path.display().to_string())?;
        }
        let heights = match look.displace {
            Some(_) => channel(ChannelKind::Height)?,
            None => None,
        };
        if let (None, Some(amount)) = (&heights, look.displace) {
            return Err(Error::option(
                "displace",
                format!("{amount}, but {} has no channel of heights", path.display()),
                "an atlas with a channel of kind height",
            ));
        }
        let map = AtlasMap::read(path)?;
        let head = path.join(ATLAS_FOLDER.description);
        let mut parts = fs::read_to_string(&head).map_err(Error::io(&head, "read"))?;
        for texture in alpha.iter().chain(&heights) {
            parts += &ContentId::of_bytes(bytemuck::cast_slice(&texture.numbers)).to_string();
        }
        parts += &format!("{:?}", look.displace);
        parts += &look.surface_color.map_or(String::new(), String::from);
        Ok(Self {
            map,
            alpha,
            heights,
            look,
            id: ContentId::of_bytes(parts.as_bytes()),
        })
    }

    /// The atlas on a mesh of about a vertex per texel, and what lies below its texture.
    pub(in crate::cli) fn decorated(
        &self,
        progress: Progress<'_>,
    ) -> Result<(SurfaceTextonMap, Option<Cover>)> {
        let shape = Shape {
            relief: self.heights.as_ref().zip(self.look.displace),
            alpha: self.alpha.as_ref(),
            is_covered: self.look.surface_color.is_some(),
        };
        let Decorated { map, alpha } = decorated(&self.map, shape, progress)?;
        Ok((map, self.cover(alpha)))
    }

    /// The side of a texel, in mesh units.
    pub(in crate::cli) fn side(&self) -> f64 {
        texel_of(&self.map)
    }

    /// The plain colour below a texture of some opacity, where one was asked for.
    pub(in crate::cli) fn cover(&self, alpha: Option<Vec<f32>>) -> Option<Cover> {
        Some(Cover {
            alpha: alpha?,
            color: self.look.surface_color?.linear(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::textures::memory::{bytes_to_bake, bytes_to_draw};

    #[test]
    fn atlases_too_large_for_the_machine_are_refused_before_they_are_read() {
        let description: Description = serde_json::from_value(serde_json::json!({
            "format": "mesotex-atlas", "version": 1, "width": 8192, "height": 4096, "exemplar": [8, 8],
            "tileable": true, "texel": 1.0, "origin": [0.0, 0.0, 0.0], "seed": 0, "method": "coherent",
            "sample": "0".repeat(32), "space": "0".repeat(32), "coords": "0".repeat(32),
            "surface": "0".repeat(32), "channels": [],
        }))
        .unwrap();
        for bytes in [bytes_to_draw(&description), bytes_to_bake(&description)] {
            assert!(fits(&description, bytes, None).is_ok());
            assert!(fits(&description, bytes, Some(ByteSize(bytes))).is_ok());
            let error = fits(&description, bytes, Some(ByteSize(1 << 30))).unwrap_err();
            let text = error.to_string();
            let parts = [
                "8192×4096",
                &ByteSize(bytes).to_string(),
                "1.00 GiB",
                "--resolution",
            ];
            assert!(parts.iter().all(|part| text.contains(part)), "{text}");
        }
    }
}
