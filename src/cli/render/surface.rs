//! What `render` draws: a surface texton map as it is, or an atlas on a mesh of about a vertex per texel.

use std::path::Path;

use crate::cli::atlas::{AtlasInput, Look, is_atlas};
use crate::error::Result;
use crate::format::id::ContentId;
use crate::maps::vertex_map::SurfaceTextonMap;
use crate::progress::Progress;
use crate::render::cover::Cover;
use crate::textures::memory::bytes_to_draw;

/// A surface to draw.
pub(super) struct Surface {
    pub(super) map: SurfaceTextonMap,
    /// A plain colour below the texture.
    pub(super) cover: Option<Cover>,
    /// The id of all that it was made of.
    pub(super) id: ContentId,
}

/// Reads a map, or an atlas as `look` says.
pub(super) fn read(path: &Path, look: Look, progress: Progress<'_>) -> Result<Surface> {
    if !is_atlas(path) {
        return Ok(Surface {
            map: SurfaceTextonMap::read(path)?,
            cover: None,
            id: ContentId::of_file(path)?,
        });
    }
    let atlas = AtlasInput::read(path, look, bytes_to_draw)?;
    let (map, cover) = atlas
        .decorated(progress)
        .map_err(|error| error.in_file(path))?;
    Ok(Surface {
        map,
        cover,
        id: atlas.id,
    })
}
