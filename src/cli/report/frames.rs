//! Frames as a page plays them: their previews, reduced.

use std::path::{Path, PathBuf};

use crate::cli::info::kind::frames_in;
use crate::cli::report::name;
use crate::error::Result;
use crate::format::rgb_image::RgbImage;
use crate::report::contact_sheet::reduced;
use crate::report::embedded::jpeg;
use crate::report::summary::Sequence;

/// The most frames of a sequence, and their columns.
const MOST_FRAMES: usize = 120;
const WIDTH: u32 = 480;

/// The sequences of some folders, and what is missing of them.
pub(super) fn sequences(folders: &[PathBuf]) -> Result<(Vec<Sequence>, Vec<String>)> {
    let (mut sequences, mut notes) = (Vec::new(), Vec::new());
    for folder in folders {
        let frames = frames_in(folder)?;
        let (shown, missing): (Vec<&PathBuf>, Vec<&PathBuf>) = frames
            .iter()
            .partition(|frame| frame.with_extension("png").is_file());
        if !missing.is_empty() {
            notes.push(format!(
                "{}: {} of {} frames have no preview (.png) and are left out",
                name(folder),
                missing.len(),
                frames.len()
            ));
        }
        if !shown.is_empty() {
            sequences.push(sequence(folder, &shown)?);
        }
    }
    if sequences.is_empty() {
        notes.push("no frames are there: mesotex render draws them".to_owned());
    }
    Ok((sequences, notes))
}

/// Evenly spaced frames.
fn sequence(folder: &Path, frames: &[&PathBuf]) -> Result<Sequence> {
    let count = frames.len().min(MOST_FRAMES);
    let chosen = (0..count).map(|index| index * frames.len() / count);
    let mut sequence = Sequence {
        name: name(folder),
        frames: Vec::new(),
        names: Vec::new(),
    };
    for index in chosen {
        let preview = frames[index].with_extension("png");
        sequence
            .frames
            .push(jpeg(&reduced(RgbImage::read(&preview)?, WIDTH))?);
        sequence.names.push(format!(
            "{} ({} of {})",
            name(&preview),
            index + 1,
            frames.len()
        ));
    }
    Ok(sequence)
}
