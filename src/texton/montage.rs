//! Pictures of a vocabulary: the montage of what each texton looks like, and the texton map in false colours.
//!
//! In: a sample and a level's labels. Out: 8-bit sRGB pixels. Not a measurement: one image of the
//! sample stands for all.

use crate::btf::sample::Sample;
use crate::error::Result;
use crate::false_color::label_color;
use crate::format::image::encode_srgb8;
use crate::format::rgb_image::RgbImage;
use crate::grid::TexelGrid;
use crate::index::{TexelIndex, TextonLabel};

/// Half the side of a texton's patch, in texels.
const REACH: i32 = 6;
/// Pixels per texel along a side, in both pictures.
const ZOOM: u32 = 3;
/// Dark pixels between patches.
const GAP: u32 = 2;
/// Their grey.
const BACKGROUND: u8 = 24;
/// The share of pixels that may be clipped to white.
const CLIPPED: f64 = 0.01;

/// The image seen and lit from nearest to directly above.
pub fn frontal_image(sample: &Sample) -> usize {
    let description = sample.description();
    let height = |image: usize| {
        let (view, light) = description.view_and_light(image);
        description.views[view].cos_theta() * description.lights[light].cos_theta()
    };
    let images = 0..sample.image_count();
    images
        .max_by(|&a, &b| height(a).total_cmp(&height(b)).then(b.cmp(&a)))
        .unwrap_or(0)
}

/// What each texton looks like: the mean, over the texels that carry it, of the frontal image
/// around them; most frequent textons first, row by row.
pub fn montage(sample: &Sample, labels: &[u16], counts: &[u32]) -> Result<RgbImage> {
    let image = frontal_image(sample);
    let pixels = sample.image(image)?;
    let mut values = vec![0.0; pixels.len()];
    pixels.copy_to(&mut values);
    sample.check_image(image, &values)?;
    let patches = mean_patches(sample.grid(), &values, labels, counts.len());
    let white = white_level(&values);
    let mut order: Vec<usize> = (0..counts.len()).collect();
    order.sort_by(|&a, &b| counts[b].cmp(&counts[a]).then(a.cmp(&b)));
    let columns = (counts.len() as f64).sqrt().ceil() as u32;
    let cell = (2 * REACH as u32 + 1) * ZOOM + GAP;
    let mut picture = RgbImage::plain(
        columns * cell + GAP,
        (counts.len() as u32).div_ceil(columns) * cell + GAP,
        BACKGROUND,
    );
    for (place, &texton) in order.iter().enumerate() {
        let (left, top) = (
            place as u32 % columns * cell + GAP,
            place as u32 / columns * cell + GAP,
        );
        for (at, rgb) in patches[texton].chunks(3).enumerate() {
            let (row, col) = (at as u32 / side(), at as u32 % side());
            let color = [rgb[0], rgb[1], rgb[2]].map(|v| encode_srgb8(v / white));
            paint(&mut picture, left + col * ZOOM, top + row * ZOOM, color);
        }
    }
    Ok(picture)
}

/// Texels along a patch's side.
fn side() -> u32 {
    2 * REACH as u32 + 1
}

/// Mean surroundings of every texton's texels, R, G, B.
fn mean_patches(grid: TexelGrid, values: &[f32], labels: &[u16], textons: usize) -> Vec<Vec<f32>> {
    let length = (side() * side()) as usize;
    let mut sums = vec![vec![0.0; 3 * length]; textons];
    let mut counts = vec![vec![0.0_f32; length]; textons];
    for (texel, &label) in labels.iter().enumerate() {
        let (sum, count) = (
            &mut sums[usize::from(label)],
            &mut counts[usize::from(label)],
        );
        for at in 0..length {
            let (drow, dcol) = (
                at as i32 / side() as i32 - REACH,
                at as i32 % side() as i32 - REACH,
            );
            let Some(near) = grid.offset(TexelIndex(texel as u32), drow, dcol) else {
                continue;
            };
            count[at] += 1.0;
            for channel in 0..3 {
                sum[3 * at + channel] += values[3 * near.index() + channel];
            }
        }
    }
    for (sum, count) in sums.iter_mut().zip(&counts) {
        for (rgb, count) in sum.chunks_mut(3).zip(count) {
            rgb.iter_mut().for_each(|v| *v /= count.max(1.0));
        }
    }
    sums
}

/// The value shown as white.
fn white_level(values: &[f32]) -> f32 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f32::total_cmp);
    let at = ((1.0 - CLIPPED) * sorted.len() as f64) as usize;
    sorted[at.min(sorted.len() - 1)].max(f32::MIN_POSITIVE)
}

/// The texton map, every label in a colour of its own that does not depend on the sample.
pub fn label_map(grid: TexelGrid, labels: &[u16]) -> RgbImage {
    let mut picture = RgbImage::plain(grid.width * ZOOM, grid.height * ZOOM, BACKGROUND);
    for (texel, &label) in labels.iter().enumerate() {
        let (row, col) = grid.row_col(TexelIndex(texel as u32));
        let color = label_color(TextonLabel(label));
        paint(&mut picture, col * ZOOM, row * ZOOM, color);
    }
    picture
}

/// Paints a texel as a square of pixels.
fn paint(picture: &mut RgbImage, left: u32, top: u32, color: [u8; 3]) {
    for row in top..top + ZOOM {
        picture.set_run(row, left, ZOOM, color);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patches_are_means_of_their_texels_surroundings() {
        let grid = TexelGrid {
            width: 4,
            height: 4,
            tileable: true,
        };
        let values: Vec<f32> = (0..48).map(|v| (v / 3) as f32).collect();
        let mut labels = vec![1; 16];
        (labels[0], labels[5]) = (0, 0);
        let patches = mean_patches(grid, &values, &labels, 2);
        let centre = 3 * (REACH as u32 * side() + REACH as u32) as usize;
        assert_eq!(patches[0][centre], 2.5);
        // One column to the right: texels 1 and 6.
        assert_eq!(patches[0][centre + 3], 3.5);
    }

    #[test]
    fn the_texton_map_has_a_square_per_texel() {
        let grid = TexelGrid {
            width: 2,
            height: 1,
            tileable: false,
        };
        let map = label_map(grid, &[7, 9]);
        assert_eq!((map.width, map.height), (2 * ZOOM, ZOOM));
        assert_eq!(map.pixels[..3], label_color(TextonLabel(7)));
        let last = map.pixels.len() - 3;
        assert_eq!(map.pixels[last..], label_color(TextonLabel(9)));
    }
}
