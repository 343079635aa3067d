//! Plain images as an exemplar: the features of a texel are the numbers of one or more aligned
//! images (colour, height, mask, alpha, normal) at it.
//!
//! In: images of one size, each with what it is; controls of the same size. Out: a [`Space`] of kind
//! `features`, level by level 2×2 means. Colours are used as an integer file stores them: by the sRGB
//! curve, which is closer to perceived differences than linear light; floats are linear and are
//! brought to that curve. All other kinds are used as they stand. Not handled: images of different
//! sizes (crop or scale them first).

use std::borrow::Cow;

use ndarray::Array3;

use crate::error::{Error, Result};
use crate::exemplar::channels::{Channel, ChannelKind};
use crate::exemplar::controls::Controls;
use crate::exemplar::space::{Features, Space, SpaceLevel};
use crate::exemplar::value_range::value_range;
use crate::format::id::ContentId;
use crate::format::image::{Encoding, FloatImage, encode_srgb};
use crate::grid::TexelGrid;
use crate::index::TexelIndex;

/// An image and what it is a channel of.
#[derive(Clone, Debug)]
pub struct ChannelImage {
    /// The channel's name, no other's.
    pub name: String,
    /// What its numbers are.
    pub kind: ChannelKind,
    /// Its share in the squared distance; 0 leaves it out.
    pub weight: f64,
    /// The numbers.
    pub image: FloatImage,
}

impl ChannelImage {
    /// A channel of weight 1, named after its kind.
    pub fn new(kind: ChannelKind, image: FloatImage) -> Self {
        Self {
            name: kind.name().into(),
            kind,
            weight: 1.0,
            image,
        }
    }
}

/// The space of aligned images and the controls of their texels. It has no id of its own until it is
/// written.
pub fn space_of_images(
    images: &[ChannelImage],
    controls: Controls,
    levels: u32,
    tileable: bool,
    sample: &ContentId,
) -> Result<Space> {
    let grid = check(images, levels, tileable)?;
    let controls = controls.pyramid(grid, levels as usize)?;
    let numbers: Vec<Cow<'_, [f32]>> = images
        .iter()
        .map(|of| stored_numbers(of.kind, &of.image))
        .collect();
    let mut level = SpaceLevel {
        grid,
        features: Features::Plain(side_by_side(images, &numbers, grid)),
    };
    let mut all = Vec::new();
    for _ in 1..levels {
        let coarser = coarser(&level);
        all.push(std::mem::replace(&mut level, coarser));
    }
    all.push(level);
    Space::of_channels(all, channels(images, &numbers), controls, sample.clone())
}

/// The channel of each image, one after another.
fn channels(images: &[ChannelImage], numbers: &[Cow<'_, [f32]>]) -> Vec<Channel> {
    let mut first = 0;
    let channel = |(of, numbers): (&ChannelImage, &Cow<'_, [f32]>)| {
        let count = of.image.channels;
        let (low, high) = value_range(of.kind, numbers, count as usize, of.image.precision);
        first += count;
        Channel {
            name: of.name.clone(),
            kind: of.kind,
            first: first - count,
            count,
            weight: of.weight,
            low,
            high,
        }
    };
    images.iter().zip(numbers).map(channel).collect()
}

/// The range in which an image's numbers are drawn and exported as a channel of a kind; colours by the sRGB
/// curve.
pub fn range_of_image(kind: ChannelKind, image: &FloatImage) -> (f64, f64) {
    let numbers = stored_numbers(kind, image);
    value_range(kind, &numbers, image.channels as usize, image.precision)
}

/// The numbers that a channel stores of an image.
fn stored_numbers(kind: ChannelKind, image: &FloatImage) -> Cow<'_, [f32]> {
    match (kind, image.encoding) {
        (ChannelKind::Color, Encoding::Linear) => {
            let linear = image.data.iter();
            linear.map(|&value| encode_srgb(value)).collect()
        }
        _ => Cow::Borrowed(&image.data),
    }
}

fn check(images: &[ChannelImage], levels: u32, tileable: bool) -> Result<TexelGrid> {
    // Check that all images have one size.
    let Some(first) = images.first().map(|of| &of.image) else {
        return Err(Error::option("images", "none", "1 or more"));
    };
    let size = |image: &FloatImage| format!("{}×{}", image.width, image.height);
    for (index, ChannelImage { image, .. }) in images.iter().enumerate() {
        image.check_finite()?;
        if (image.width, image.height) != (first.width, first.height) {
            return Err(Error::data(format!("image {}", index + 1), size(image))
                .expected(format!("{}, as the first image", size(first))));
        }
    }
    // Check that the levels fit it.
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

/// The numbers of all images at every texel.
fn side_by_side(
    images: &[ChannelImage],
    numbers: &[Cow<'_, [f32]>],
    grid: TexelGrid,
) -> Array3<f32> {
    let counts = images.iter().map(|of| of.image.channels as usize);
    let depth = counts.clone().sum();
    let mut features = Array3::zeros((grid.height as usize, grid.width as usize, depth));
    for (texel, mut slots) in features.rows_mut().into_iter().enumerate() {
        let here = counts
            .clone()
            .zip(numbers)
            .flat_map(|(count, numbers)| &numbers[texel * count..][..count]);
        slots
            .iter_mut()
            .zip(here)
            .for_each(|(slot, &number)| *slot = number);
    }
    features
}

/// The next level: 2×2 means of what exists.
fn coarser(level: &SpaceLevel) -> SpaceLevel {
    let Features::Plain(fine) = &level.features else {
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
        features: Features::Plain(sums),
    }
}

#[cfg(test)]
mod tests;
