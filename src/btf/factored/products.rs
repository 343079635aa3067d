//! Images expanded from their factors.
//!
//! In: images and a run of texels. Out: their values, row-major, interleaved. A value is summed factor
//! after factor, whichever other images and texels are asked for with it: so every reader of a sample
//! gets the same bits.

use std::ops::Range;

use macro_rules_attribute::apply;
use ndarray::{ArrayView2, ArrayViewMut2, Axis, s};
use rayon::prelude::*;

use crate::btf::factored::factorization::CHANNELS;
use crate::btf::factored::factors::{Factors, TILE, set_of};
use crate::lanes::vectorized;
use crate::matrix::{Update, as_rows, as_rows_mut, multiply};

/// What becomes of the channels' values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Values {
    /// Nothing: U · E, channel by channel.
    Channels,
    /// Linear radiance, after the colour step; it may be negative where the factors leave an error.
    Signed,
    /// Linear radiance with 0 in place of negative values, as samples hold it.
    Radiance,
}

impl Factors {
    /// Multiplies out some images at some texels into [images, texels, 3], on the calling thread.
    pub fn multiply(&self, images: &[u32], texels: Range<usize>, values: Values, out: &mut [f32]) {
        let image_length = CHANNELS * texels.len();
        assert_eq!(out.len(), images.len() * image_length, "numbers to fill");
        let mut start = texels.start;
        while start < texels.end {
            let tile = start / TILE;
            let end = texels.end.min((tile + 1) * TILE);
            let inside = start % TILE..start % TILE + (end - start);
            let at = CHANNELS * (start - texels.start);
            for (&image, out) in images.iter().zip(out.chunks_exact_mut(image_length)) {
                let out = &mut out[at..at + CHANNELS * inside.len()];
                self.multiply_tile(image as usize, tile, inside.clone(), values, out);
            }
            start = end;
        }
    }

    /// Weighted sums of the eigentextures of all sets: weights [sums, sets · K], sums one after another, a
    /// number per texel each.
    pub fn mixed_eigentextures(&self, weights: ArrayView2<'_, f32>) -> Vec<f32> {
        let [_, texels] = self.sides();
        let mut sums = vec![0.0; weights.nrows() * texels];
        as_rows_mut(&mut sums, weights.nrows(), texels)
            .axis_chunks_iter_mut(Axis(1), TILE)
            .into_par_iter()
            .enumerate()
            .for_each(|(tile, sums)| self.mix_tile(tile, weights, sums));
        sums
    }

    fn mix_tile(
        &self,
        tile: usize,
        weights: ArrayView2<'_, f32>,
        mut sums: ArrayViewMut2<'_, f32>,
    ) {
        let (rank, length) = (self.rank(), self.rank() * TILE);
        for set in 0..self.factorization.sets() {
            let planes = as_rows(&self.set(set)[tile * length..][..length], rank, TILE);
            multiply(
                weights.slice(s![.., set * rank..(set + 1) * rank]),
                planes.slice(s![.., ..sums.ncols()]),
                sums.view_mut(),
                Update::Add,
            );
        }
    }

    /// One image at some texels of one tile.
    fn multiply_tile(
        &self,
        image: usize,
        tile: usize,
        inside: Range<usize>,
        values: Values,
        out: &mut [f32],
    ) {
        let length = self.rank() * TILE;
        let mut sums = [[0.0; TILE]; CHANNELS];
        for (channel, sums) in sums.iter_mut().enumerate() {
            let set = self.set(set_of(&self.factorization, channel));
            let planes = &set[tile * length..(tile + 1) * length];
            let factors = self.direction(channel, image);
            add_planes(factors, planes, inside.start, &mut sums[..inside.len()]);
        }
        let [transform, mean] = self.color_step(values);
        for (at, out) in out.chunks_exact_mut(CHANNELS).enumerate() {
            let channels = sums.each_ref().map(|sums| sums[at]);
            for (row, out) in out.iter_mut().enumerate() {
                let weights = &transform[CHANNELS * row..CHANNELS * (row + 1)];
                let sum: f32 = weights.iter().zip(channels).map(|(w, v)| w * v).sum();
                *out = sum + mean[row];
            }
        }
        if values == Values::Radiance {
            out.iter_mut().filter(|v| **v < 0.0).for_each(|v| *v = 0.0);
        }
    }

    /// Transform and mean of a colour step.
    fn color_step(&self, values: Values) -> [Vec<f32>; 2] {
        let narrow = |numbers: &[f64]| numbers.iter().map(|&number| number as f32).collect();
        match values {
            Values::Channels => [narrow(&super::factorization::IDENTITY), vec![0.0; CHANNELS]],
            Values::Signed | Values::Radiance => [
                narrow(&self.factorization.color_transform),
                narrow(&self.factorization.color_mean),
            ],
        }
    }
}

/// Adds Σ_k factor_k · plane_k, planes of [`TILE`] numbers taken from `first` on. Four planes at a
/// time, each number's sum in the order of the factors.
#[apply(vectorized!)]
fn add_planes(factors: &[f32], planes: &[f32], first: usize, sums: &mut [f32]) {
    let count = sums.len();
    let fours = factors.chunks_exact(4);
    let rest = fours.remainder();
    for (four, planes) in fours.zip(planes.chunks_exact(4 * TILE)) {
        let [a, b, c, d] = [0, 1, 2, 3].map(|at| &planes[at * TILE + first..][..count]);
        for at in 0..count {
            let sum = sums[at] + four[0] * a[at] + four[1] * b[at];
            sums[at] = sum + four[2] * c[at] + four[3] * d[at];
        }
    }
    let done = factors.len() - rest.len();
    for (factor, plane) in rest.iter().zip(planes[done * TILE..].chunks_exact(TILE)) {
        let plane = &plane[first..first + count];
        for (sum, number) in sums.iter_mut().zip(plane) {
            *sum += factor * number;
        }
    }
}
