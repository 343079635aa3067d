//! What `render` draws: a surface texton map as it is, an atlas on a mesh of about a vertex per texel, or the faces
//! of a face map, each with corners of its own.

use std::path::Path;

use crate::cli::atlas::{AtlasInput, Look, is_atlas};
use crate::cli::machine::Need;
use crate::error::Result;
use crate::format::id::ContentId;
use crate::maps::face_map::FaceMap;
use crate::maps::vertex_map::SurfaceTextonMap;
use crate::progress::Progress;
use crate::render::cover::Cover;
use crate::render::renderer::Shading;
use crate::synthesis::faces::decorated::{CornerPlaces, with_own_corners};
use crate::synthesis::faces::memory::bytes_to_decorate;
use crate::textures::memory::bytes_to_draw;

/// A surface to draw.
pub(in crate::cli) struct DrawnSurface {
    pub(in crate::cli) map: SurfaceTextonMap,
    /// A plain colour below the texture.
    pub(in crate::cli) cover: Option<Cover>,
    /// The id of all that it was made of.
    pub(in crate::cli) id: ContentId,
}

/// Reads a map, or an atlas as `look` says. Vertex shading gives every face of a face map the one value at its source's
/// centre, pixel shading what the sample has inside.
pub(in crate::cli) fn read(
    path: &Path,
    (look, shading): (Look, Shading),
    progress: Progress<'_>,
) -> Result<DrawnSurface> {
    if FaceMap::is_at(path)? {
        return Ok(DrawnSurface {
            map: read_faces(path, shading).map_err(|error| error.in_file(path))?,
            cover: None,
            id: ContentId::of_file(path)?,
        });
    }
    if !is_atlas(path) {
        return Ok(DrawnSurface {
            map: SurfaceTextonMap::read(path)?,
            cover: None,
            id: ContentId::of_file(path)?,
        });
    }
    let atlas = AtlasInput::read(path, look, bytes_to_draw)?;
    let (map, cover) = atlas
        .decorated(progress)
        .map_err(|error| error.in_file(path))?;
    Ok(DrawnSurface {
        map,
        cover,
        id: atlas.id,
    })
}

fn read_faces(path: &Path, shading: Shading) -> Result<SurfaceTextonMap> {
    let map = FaceMap::read(path)?;
    let need = Need {
        bytes: bytes_to_decorate(&map),
        work: format!("{} faces and the sample's grids", map.sources.len()),
        option: "map",
        advice: "a map of fewer faces, or of a smaller sample".into(),
    };
    need.check()?;
    let corners = match shading {
        Shading::Vertex => CornerPlaces::Center,
        Shading::Pixel => CornerPlaces::Corners,
    };
    with_own_corners(&map, corners)
}
