//! Text on pictures, in Noto Sans Mono.

use noto_sans_mono_bitmap::{FontWeight, RasterHeight, get_raster, get_raster_width};

const WEIGHT: FontWeight = FontWeight::Regular;
const SIZE: RasterHeight = RasterHeight::Size20;
/// What stands for letters that the font has no shape of.
const UNKNOWN: char = '?';

/// Rows of a line of text.
pub const HEIGHT: u32 = SIZE.val() as u32;

/// Columns that a text takes.
pub fn width(text: &str) -> u32 {
    get_raster_width(WEIGHT, SIZE) as u32 * text.chars().count() as u32
}

/// Visits the inked pixels of a text as (column, row) with the share of each that is covered, from 0 to 1.
pub fn ink(text: &str, mut visit: impl FnMut(u32, u32, f32)) {
    for (place, letter) in (0..).zip(text.chars()) {
        let shape = [letter, UNKNOWN]
            .into_iter()
            .find_map(|letter| get_raster(letter, WEIGHT, SIZE));
        let Some(shape) = shape else { continue };
        let left = place * shape.width() as u32;
        for (row, line) in (0..).zip(shape.rows()) {
            for (column, &covered) in (left..).zip(line) {
                if covered > 0 {
                    visit(column, row, f32::from(covered) / 255.0);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drawn(text: &str) -> Vec<(u32, u32)> {
        let mut pixels = Vec::new();
        ink(text, |column, row, covered| {
            assert!(column < width(text) && row < HEIGHT && covered > 0.0 && covered <= 1.0);
            pixels.push((column, row));
        });
        pixels
    }

    #[test]
    fn letters_are_distinct_and_stay_in_their_cells() {
        let letters = "aAbB019.-°,()";
        let mut shapes: Vec<_> = letters
            .chars()
            .map(|letter| drawn(&letter.to_string()))
            .collect();
        assert!(shapes.iter().all(|shape| !shape.is_empty()));
        shapes.sort();
        shapes.dedup();
        assert_eq!(shapes.len(), letters.chars().count());
        assert!(drawn(" ").is_empty());
        assert_eq!(drawn("\u{4e2d}"), drawn("?"));
    }
}
