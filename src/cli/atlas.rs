//! An atlas as an input of commands that draw it: its map, and the images that change its look.

use std::fs;
use std::path::{Path, PathBuf};

use crate::cli::machine::Need;
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

/// Refuses work on an atlas that this machine has too little memory for; `bytes` are what it takes.
pub(in crate::cli) fn check_memory(
    description: &Description,
    bytes: u64,
    (option, advice): (&'static str, &str),
) -> Result<()> {
    let need = Need {
        bytes,
        work: format!(
            "an atlas of {}x{} texels and what is made of it",
            description.width, description.height
        ),
        option,
        advice: advice.into(),
    };
    need.check()
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
        let advice = "an atlas of a lower synth --resolution";
        check_memory(&description, bytes(&description), ("map", advice))?;
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
