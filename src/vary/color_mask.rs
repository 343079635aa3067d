//! A texton mask by colour thresholding (Zhang 2003 §4.2): pixels whose colour is near one of a few picked
//! colours.
//!
//! In: an image and one to three picks. Out: label n where the n-th pick's colour is near enough, 0
//! elsewhere. Colours are compared as an integer file stores them, by the sRGB curve; their difference is the
//! Euclidean distance of red, green and blue, each 0 to 1.

use ndarray::Array2;

use crate::error::{Error, Result};
use crate::format::image::{Encoding, FloatImage, encode_srgb};

/// Picks at most: label 0 is what none of them marks.
pub const MOST_PICKS: usize = 3;
/// The largest difference of two colours.
pub const LARGEST_TOLERANCE: f32 = 1.8;

/// Where a picked colour comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PickedColor {
    /// The colour of a pixel of the image.
    Pixel {
        /// Column, 0 at the left.
        col: u32,
        /// Row, 0 at the top.
        row: u32,
    },
    /// A colour by the sRGB curve, each number 0 to 1.
    Value([f32; 3]),
}

/// A picked colour and how far from it a pixel's colour may be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pick {
    /// The colour.
    pub color: PickedColor,
    /// The largest difference, 0 to 1.8.
    pub tolerance: f32,
}

/// The mask of an image. Errors: no pick or more than [`MOST_PICKS`], a pixel off the image, a tolerance out
/// of range.
pub fn mask_of_colors(image: &FloatImage, picks: &[Pick]) -> Result<Array2<u8>> {
    if picks.is_empty() || picks.len() > MOST_PICKS {
        let expected = format!("1 to {MOST_PICKS} colours");
        return Err(Error::option("pick", picks.len().to_string(), expected));
    }
    let colors = picks
        .iter()
        .map(|pick| Ok((color_of(image, pick)?, pick.tolerance)))
        .collect::<Result<Vec<_>>>()?;
    let sides = (image.height as usize, image.width as usize);
    Ok(Array2::from_shape_fn(sides, |(row, col)| {
        label(stored_color(image, row as u32, col as u32), &colors)
    }))
}

fn color_of(image: &FloatImage, pick: &Pick) -> Result<[f32; 3]> {
    if !(0.0..=LARGEST_TOLERANCE).contains(&pick.tolerance) {
        let expected = format!("a tolerance of 0 to {LARGEST_TOLERANCE}");
        return Err(Error::option("pick", pick.tolerance.to_string(), expected));
    }
    match pick.color {
        PickedColor::Value(color) => Ok(color),
        PickedColor::Pixel { col, row } if col < image.width && row < image.height => {
            Ok(stored_color(image, row, col))
        }
        PickedColor::Pixel { col, row } => Err(Error::option(
            "pick",
            format!(
                "pixel {col},{row} of an image of {}×{}",
                image.width, image.height
            ),
            format!(
                "a column of 0 to {} and a row of 0 to {}",
                image.width - 1,
                image.height - 1
            ),
        )),
    }
}

/// A pixel's colour by the sRGB curve; grey is repeated.
pub fn stored_color(image: &FloatImage, row: u32, col: u32) -> [f32; 3] {
    let number = |channel: u32| {
        let value = image.get(row, col, channel.min(image.channels - 1));
        match image.encoding {
            Encoding::Linear => encode_srgb(value),
            Encoding::Srgb | Encoding::Data => value,
        }
    };
    [number(0), number(1), number(2)]
}

/// The label of the colour that is nearest as a share of its tolerance, of those near enough; of equals the
/// first.
fn label(color: [f32; 3], picks: &[([f32; 3], f32)]) -> u8 {
    let mut best = (f32::INFINITY, 0);
    for (number, (picked, tolerance)) in picks.iter().enumerate() {
        let squares = color.iter().zip(picked).map(|(a, b)| (a - b) * (a - b));
        let difference = squares.sum::<f32>().sqrt();
        let share = if difference == 0.0 {
            0.0
        } else {
            difference / tolerance
        };
        if share <= 1.0 && share < best.0 {
            best = (share, number as u8 + 1);
        }
    }
    best.1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::format::image::Precision;

    fn image() -> FloatImage {
        let data = [
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [0.9, 0.1, 0.0],
            [0.0, 0.0, 1.0],
        ];
        FloatImage {
            width: 2,
            height: 2,
            channels: 3,
            data: data.concat(),
            encoding: Encoding::Srgb,
            precision: Precision::Bits8,
        }
    }

    fn pick(color: PickedColor, tolerance: f32) -> Pick {
        Pick { color, tolerance }
    }

    #[test]
    fn the_nearest_of_the_picked_colours_gives_the_label() {
        let red = pick(PickedColor::Pixel { col: 1, row: 0 }, 0.2);
        let blue = pick(PickedColor::Value([0.0, 0.0, 0.9]), 0.3);
        let mask = mask_of_colors(&image(), &[red, blue]).unwrap();
        assert_eq!(mask, ndarray::arr2(&[[0, 1], [1, 2]]));
        let exact = mask_of_colors(
            &image(),
            &[Pick {
                tolerance: 0.0,
                ..red
            }],
        )
        .unwrap();
        assert_eq!(exact, ndarray::arr2(&[[0, 1], [0, 0]]));
        // Both are near enough: the share of the tolerance decides.
        let dark = pick(PickedColor::Value([0.8, 0.0, 0.0]), 1.0);
        let mask = mask_of_colors(&image(), &[dark, red]).unwrap();
        assert_eq!(mask, ndarray::arr2(&[[1, 2], [1, 0]]));
    }

    #[test]
    fn picks_that_cannot_be_are_refused() {
        let said = |picks: &[Pick]| mask_of_colors(&image(), picks).unwrap_err().to_string();
        assert!(said(&[]).contains("--pick: 0; expected 1 to 3"));
        let off = pick(PickedColor::Pixel { col: 2, row: 0 }, 0.1);
        assert!(said(&[off]).contains("pixel 2,0 of an image of 2×2"));
        assert!(said(&[pick(PickedColor::Value([0.0; 3]), f32::NAN)]).contains("NaN"));
    }
}
