//! A picture of a mask over its image: the labels as tints, contours bright, centres as crosses.

use ndarray::Array2;

use crate::format::image::FloatImage;
use crate::format::rgb_image::RgbImage;
use crate::vary::color_mask::stored_color;
use crate::vary::contours::MaskFeatures;

/// The tints of the labels 1, 2 and 3.
const TINTS: [[f32; 3]; 3] = [[1.0, 0.25, 0.1], [0.1, 0.6, 1.0], [0.3, 0.9, 0.2]];
/// How much of a pixel is tint.
const TINT: f32 = 0.35;
/// Arms of the cross at a centre, in pixels.
const ARM: i64 = 2;

/// Draws the picture.
pub fn draw(image: &FloatImage, mask: &Array2<u8>, features: &MaskFeatures) -> RgbImage {
    let mut overlay = RgbImage {
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
            put(&mut overlay, i64::from(row), i64::from(col), bytes);
        }
        let [row, col] = feature.centre.map(|at| at.round() as i64);
        for step in -ARM..=ARM {
            put(&mut overlay, row + step, col, [255; 3]);
            put(&mut overlay, row, col + step, [255; 3]);
        }
    }
    overlay
}

/// Sets a pixel, where the image has it.
fn put(overlay: &mut RgbImage, row: i64, col: i64, color: [u8; 3]) {
    let sides = [overlay.height, overlay.width].map(i64::from);
    if (0..sides[0]).contains(&row) && (0..sides[1]).contains(&col) {
        overlay.set_run(row as u32, col as u32, 1, color);
    }
}
