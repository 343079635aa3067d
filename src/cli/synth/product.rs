//! The output of `synth`: a surface texton map, or the folder of an atlas with its textures.

use std::path::Path;

use crate::cli::atlas::Look;
use crate::cli::outputs::Product;
use crate::error::{Error, Result};
use crate::exemplar::space::Space;
use crate::format::ours::Format;
use crate::maps::atlas_map::ATLAS_FOLDER;
use crate::maps::vertex_map::SurfaceTextonMap;
use crate::progress::Progress;
use crate::sites::atlas::preparation::AtlasSurface;
use crate::synthesis::atlas_map::atlas_map;
use crate::textures::channel::SampleChannel;
use crate::textures::folder::write_atlas;
use crate::textures::model::ModelOptions;
use crate::textures::transfer::Canvas;

/// Whether an output is the folder of an atlas, by its name.
pub(super) fn is_atlas(output: &Path) -> bool {
    ends_in(output, "atlas")
}

fn ends_in(output: &Path, name: &str) -> bool {
    let ending = output.extension();
    ending.is_some_and(|ending| ending.eq_ignore_ascii_case(name))
}

/// What is written at an output.
pub(super) fn product_at(output: &Path) -> Product {
    match is_atlas(output) {
        true => Product::Folder(&ATLAS_FOLDER),
        false => Product::File(Format::Ply),
    }
}

/// Refuses the folder of an atlas for other targets, and options of its model for other outputs.
pub(super) fn check(output: &Path, onto_atlas: bool, model: &ModelOptions) -> Result<()> {
    model.validate()?;
    if let Some(ending) = ["obj", "glb"].iter().find(|name| ends_in(output, name)) {
        let found = format!("{}: ends in .{ending}", output.display());
        let expected = "a name that ends in .ply, as NAME.map.ply; `mesotex export` writes maps for other programs";
        return Err(Error::option("output", found, expected));
    }
    if is_atlas(output) && !onto_atlas {
        let found = format!("{} for a target that is not an atlas", output.display());
        return Err(Error::option(
            "output",
            found,
            "--onto atlas beside it, or NAME.map.ply",
        ));
    }
    Ok(())
}

/// The command that shows an output: a bake where an atlas has no images of its own, else frames.
pub(super) fn next(output: &Path, space: &Space, model: &ModelOptions) -> String {
    let name = output.display();
    if is_atlas(output) && space.channels.list().is_empty() {
        let baked = output.with_extension("baked");
        return format!(
            "mesotex bake-maps NAME.sample {name} -o {}",
            baked.display()
        );
    }
    let look = Look {
        displace: model.displace,
        surface_color: model.surface_color,
    };
    format!(
        "mesotex render NAME.sample {name} -o frames{}",
        look.options()
    )
}

/// Writes a finished map; `atlas` is the surface of a target that is one.
pub(super) fn write(
    output: &Path,
    map: &SurfaceTextonMap,
    atlas: Option<&AtlasSurface>,
    (space, model): (&Space, &ModelOptions),
    progress: Progress<'_>,
) -> Result<()> {
    let Some(surface) = atlas.filter(|_| is_atlas(output)) else {
        return map.write(output);
    };
    let atlas = atlas_map(surface, map, space.tileable());
    let channels = SampleChannel::of_space(space);
    let textures = match channels.is_empty() {
        true => Vec::new(),
        false => Canvas::new(&atlas, 1)?.carry_all(&channels, progress)?,
    };
    write_atlas(output, &atlas, &textures, model, progress).map(drop)
}
