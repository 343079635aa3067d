//! The planes that stand for all images of a factored sample.
//!
//! A filter's response is linear in the image, and an image's plane is a sum of eigentextures (its mean
//! apart, which has no response): plane = a · E, with a the plane's J numbers and E [J, texels] the
//! eigentextures of all sets. With A the numbers of all planes of the representative images and
//! G = AᵀA, the dot product of two texels' appearance vectors is that of their responses to the rows of
//! G^½ E. So these J planes take the images' place, and plain dot products of vectors of J · 48 numbers are
//! those of the appearance vectors, however many images there are. The appearance vectors themselves are
//! A G^−½ times these vectors.
//!
//! Values below 0, which a reader of images finds as 0, count as they are: else nothing were linear.

use std::ops::Range;

use ndarray::{Array2, s};

use crate::btf::factored::Factors;
use crate::btf::factored::factorization::CHANNELS;
use crate::matrix::{Update, eigen, multiply_on_all_threads};
use crate::texton::image_stack::{Channels, LUMINANCE};

/// Images whose numbers are held at once.
const IMAGES: usize = 512;
/// Directions with less than this share of the largest one's energy are rounding.
const TOLERANCE: f64 = 1e-13;

/// The rows of G^½ E.
pub struct Eigenplanes<'a> {
    factors: &'a Factors,
    /// G^½ [J, J].
    root: Array2<f32>,
    /// G^−½ [J, J], of the directions that G has.
    inverse_root: Array2<f32>,
}

impl<'a> Eigenplanes<'a> {
    /// The planes that stand for `images`.
    pub fn new(factors: &'a Factors, images: &[u32], channels: Channels) -> Self {
        let weights = plane_weights(factors, channels);
        let gram = gram_of_planes(factors, images, &weights);
        let mut root = Array2::zeros(gram.raw_dim());
        let mut inverse_root = Array2::zeros(gram.raw_dim());
        for block in blocks(factors, &weights) {
            let place = s![block.clone(), block];
            let [of_block, inverse] = roots(gram.slice(place).to_owned());
            root.slice_mut(place).assign(&of_block);
            inverse_root.slice_mut(place).assign(&inverse);
        }
        Self {
            factors,
            root,
            inverse_root,
        }
    }

    /// How many planes stand for the images of factors: J.
    pub fn count_of(factors: &Factors) -> usize {
        factors.factorization().sets() * factors.rank()
    }

    /// How many planes there are.
    pub fn count(&self) -> usize {
        self.root.nrows()
    }

    /// Eigentextures of a set.
    pub fn rank(&self) -> u32 {
        self.factors.factorization().rank
    }

    /// Sets of eigentextures.
    pub fn sets(&self) -> u32 {
        self.factors.factorization().sets() as u32
    }

    /// Some planes, one after another.
    pub fn planes(&self, planes: Range<usize>) -> Vec<f32> {
        self.factors
            .mixed_eigentextures(self.root.slice(s![planes, ..]))
    }

    /// G^−½.
    pub fn into_inverse_root(self) -> Array2<f32> {
        self.inverse_root
    }
}

/// Eigentextures that no plane mixes with others: G is 0 between them.
fn blocks(factors: &Factors, weights: &Array2<f64>) -> Vec<Range<usize>> {
    let (sets, rank) = (factors.factorization().sets(), factors.rank());
    let mixes = weights
        .indexed_iter()
        .any(|((plane, channel), &weight)| weight != 0.0 && plane != channel);
    let length = match sets == CHANNELS && !mixes {
        true => rank,
        false => sets * rank,
    };
    let starts = (0..sets * rank).step_by(length);
    starts.map(|start| start..start + length).collect()
}

/// G^½ and G^−½ of a symmetric matrix without negative directions.
fn roots(gram: Array2<f64>) -> [Array2<f32>; 2] {
    let (values, vectors) = eigen(gram);
    let least = TOLERANCE * values.first().copied().unwrap_or(0.0);
    let power = |of: fn(f64) -> f64| {
        let mut scaled = vectors.clone();
        for (mut column, &value) in scaled.columns_mut().into_iter().zip(&values) {
            let factor = if value > least { of(value) } else { 0.0 };
            column.mapv_inplace(|v| v * factor);
        }
        scaled.dot(&vectors.t()).mapv(|v| v as f32)
    };
    [power(f64::sqrt), power(|value| value.sqrt().recip())]
}

/// For each plane of an image, the weights of the channels' values in it: [planes, 3].
fn plane_weights(factors: &Factors, channels: Channels) -> Array2<f64> {
    let transform = &factors.factorization().color_transform;
    let rgb = Array2::from_shape_fn((CHANNELS, CHANNELS), |(row, channel)| {
        transform[CHANNELS * row + channel]
    });
    match channels {
        Channels::Rgb => rgb,
        Channels::Luminance => {
            let luminance =
                Array2::from_shape_fn((1, CHANNELS), |(_, at)| f64::from(LUMINANCE[at]));
            luminance.dot(&rgb)
        }
    }
}

/// G = AᵀA, summed over images in their order.
fn gram_of_planes(factors: &Factors, images: &[u32], weights: &Array2<f64>) -> Array2<f64> {
    let count = Eigenplanes::count_of(factors);
    let (rank, sets) = (factors.rank(), factors.factorization().sets());
    let mut gram = Array2::zeros((count, count));
    for images in images.chunks(IMAGES) {
        let mut rows = Array2::<f64>::zeros((images.len() * weights.nrows(), count));
        for (image, mut rows) in images
            .iter()
            .zip(rows.exact_chunks_mut((weights.nrows(), count)))
        {
            for (weights, mut row) in weights.outer_iter().zip(rows.outer_iter_mut()) {
                for (channel, &weight) in weights.iter().enumerate() {
                    let first = channel.min(sets - 1) * rank;
                    let numbers = factors.direction(channel, *image as usize);
                    let mut target = row.slice_mut(s![first..first + rank]);
                    for (target, &number) in target.iter_mut().zip(numbers) {
                        *target += weight * f64::from(number);
                    }
                }
            }
        }
        multiply_on_all_threads(rows.t(), rows.view(), gram.view_mut(), Update::Add);
    }
    gram
}
