//! What `render` draws: a surface texton map as it is, or an atlas on a mesh of about a vertex per texel.

use std::fs;
use std::path::{Path, PathBuf};

use crate::error::{Error, Result};
use crate::exemplar::channels::ChannelKind;
use crate::format::id::ContentId;
use crate::maps::atlas_map::{ATLAS_FOLDER, AtlasMap, Description};
use crate::maps::vertex_map::SurfaceTextonMap;
use crate::progress::Progress;
use crate::textures::decorated::{Shape, decorated};
use crate::textures::folder::read_channel;

/// A surface to draw.
pub(super) struct Surface {
    pub(super) map: SurfaceTextonMap,
    /// The id of all that it was made of.
    pub(super) id: ContentId,
}

/// Whether a path is an atlas.
pub(super) fn is_atlas(path: &Path) -> bool {
    path.join(ATLAS_FOLDER.description).is_file()
}

/// The files of an atlas; none for a map, which is one.
pub(super) fn files(path: &Path) -> Vec<PathBuf> {
    match is_atlas(path) {
        true => ATLAS_FOLDER.files(path),
        false => Vec::new(),
    }
}

/// Reads a map, or an atlas displaced by `displace` mesh units per unit of its height channel.
pub(super) fn read(path: &Path, displace: Option<f64>, progress: Progress<'_>) -> Result<Surface> {
    if !is_atlas(path) {
        return Ok(Surface {
            map: SurfaceTextonMap::read(path)?,
            id: ContentId::of_file(path)?,
        });
    }
    let description = Description::read(path)?;
    let channel = |kind| read_channel(path, &description, kind);
    let alpha = channel(ChannelKind::Alpha)?;
    let heights = match displace {
        Some(_) => channel(ChannelKind::Height)?,
        None => None,
    };
    let relief = match (&heights, displace) {
        (Some(heights), Some(amount)) => Some((heights, amount)),
        (None, Some(amount)) => {
            return Err(Error::option(
                "displace",
                format!("{amount}, but {} has no channel of heights", path.display()),
                "an atlas with a channel of kind height",
            ));
        }
        _ => None,
    };
    let map = AtlasMap::read(path)?;
    let shape = Shape {
        relief,
        alpha: alpha.as_ref(),
    };
    let decorated = decorated(&map, shape, progress).map_err(|error| error.in_file(path))?;
    let head = path.join(ATLAS_FOLDER.description);
    let mut parts = fs::read_to_string(&head).map_err(Error::io(&head, "read"))?;
    for texture in alpha.iter().chain(&heights) {
        parts += &ContentId::of_bytes(bytemuck::cast_slice(&texture.numbers)).to_string();
    }
    parts += &format!("{displace:?}");
    Ok(Surface {
        map: decorated,
        id: ContentId::of_bytes(parts.as_bytes()),
    })
}
