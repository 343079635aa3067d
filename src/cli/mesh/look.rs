//! Pictures of a prepared surface: its field, its levels, the distortion of its patches.

use std::fs;
use std::path::{Path, PathBuf};

use glam::DVec3;

use super::oriented::Oriented;
use crate::cli::outcome::Outcome;
use crate::error::{Error, Result};
use crate::format::image;
use crate::mesh::pictures::{self, VertexColoredMesh};
use crate::mesh::reading::UserMesh;
use crate::render::preview;
use crate::sites::vertices::prepared_surface::PreparedSurface;

/// Mean distortion drawn red.
const MOST_DISTORTION: f32 = 0.1;
/// Pixels of a picture.
const PICTURE: [u32; 2] = [1280, 960];

/// Draws everything into a folder, which may be new.
pub(super) fn draw(
    outcome: Outcome,
    folder: &Path,
    user: &UserMesh,
    oriented: &Oriented,
    surface: &PreparedSurface,
) -> Result<Outcome> {
    fs::create_dir_all(folder).map_err(Error::io(folder, "create"))?;
    let bent = oriented.distortion(user);
    let mean = bent.iter().sum::<f32>() / bent.len() as f32;
    // Draw the field, the distortion and every level.
    let mut all = vec![
        pictures::field(
            &user.mesh,
            &oriented.rings,
            &oriented.field,
            &oriented.singular,
        ),
        pictures::heat(&user.mesh, &bent, MOST_DISTORTION),
    ];
    let levels = surface.levels.iter();
    all.extend(levels.map(|level| pictures::level(&level.mesh)));
    let mut outcome = outcome
        .line(format!(
            "patches distort lengths by {:.2} % on average",
            100.0 * mean
        ))
        .figure("mean_distortion", mean);
    // Write the pictures.
    let names = picture_names(surface.levels.len() as u32);
    for (name, picture) in names.iter().zip(all) {
        for path in write_picture(folder, name, &picture, user.origin)? {
            outcome = outcome.wrote(&path).put_inside([path]);
        }
    }
    Ok(outcome)
}

/// What the pictures of a surface of this many levels are called.
pub(super) fn picture_names(levels: u32) -> Vec<String> {
    let levels = (0..levels).map(|level| format!("level{level}"));
    ["field".to_owned(), "distortion".to_owned()]
        .into_iter()
        .chain(levels)
        .collect()
}

pub(super) fn picture_files(folder: &Path, name: &str) -> [PathBuf; 2] {
    ["ply", "png"].map(|extension| folder.join(format!("{name}.{extension}")))
}

fn write_picture(
    folder: &Path,
    name: &str,
    picture: &VertexColoredMesh,
    origin: DVec3,
) -> Result<[PathBuf; 2]> {
    let [ply, png] = picture_files(folder, name);
    picture.write(&ply, origin)?;
    let pixels = preview::vertex_colors(&picture.mesh, &picture.colors, PICTURE)?;
    image::write_png(&png, PICTURE[0], PICTURE[1], &pixels)?;
    Ok([ply, png])
}
