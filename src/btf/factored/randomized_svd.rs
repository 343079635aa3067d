//! The leading singular vectors of a sample's images, by passes over them (Halko, Martinsson and Tropp
//! 2011, §4.5 with power iterations).
//!
//! In: images, read panel by panel; how many directions. Out: per channel, with X [images, texels], an
//! orthonormal basis W of textures, the directions' coordinates Y = X W, and the singular values of
//! Y Wᵀ. The first pass sums textures with random weights; each further one applies XᵀX to the basis, which sharpens
//! it; the last one takes the coordinates. A pass needs one panel of images and two matrices [texels, l].

use std::ops::Range;

use ndarray::{Array2, s};
use rand::Rng;
use rayon::prelude::*;

use crate::btf::factored::factorization::CHANNELS;
use crate::btf::factored::image_matrix::ImageMatrix;
use crate::btf::factored::orthonormal::{
    inner_products, orthonormal_columns, principal_columns, times,
};
use crate::error::Result;
use crate::matrix::{Update, as_rows, eigen, multiply_on_all_threads};
use crate::progress::Progress;
use crate::random::stream;

/// Passes that sharpen the basis.
const SHARPENED: u32 = 2;

/// What the passes find of one channel.
pub struct ChannelSvd {
    /// W [texels, l].
    textures: Array2<f32>,
    /// Y = X W [images, l].
    coordinates: Array2<f32>,
    /// Squared singular values of Y Wᵀ, largest first.
    pub energies: Vec<f64>,
    /// Right singular vectors of Y, as columns.
    vectors: Array2<f64>,
    /// Sum of the squares of X.
    pub total: f64,
}

impl ChannelSvd {
    /// U [images, rank] and E = V S [texels, rank] of the leading singular triplets; columns of 0 where
    /// the images have fewer.
    pub fn leading(&self, rank: usize) -> [Array2<f32>; 2] {
        let held = rank.min(self.energies.len());
        let turned = self.vectors.slice(s![.., ..held]).to_owned();
        let mut unscaled = turned.clone();
        for (mut column, energy) in unscaled.columns_mut().into_iter().zip(&self.energies) {
            let length = energy.max(0.0).sqrt();
            column.mapv_inplace(|v| if length > 0.0 { v / length } else { 0.0 });
        }
        let products = [
            times(&self.coordinates, &unscaled),
            times(&self.textures, &turned),
        ];
        // E = W V S, and U = Y V S⁻¹.
        let [directions, mut textures] = products;
        for (mut column, energy) in textures.columns_mut().into_iter().zip(&self.energies) {
            let length = energy.max(0.0).sqrt() as f32;
            column.mapv_inplace(|v| v * length);
        }
        [directions, textures].map(|matrix| padded(matrix, rank))
    }
}

/// A matrix with columns of 0 added.
fn padded(matrix: Array2<f32>, columns: usize) -> Array2<f32> {
    if matrix.ncols() == columns {
        return matrix;
    }
    let mut wider = Array2::zeros((matrix.nrows(), columns));
    wider.slice_mut(s![.., ..matrix.ncols()]).assign(&matrix);
    wider
}

/// Bytes that the passes take for `count` directions, without the panel.
pub fn bytes(images: usize, texels: usize, count: usize) -> u64 {
    let columns = (CHANNELS * count) as u64;
    4 * columns * (2 * texels + 2 * images) as u64 + 16 * (count * texels.min(1 << 14)) as u64
}

/// The `count` leading directions of every channel.
pub fn leading_directions(
    images: &ImageMatrix<'_>,
    count: usize,
    seed: u64,
    progress: Progress<'_>,
) -> Result<Vec<ChannelSvd>> {
    let mut bases = first_bases(images, count, seed, progress)?;
    for pass in 1..=SHARPENED {
        let stage = format!("refining the eigentextures, {pass} of {SHARPENED}");
        bases = sharpened(images, bases, &stage, progress)?;
    }
    coordinates(images, bases, progress)
}

/// Bases of random sums of the images.
fn first_bases(
    images: &ImageMatrix<'_>,
    count: usize,
    seed: u64,
    progress: Progress<'_>,
) -> Result<Vec<Array2<f32>>> {
    let mut sums = zeros(images.columns, count);
    images.each("mixing the images", progress, |panel, planes| {
        for (channel, (sums, planes)) in sums.iter_mut().zip(planes).enumerate() {
            let weights = random_weights(seed, channel, panel.clone(), count);
            add_transposed(planes, &weights, sums);
        }
    })?;
    Ok(sums.iter().map(principal_columns).collect())
}

fn zeros(rows: usize, count: usize) -> Vec<Array2<f32>> {
    (0..CHANNELS)
        .map(|_| Array2::zeros((rows, count)))
        .collect()
}

/// Numbers from −1 to 1 for some images, [images, count]; of each image from a stream of its own.
fn random_weights(seed: u64, channel: usize, images: Range<usize>, count: usize) -> Array2<f32> {
    let mut weights = Array2::zeros((images.len(), count));
    for (image, mut row) in images.zip(weights.outer_iter_mut()) {
        let mut random = stream(seed, "factor", channel as u32, image as u64);
        row.mapv_inplace(|_: f32| random.gen_range(-1.0..1.0));
    }
    weights
}

/// sums += planesᵀ weights.
fn add_transposed(planes: &[f32], weights: &Array2<f32>, sums: &mut Array2<f32>) {
    let planes = as_rows(planes, weights.nrows(), sums.nrows());
    multiply_on_all_threads(
        planes.reversed_axes(),
        weights.view(),
        sums.view_mut(),
        Update::Add,
    );
}

/// planes times a basis.
fn coordinates_of(planes: &[f32], basis: &Array2<f32>) -> Array2<f32> {
    let planes = as_rows(planes, planes.len() / basis.nrows(), basis.nrows());
    let mut found = Array2::zeros((planes.nrows(), basis.ncols()));
    multiply_on_all_threads(planes, basis.view(), found.view_mut(), Update::Replace);
    found
}

/// Bases of XᵀX W.
fn sharpened(
    images: &ImageMatrix<'_>,
    bases: Vec<Array2<f32>>,
    stage: &str,
    progress: Progress<'_>,
) -> Result<Vec<Array2<f32>>> {
    let mut sums: Vec<Array2<f32>> = bases
        .iter()
        .map(|basis| Array2::zeros(basis.raw_dim()))
        .collect();
    images.each(stage, progress, |_, planes| {
        for ((sums, planes), basis) in sums.iter_mut().zip(planes).zip(&bases) {
            add_transposed(planes, &coordinates_of(planes, basis), sums);
        }
    })?;
    drop(bases);
    Ok(sums.iter().map(orthonormal_columns).collect())
}

/// The coordinates of all images, and the singular values.
fn coordinates(
    images: &ImageMatrix<'_>,
    bases: Vec<Array2<f32>>,
    progress: Progress<'_>,
) -> Result<Vec<ChannelSvd>> {
    let mut found: Vec<(Array2<f32>, f64)> = bases
        .iter()
        .map(|basis| (Array2::zeros((images.rows, basis.ncols())), 0.0))
        .collect();
    images.each("factoring the images", progress, |panel, planes| {
        for (((all, total), planes), basis) in found.iter_mut().zip(planes).zip(&bases) {
            all.slice_mut(s![panel.clone(), ..])
                .assign(&coordinates_of(planes, basis));
            *total += sum_of_squares(planes, images.columns);
        }
    })?;
    let channels = bases.into_iter().zip(found);
    Ok(channels
        .map(|(textures, (coordinates, total))| {
            let (energies, vectors) = eigen(inner_products(coordinates.view()));
            ChannelSvd {
                textures,
                coordinates,
                energies,
                vectors,
                total,
            }
        })
        .collect())
}

/// The sum of all squares, plane by plane.
fn sum_of_squares(planes: &[f32], plane: usize) -> f64 {
    let sums: Vec<f64> = planes
        .par_chunks(plane)
        .map(|plane| plane.iter().map(|&v| f64::from(v) * f64::from(v)).sum())
        .collect();
    sums.iter().sum()
}
