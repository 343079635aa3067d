//! What `synth` writes: a surface texton map, or the folder of a decorated atlas with its textures.

use std::path::Path;

use crate::cli::outputs::Product;
use crate::cli::session::Session;
use crate::error::{Error, Result};
use crate::exemplar::space::Space;
use crate::format::ours::Format;
use crate::maps::atlas_map::ATLAS_FOLDER;
use crate::maps::vertex_map::SurfaceTextonMap;
use crate::sites::atlas::preparation::AtlasSurface;
use crate::synthesis::map::atlas_map;
use crate::textures::SampleChannel;
use crate::textures::folder::{Written, write_atlas};
use crate::textures::model::ModelOptions;
use crate::textures::transfer::Canvas;

/// The ending of an atlas' folder.
const ATLAS_ENDING: &str = "atlas";

/// What is written at the output of a run.
pub fn kind(is_atlas: bool) -> Product {
    match is_atlas {
        true => Product::Folder(&ATLAS_FOLDER),
        false => Product::File(Format::Mesh),
    }
}

/// Refuses a name that promises something else, and options of a model that is not made.
pub fn check(output: &Path, is_atlas: bool, model: &ModelOptions) -> Result<()> {
    let ends_so = output
        .extension()
        .is_some_and(|ending| ending == ATLAS_ENDING);
    if ends_so != is_atlas {
        let expected = match is_atlas {
            true => "a folder, NAME.atlas, for --onto atlas",
            false => "a file, NAME.map.ply, or --onto atlas for a folder NAME.atlas",
        };
        return Err(Error::option(
            "output",
            output.display().to_string(),
            expected,
        ));
    }
    let default = ModelOptions::default();
    if !is_atlas {
        let given = [
            ("displace", model.displace.is_some()),
            ("transparency", model.transparency != default.transparency),
        ];
        if let Some((option, _)) = given.iter().find(|(_, given)| *given) {
            return Err(Error::option(
                *option,
                "given for a map",
                "--onto atlas beside it",
            ));
        }
    }
    model.validate()
}

/// Refuses a displacement that the exemplar has no heights for.
pub fn check_channels(space: &Space, model: &ModelOptions) -> Result<()> {
    let channels = space.channels.list().iter();
    model.check_kinds(channels.map(|channel| channel.kind))
}

/// Writes a finished map, as the file `path` or, on an atlas, as a folder; what that came to.
pub fn write(
    path: &Path,
    map: &SurfaceTextonMap,
    atlas: Option<&AtlasSurface>,
    (space, model): (&Space, &ModelOptions),
    session: &Session,
) -> Result<Option<Written>> {
    let Some(surface) = atlas else {
        return map.write(path).map(|()| None);
    };
    let atlas = atlas_map(space, surface, map);
    let progress = session.progress();
    let channels = SampleChannel::of_space(space);
    let textures = Canvas::new(&atlas, 1)?.carry_all(&channels, progress)?;
    write_atlas(path, &atlas, &textures, model, progress).map(Some)
}
