//! Folders of textures: an atlas map with the images of its channels, and images of other maps of the sample.

use std::path::Path;

use serde::Serialize;

use crate::error::{Error, Result};
use crate::exemplar::channels::ChannelKind;
use crate::format::atomic::folder::FolderInProgress;
use crate::format::id::ContentId;
use crate::format::json;
use crate::format::own_folder::OwnFolder;
use crate::maps::atlas_map::{
    ATLAS_FOLDER, AtlasMap, ChannelFile, Description as AtlasDescription, MODEL,
};
use crate::mesh::tessellation::TexturedMesh;
use crate::progress::Progress;
use crate::textures::atlas_surface::{surface_of, texel_of};
use crate::textures::image_file;
use crate::textures::model::{self, ModelFacts, ModelOptions, Subject};
use crate::textures::texture::Texture;

const DESCRIPTION: &str = "textures.json";
const FORMAT: &str = "mesotex-textures";

/// A folder of textures.
pub(crate) const TEXTURES_FOLDER: OwnFolder = OwnFolder {
    name: "a folder of textures",
    ending: None,
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
    let surface = surface_of(map);
    let subject = subject_of(map, &surface);
    let folder = FolderInProgress::create(target, |folder| ATLAS_FOLDER.objection(folder))?;
    let images = (textures, options);
    fill(folder, &subject, images, progress, |folder, channels| {
        map.write_into(folder, channels)
    })
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
    let mut subject = subject_of(map, &surface);
    if let Some(texture) = textures.first() {
        subject.texel *= f64::from(map.width) / f64::from(texture.width);
    }
    write_set(
        target,
        &subject,
        &map.header.sample,
        textures,
        options,
        progress,
    )
}

/// Writes textures of an atlas map that hold light and shade already, and its model with them, as the folder
/// `target`.
pub fn write_lit(
    target: &Path,
    map: &AtlasMap,
    textures: &[Texture],
    progress: Progress<'_>,
) -> Result<Written> {
    let surface = surface_of(map);
    let subject = Subject {
        is_lit: true,
        ..subject_of(map, &surface)
    };
    let options = ModelOptions::default();
    write_set(
        target,
        &subject,
        &map.header.sample,
        textures,
        &options,
        progress,
    )
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
    let [width, height] = textures
        .first()
        .map_or([0; 2], |texture| [texture.width, texture.height]);
    let folder = FolderInProgress::create(target, |folder| TEXTURES_FOLDER.objection(folder))?;
    let images = (textures, options);
    fill(folder, subject, images, progress, |folder, channels| {
        let description = Description {
            format: FORMAT,
            version: 1,
            width,
            height,
            sample,
            channels,
        };
        json::write(&folder.join(DESCRIPTION), &description)
    })
}

/// Finishes a folder: the textures, the model that shows them, and what `describe` adds once the images are known.
fn fill(
    folder: FolderInProgress,
    subject: &Subject<'_>,
    (textures, options): (&[Texture], &ModelOptions),
    progress: Progress<'_>,
    describe: impl FnOnce(&Path, Vec<ChannelFile>) -> Result<()>,
) -> Result<Written> {
    let channels = write_images(folder.path(), textures, progress)?;
    let model = model::write(&folder.member(MODEL), subject, textures, options, progress)?;
    describe(folder.path(), channels.clone())?;
    folder.finish()?;
    Ok(Written { channels, model })
}

/// The first image of a kind that an atlas lists, a height, mask or alpha; of the atlas' size.
pub fn read_channel(
    folder: &Path,
    description: &AtlasDescription,
    kind: ChannelKind,
) -> Result<Option<Texture>> {
    let mut files = description.channels.iter();
    let Some(file) = files.find(|file| file.kind == kind.name()) else {
        return Ok(None);
    };
    let texture = image_file::read(folder, file, kind)?;
    if [texture.width, texture.height] == [description.width, description.height] {
        return Ok(Some(texture));
    }
    Err(
        Error::data("size", format!("{}×{}", texture.width, texture.height))
            .expected(format!(
                "{}×{}, as the atlas has",
                description.width, description.height
            ))
            .in_file(&folder.join(&file.file)),
    )
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

fn subject_of<'a>(map: &AtlasMap, surface: &'a TexturedMesh) -> Subject<'a> {
    Subject {
        surface,
        origin: map.header.origin,
        texel: texel_of(map),
        is_lit: false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exemplar::controls::Controls;
    use crate::exemplar::plain_images::{ChannelImage, space_of_images};
    use crate::format::image::{Encoding, FloatImage, Precision, ReadOptions, read, read_with};
    use crate::maps::atlas_map::Description;
    use crate::maps::atlas_map::tests::square;
    use crate::textures::channel::SampleChannel;
    use crate::textures::transfer::Canvas;

    /// A colour, and heights that weigh half as much.
    fn images() -> Vec<ChannelImage> {
        let image = |channels: usize, encoding| FloatImage {
            width: 8,
            height: 4,
            channels: channels as u32,
            data: (0..32 * channels)
                .map(|at| (2 * at) as f32 / 255.0)
                .collect(),
            encoding,
            precision: Precision::Bits8,
        };
        let mut heights = ChannelImage::new(ChannelKind::Height, image(1, Encoding::Data));
        heights.weight = 0.25;
        vec![
            ChannelImage::new(ChannelKind::Color, image(3, Encoding::Srgb)),
            heights,
        ]
    }

    #[test]
    fn the_channels_of_a_space_become_the_images_of_an_atlas() {
        let root = tempfile::tempdir().unwrap();
        let target = root.path().join("x.atlas");
        let map = square();
        let space =
            space_of_images(&images(), Controls::default(), 1, true, &map.header.sample).unwrap();
        let canvas = Canvas::new(&map, 1).unwrap();
        let quiet = Progress::silent();
        let textures = canvas
            .carry_all(&SampleChannel::of_space(&space), quiet)
            .unwrap();
        let options = ModelOptions::default();
        // A second run replaces the first.
        for _ in 0..2 {
            let written = write_atlas(&target, &map, &textures, &options, quiet).unwrap();
            assert_eq!(
                written.channels,
                Description::read(&target).unwrap().channels
            );
        }
        assert_eq!(AtlasMap::read(&target).unwrap(), map);
        let color = read(&target.join("color.png")).unwrap();
        let height = read_with(&target.join("height.png"), &ReadOptions::data())
            .unwrap()
            .image;
        let grid = map.grid();
        for (texel, coord) in map.coords.iter().enumerate() {
            let Some(coord) = coord else { continue };
            let from = grid.texel_nearest(*coord).index();
            let stored = |number: usize| (2 * number) as f32 / 255.0;
            assert!((height.data[texel] - stored(from)).abs() < 1e-4);
            for channel in 0..3 {
                let wanted = stored(3 * from + channel);
                assert!((color.data[3 * texel + channel] - wanted).abs() < 0.6 / 255.0);
            }
        }
        std::fs::write(target.join("notes.txt"), "mine").unwrap();
        let refused = write_atlas(&target, &map, &textures, &options, quiet).unwrap_err();
        assert!(refused.to_string().contains("notes.txt"), "{refused}");
        assert!(AtlasMap::read(&target).is_ok());
    }
}
