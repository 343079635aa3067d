//! Plain images as an exemplar: the features of a texel are the numbers of one or more aligned
//! images (colour, height, mask, normal) at it.
//!
//! In: images of one size. Out: a [`Space`] of kind `features`, level by level 2×2 means. The
//! numbers are used as an integer file stores them: colours by the sRGB curve, which is closer to
//! what the eye tells apart than linear light; floats are linear and are brought to that curve. Not
//! handled: images of different sizes (crop or scale them first).

use ndarray::Array3;

use crate::error::{Error, Result};
use crate::exemplar::space::{Features, Space, SpaceLevel};
use crate::format::id::ContentId;
use crate::format::image::{Encoding, FloatImage};
use crate::grid::TexelGrid;
use crate::index::TexelIndex;

/// The space of aligned images, `weights` their shares in the squared distance. It has no id of
/// its own until it is written.
pub fn space_of_images(
    images: &[FloatImage],
    weights: &[f32],
    levels: u32,
    tileable: bool,
    sample: &ContentId,
) -> Result<Space> {
    let grid = check(images, weights, levels, tileable)?;
    let mut level = SpaceLevel {
        grid,
        features: Features::Vectors(features(images, weights, grid)),
    };
    let mut space = Space {
        levels: Vec::new(),
        id: ContentId::of_bytes(&[]),
        sample: sample.clone(),
    };
    for _ in 1..levels {
        let coarser = coarser(&level);
        space.levels.push(std::mem::replace(&mut level, coarser));
    }
    space.levels.push(level);
    Ok(space)
}

fn check(images: &[FloatImage], weights: &[f32], levels: u32, tileable: bool) -> Result<TexelGrid> {
    let Some(first) = images.first() else {
        return Err(Error::option("images", "none", "1 or more"));
    };
    let size = |image: &FloatImage| format!("{}×{}", image.width, image.height);
    for (index, image) in images.iter().enumerate() {
        image.check_finite()?;
        if (image.width, image.height) != (first.width, first.height) {
            return Err(Error::data(format!("image {}", index + 1), size(image))
                .expected(format!("{}, as the first image", size(first))));
        }
    }
    if weights.len() != images.len() || weights.iter().any(|w| !(*w > 0.0 && w.is_finite())) {
        return Err(Error::option(
            "weights",
            format!("{weights:?}"),
            format!("a number above 0 for each of {} images", images.len()),
        ));
    }
    let shortest = first.width.min(first.height);
    if levels == 0 || levels > 1 + shortest.ilog2() {
        return Err(Error::option(
            "levels",
            levels.to_string(),
            format!("1 to {} for {}", 1 + shortest.ilog2(), size(first)),
        ));
    }
    let halvings = 1 << (levels - 1);
    if tileable && (first.width % halvings != 0 || first.height % halvings != 0) {
        return Err(Error::option(
            "levels",
            format!("{levels} with a tileable image of {}", size(first)),
            format!("sides divisible by {halvings}, fewer levels, or no --tile"),
        ));
    }
    Ok(TexelGrid {
        width: first.width,
        height: first.height,
        tileable,
    })
}

/// The numbers of all images at every texel, each times the root of its image's weight.
fn features(images: &[FloatImage], weights: &[f32], grid: TexelGrid) -> Array3<f32> {
    let dimensions = images.iter().map(|image| image.channels as usize).sum();
    let mut numbers = Vec::with_capacity(grid.len() * dimensions);
    for texel in 0..grid.len() {
        for (image, weight) in images.iter().zip(weights) {
            let channels = image.channels as usize;
            let stored = &image.data[texel * channels..][..channels];
            let scaled = stored.iter().map(|&value| match image.encoding {
                Encoding::Srgb | Encoding::Data => value * weight.sqrt(),
                Encoding::Linear => encode(value) * weight.sqrt(),
            });
            numbers.extend(scaled);
        }
    }
    let mut features = Array3::zeros((grid.height as usize, grid.width as usize, dimensions));
    features
        .iter_mut()
        .zip(numbers)
        .for_each(|(slot, number)| *slot = number);
    features
}

/// The sRGB curve (IEC 61966-2-1), odd about 0 and going on above 1.
fn encode(linear: f32) -> f32 {
    let size = linear.abs();
    let encoded = if size <= 0.003_130_8 {
        12.92 * size
    } else {
        1.055 * size.powf(1.0 / 2.4) - 0.055
    };
    encoded.copysign(linear)
}

/// The next level: 2×2 means of what exists.
fn coarser(level: &SpaceLevel) -> SpaceLevel {
    let Features::Vectors(fine) = &level.features else {
        return level.clone();
    };
    let (grid, dimensions) = (level.grid.coarser(), fine.dim().2);
    let shape = (grid.height as usize, grid.width as usize, dimensions);
    let (mut sums, mut counts) = (Array3::zeros(shape), vec![0.0; grid.len()]);
    for texel in (0..level.grid.len() as u32).map(TexelIndex) {
        let (row, col) = level.grid.row_col(texel);
        for dimension in 0..dimensions {
            let value = fine[[row as usize, col as usize, dimension]];
            sums[[row as usize / 2, col as usize / 2, dimension]] += value;
        }
        counts[level.grid.parent(texel).index()] += 1.0;
    }
    for ((row, col, _), sum) in sums.indexed_iter_mut() {
        *sum /= counts[row * grid.width as usize + col];
    }
    SpaceLevel {
        grid,
        features: Features::Vectors(sums),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::format::image::Precision;

    fn image(width: u32, height: u32, channels: u32, encoding: Encoding) -> FloatImage {
        let count = width * height * channels;
        FloatImage {
            width,
            height,
            channels,
            data: (0..count).map(|i| i as f32 / count as f32).collect(),
            encoding,
            precision: Precision::Bits8,
        }
    }

    fn vectors(level: &SpaceLevel) -> &Array3<f32> {
        match &level.features {
            Features::Vectors(vectors) => vectors,
            Features::Textons { .. } => panic!("vectors expected"),
        }
    }

    fn space(images: &[FloatImage], weights: &[f32], levels: u32, tile: bool) -> Result<Space> {
        space_of_images(
            images,
            weights,
            levels,
            tile,
            &ContentId::of_bytes(b"sample"),
        )
    }

    #[test]
    fn texels_hold_the_numbers_of_all_images() {
        let images = [
            image(5, 4, 3, Encoding::Srgb),
            image(5, 4, 1, Encoding::Linear),
        ];
        let space = space(&images, &[1.0, 4.0], 2, false).unwrap();
        let fine = vectors(&space.levels[0]);
        assert_eq!(fine.dim(), (4, 5, 4));
        assert_eq!(fine[[2, 3, 1]], images[0].get(2, 3, 1));
        assert_eq!(fine[[2, 3, 3]], 2.0 * encode(images[1].get(2, 3, 0)));
        // The odd last column is averaged alone.
        let coarse = vectors(&space.levels[1]);
        assert_eq!(coarse.dim(), (2, 3, 4));
        let alone = (fine[[0, 4, 2]] + fine[[1, 4, 2]]) / 2.0;
        assert!((coarse[[0, 2, 2]] - alone).abs() < 1e-6);
        let four: f32 = [(2, 2), (2, 3), (3, 2), (3, 3)]
            .iter()
            .map(|&(r, c)| fine[[r, c, 0]])
            .sum();
        assert!((coarse[[1, 1, 0]] - four / 4.0).abs() < 1e-6);
    }

    #[test]
    fn the_curve_meets_the_stored_numbers() {
        for value in [0.0, 0.002, 0.2, 0.7, 1.0] {
            let linear = crate::format::image::decode_srgb(value);
            assert!((encode(linear) - value).abs() < 1e-5);
        }
        assert_eq!(encode(-0.2), -encode(0.2));
    }

    #[test]
    fn images_that_do_not_fit_are_refused() {
        let (a, b) = (
            image(8, 8, 3, Encoding::Srgb),
            image(8, 6, 1, Encoding::Srgb),
        );
        let message = |found: Result<Space>| found.unwrap_err().to_string();
        let two = [a.clone(), b];
        assert!(message(space(&two, &[1.0; 2], 1, false)).contains("image 2: 8×6"));
        let one = &two[..1];
        assert!(message(space(one, &[1.0; 2], 1, false)).contains("--weights"));
        assert!(message(space(one, &[0.0], 1, false)).contains("--weights"));
        assert!(message(space(one, &[1.0], 5, false)).contains("1 to 4"));
        assert!(
            message(space(&[image(12, 12, 1, Encoding::Srgb)], &[1.0], 4, true))
                .contains("divisible by 8")
        );
        let mut nan = a;
        nan.data[5] = f32::NAN;
        assert!(space(&[nan], &[1.0], 1, false).is_err());
    }
}
