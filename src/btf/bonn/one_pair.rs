//! One pair of factors for all channels, as FMF has it, of a pair per channel.
//!
//! With the colour step in U, red, green and blue of an image are rows of one matrix L over the eigentextures E of all
//! channels side by side: L Eᵀ is all values, exactly. The best K components of a product follow from LᵀL and EᵀE
//! alone: with their square roots A and B, and A B = P Σ Qᵀ, they are U = L A⁻¹ P and U's projections E A P.

use glam::{DMat3, DVec3};
use ndarray::{Array2, Axis, concatenate, s};

use crate::btf::bonn::sample_factors::{color_step, directions, eigentextures};
use crate::btf::factored::factorization::CHANNELS;
use crate::btf::factored::factors::Factors;
use crate::btf::factored::orthonormal::{inner_products, times};
use crate::error::{Error, Result};
use crate::matrix::{eigen, product_of};

/// Directions with less than this share of the largest one's energy are rounding.
const TOLERANCE: f64 = 1e-13;

/// A pair of factors.
pub(super) struct Pair {
    /// U: rows (image, channel).
    pub(super) left: Array2<f32>,
    /// S V: a row per texel.
    pub(super) right: Array2<f32>,
}

/// The pair that holds all that a sample's factors hold, values multiplied by `scale`.
pub(super) fn whole(factors: &Factors, scale: f64) -> Result<Pair> {
    let (transform, mean) = color_step(factors);
    Ok(Pair {
        left: stacked(factors, transform * scale, mean * scale),
        right: side_by_side(factors, mean != DVec3::ZERO)?,
    })
}

impl Pair {
    /// Components.
    pub(super) fn rank(&self) -> usize {
        self.left.ncols()
    }

    /// The best `rank` components.
    pub(super) fn best(&self, rank: usize) -> Result<Self> {
        if rank > self.rank() {
            return Err(Error::option(
                "rank",
                rank.to_string(),
                format!("at most {}, the components of all channels", self.rank()),
            ));
        }
        let (root, inverse) = square_root(inner_products(self.left.view()));
        // (A B)(A B)ᵀ = A EᵀE A has the vectors P and the squares of Σ.
        let products = inner_products(self.right.view());
        let half = product_of(root.view(), products.view());
        let (_, vectors) = eigen(product_of(half.view(), root.view()));
        let leading = vectors.slice(s![.., ..rank]);
        Ok(Self {
            left: times(&self.left, &product_of(inverse.view(), leading)),
            right: times(&self.right, &product_of(root.view(), leading)),
        })
    }
}

/// L: rows (image, channel).
fn stacked(factors: &Factors, transform: DMat3, mean: DVec3) -> Array2<f32> {
    let (rank, sets) = (factors.rank(), factors.factorization().sets());
    let own = directions(factors, 0).nrows();
    let constant = usize::from(mean != DVec3::ZERO);
    let mut left = Array2::zeros((own * CHANNELS, rank * sets + constant));
    for from in 0..CHANNELS {
        let numbers = directions(factors, from);
        let column = if sets == 1 { 0 } else { from * rank };
        for to in 0..CHANNELS {
            let weight = transform.col(from)[to] as f32;
            let mut part = left.slice_mut(s![to..;CHANNELS, column..column + rank]);
            part.scaled_add(weight, &numbers);
            if constant == 1 {
                let mut last = left.slice_mut(s![to..;CHANNELS, rank * sets]);
                last.fill(mean[to] as f32);
            }
        }
    }
    left
}

/// E: the eigentextures of all sets, and 1 where there is a mean.
fn side_by_side(factors: &Factors, has_mean: bool) -> Result<Array2<f32>> {
    let sets = factors.factorization().sets();
    let mut parts: Vec<Array2<f32>> = (0..sets).map(|set| eigentextures(factors, set)).collect();
    if has_mean {
        parts.push(Array2::ones((parts[0].nrows(), 1)));
    }
    let views: Vec<_> = parts.iter().map(Array2::view).collect();
    concatenate(Axis(1), &views).map_err(|error| Error::data("eigentextures", error.to_string()))
}

/// The square root of a symmetric matrix, and its inverse on what is no rounding.
fn square_root(matrix: Array2<f64>) -> (Array2<f64>, Array2<f64>) {
    let (values, vectors) = eigen(matrix);
    let least = TOLERANCE * values.first().copied().unwrap_or(0.0);
    let of = |function: fn(f64) -> f64| {
        let mut scaled = vectors.clone();
        for (mut column, &value) in scaled.columns_mut().into_iter().zip(&values) {
            let factor = if value > least { function(value) } else { 0.0 };
            column.mapv_inplace(|number| number * factor);
        }
        product_of(scaled.view(), vectors.t())
    };
    (of(f64::sqrt), of(|value| 1.0 / value.sqrt()))
}
