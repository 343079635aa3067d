//! An image: its size and range.

use std::path::Path;

use crate::cli::outcome::Outcome;
use crate::error::Result;
use crate::format::image;

/// Reads an image and says what it holds.
pub fn describe(path: &Path) -> Result<Outcome> {
    let picture = image::read(path)?;
    let least = picture.data.iter().copied().fold(f32::INFINITY, f32::min);
    let most = picture
        .data
        .iter()
        .copied()
        .fold(f32::NEG_INFINITY, f32::max);
    let strange = picture
        .data
        .iter()
        .filter(|value| !value.is_finite())
        .count();
    Ok(Outcome::default()
        .line(format!(
            "image of {} × {} pixels, {} channels, {:?} as {:?}",
            picture.width, picture.height, picture.channels, picture.precision, picture.encoding
        ))
        .line(format!("values {least} to {most}, {strange} not finite"))
        .figure("kind", "image")
        .figure("width", picture.width)
        .figure("height", picture.height)
        .figure("channels", picture.channels)
        .figure("least", least)
        .figure("most", most)
        .figure("not_finite", strange))
}
