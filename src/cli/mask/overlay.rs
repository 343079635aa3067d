//! A picture of a mask over its image: the labels as tints, contours bright, centres as crosses.

use ndarray::Array2;

use crate::error::Result;
use crate::format::image::{FloatImage, write_png};
use crate::vary::color_mask::stored_color;
use crate::vary::contours::Features;

/// The tints of the labels 1, 2 and 3.
const TINTS: [[f32; 3]; 3] = [[1.0, 0.25, 0.1], [0.1, 0.6, 1.0], [0.3, 0.9, 0.2]];
/// How much of a pixel is tint.
const TINT: f32 = 0.35;
/// Arms of the cross at a centre, in pixels.
const ARM: i64 = 2;

/// A drawn picture, 8 bits, red, green and blue.
pub struct Overlay {
    width: u32,
    height: u32,
    pixels: Vec<u8>,
}

/// Draws the picture.
pub fn draw(image: &FloatImage, mask: &Array2<u8>, features: &Features) -> Overlay {
    let mut overlay = Overlay {
        width: image.width,
        height: image.height,
        pixels: Vec::new(),
    };
    // Tint every texel by its label.
    for ((row, col), &label) in mask.indexed_iter() {
        let color = stored_color(image, row as u32, col as u32);
        let tint = usize::from(label).checked_sub(1).map(|at| TINTS[at]);
        let tinted = |channel: usize| match tint {
            Some(tint) => (1.0 - TINT) * color[channel] + TINT * tint[channel],
            None => color[channel],
        };
        let bytes =
            [0, 1, 2].map(|channel| (255.0 * tinted(channel).clamp(0.0, 1.0)).round() as u8);
        overlay.pixels.extend(bytes);
    }
    for feature in &features.list {
        let tint = TINTS[usize::from(feature.label.clamp(1, 3)) - 1];
        let bytes = tint.map(|number| (255.0 * number) as u8);
        for &[row, col] in std::iter::once(&feature.contour)
            .chain(&feature.holes)
            .flatten()
        {
            overlay.put(i64::from(row), i64::from(col), bytes);
        }
        let [row, col] = feature.centre.map(|at| at.round() as i64);
        for step in -ARM..=ARM {
            overlay.put(row + step, col, [255; 3]);
            overlay.put(row, col + step, [255; 3]);
        }
    }
    overlay
}

impl Overlay {
    fn put(&mut self, row: i64, col: i64, color: [u8; 3]) {
        let inside =
            (0..i64::from(self.height)).contains(&row) && (0..i64::from(self.width)).contains(&col);
        if inside {
            let pixel = row as usize * self.width as usize + col as usize;
            self.pixels[3 * pixel..][..3].copy_from_slice(&color);
        }
    }

    /// Writes the picture as PNG.
    pub fn write(&self, path: &std::path::Path) -> Result<()> {
        write_png(path, self.width, self.height, &self.pixels)
    }
}
