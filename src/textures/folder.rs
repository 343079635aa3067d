//! Folders of textures: an atlas map with the images of its channels, and images of other maps of the sample.

use std::path::Path;

use serde::Serialize;

use crate::error::Result;
use crate::format::atomic::folder::FolderInProgress;
use crate::format::id::ContentId;
use crate::format::json;
use crate::format::own_folder::OwnFolder;
use crate::maps::atlas_map::{ATLAS_FOLDER, AtlasMap, ChannelFile, MODEL};
use crate::mesh::tessellation::TexturedMesh;
use crate::progress::Progress;
use crate::textures::image_file;
use crate::textures::model::{self, ModelFacts, ModelOptions, Subject};
use crate::textures::texture::Texture;

const DESCRIPTION: &str = "textures.json";
const FORMAT: &str = "mesotex-textures";

/// A folder of textures.
pub(crate) const TEXTURES_FOLDER: OwnFolder = OwnFolder {
    name: "a folder of textures",
    description: DESCRIPTION,
    format: FORMAT,
    members: &[MODEL],
};

/// `textures.json`.
#[derive(Serialize)]
struct Description<'a> {
    format: &'static str,
    version: u32,
    width: u32,
    height: u32,
    sample: &'a ContentId,
    channels: Vec<ChannelFile>,
}

/// What was written.
#[derive(Clone, Debug)]
pub struct Written {
    /// The images.
    pub channels: Vec<ChannelFile>,
    /// The model.
    pub model: ModelFacts,
}

/// Writes an atlas map with its textures and its model as the folder `target`, which appears when it is whole.
pub fn write_atlas(
    target: &Path,
    map: &AtlasMap,
    textures: &[Texture],
    options: &ModelOptions,
    progress: Progress<'_>,
) -> Result<Written> {
    let folder = FolderInProgress::create(target, |folder| ATLAS_FOLDER.objection(folder))?;
    let channels = write_images(folder.path(), textures, progress)?;
    let surface = surface_of(map);
    let subject = subject_of(map, &surface);
    let model = model::write(&folder.member(MODEL), &subject, textures, options, progress)?;
    map.write_into(folder.path(), channels.clone())?;
    folder.finish()?;
    Ok(Written { channels, model })
}

/// Writes other textures of an atlas map, and its model with them, as the folder `target`.
pub fn write_textures(
    target: &Path,
    map: &AtlasMap,
    textures: &[Texture],
    options: &ModelOptions,
    progress: Progress<'_>,
) -> Result<Written> {
    let surface = surface_of(map);
    let subject = subject_of(map, &surface);
    write_set(target, &subject, &map.sample, textures, options, progress)
}

/// Writes textures of one size and a model with them as the folder `target`.
pub fn write_set(
    target: &Path,
    subject: &Subject<'_>,
    sample: &ContentId,
    textures: &[Texture],
    options: &ModelOptions,
    progress: Progress<'_>,
) -> Result<Written> {
    let folder = FolderInProgress::create(target, |folder| TEXTURES_FOLDER.objection(folder))?;
    let channels = write_images(folder.path(), textures, progress)?;
    let model = model::write(&folder.member(MODEL), subject, textures, options, progress)?;
    let [width, height] = textures
        .first()
        .map_or([0; 2], |texture| [texture.width, texture.height]);
    let description = Description {
        format: FORMAT,
        version: 1,
        width,
        height,
        sample,
        channels: channels.clone(),
    };
    json::write(&folder.member(DESCRIPTION), &description)?;
    folder.finish()?;
    Ok(Written { channels, model })
}

fn write_images(
    folder: &Path,
    textures: &[Texture],
    progress: Progress<'_>,
) -> Result<Vec<ChannelFile>> {
    progress.begin("textures", textures.len() as u64);
    let mut channels = Vec::new();
    for texture in textures {
        channels.push(image_file::write(texture, folder, &channels)?);
        progress.advance(1)?;
    }
    progress.end();
    Ok(channels)
}

/// The surface of an atlas map.
pub(super) fn surface_of(map: &AtlasMap) -> TexturedMesh {
    TexturedMesh {
        mesh: map.mesh.clone(),
        normals: map.vertex_normals.clone(),
        corner_uvs: map.corner_uvs.clone(),
    }
}

fn subject_of<'a>(map: &AtlasMap, surface: &'a TexturedMesh) -> Subject<'a> {
    Subject {
        surface,
        origin: map.origin,
        texel: texel_of(map),
        is_lit: false,
    }
}

/// The side of a texel of the atlas, in mesh units: the root of the area that one inside a chart stands for.
pub(super) fn texel_of(map: &AtlasMap) -> f64 {
    let inside = map.chart.iter().filter(|chart| **chart >= 0).count();
    (map.mesh.area() / inside.max(1) as f64).sqrt()
}
