//! A symmetric matrix Σ xᵀ x that grows row by row of x: only its lower triangle is computed.
//!
//! In: blocks of rows. Out: the whole symmetric matrix, the same bits at any thread count.

use ndarray::{Array2, ArrayView2, ArrayViewMut2, Axis, s};
use rayon::prelude::*;

use crate::error::Result;
use crate::matrix::{Target, multiply};
use crate::progress::Progress;

/// Rows of the matrix that one task updates.
const BLOCK: usize = 256;

/// Σ xᵀ x over the rows x added so far.
pub struct OuterProducts {
    /// Its lower triangle, block-wise.
    matrix: Array2<f32>,
}

impl OuterProducts {
    /// Nothing added yet, over rows of `side` numbers.
    pub fn new(side: usize) -> Self {
        Self {
            matrix: Array2::zeros((side, side)),
        }
    }

    /// Adds rows [count, side]. Once interrupted, the matrix is worth nothing.
    pub fn add(&mut self, rows: ArrayView2<'_, f32>, progress: Progress<'_>) {
        self.matrix
            .axis_chunks_iter_mut(Axis(0), BLOCK)
            .into_par_iter()
            .enumerate()
            .for_each(|(block, mut target)| {
                if progress.is_interrupted() {
                    return;
                }
                let (from, to) = (block * BLOCK, block * BLOCK + target.nrows());
                multiply(
                    rows.slice(s![.., from..to]).reversed_axes(),
                    rows.slice(s![.., ..to]),
                    target.slice_mut(s![.., ..to]),
                    Target::Add,
                );
            });
    }

    /// The whole matrix, exactly symmetric.
    pub fn finish(mut self, progress: Progress<'_>) -> Result<Array2<f32>> {
        let side = self.matrix.nrows();
        for from in (0..side).step_by(BLOCK) {
            progress.check()?;
            let to = (from + BLOCK).min(side);
            for left in (0..from).step_by(BLOCK) {
                let tile = self
                    .matrix
                    .slice(s![from..to, left..left + BLOCK])
                    .to_owned();
                self.matrix
                    .slice_mut(s![left..left + BLOCK, from..to])
                    .assign(&tile.t());
            }
            mirror(self.matrix.slice_mut(s![from..to, from..to]));
        }
        Ok(self.matrix)
    }
}

fn mirror(mut tile: ArrayViewMut2<'_, f32>) {
    for row in 0..tile.nrows() {
        for col in row + 1..tile.ncols() {
            tile[[row, col]] = tile[[col, row]];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sum_is_the_product_and_symmetric() {
        let rows = Array2::from_shape_fn((40, 300), |(r, c)| ((r * 13 + c * 7) % 19) as f32 - 9.0);
        let mut sum = OuterProducts::new(300);
        sum.add(rows.slice(s![..25, ..]), Progress::silent());
        sum.add(rows.slice(s![25.., ..]), Progress::silent());
        assert_eq!(sum.finish(Progress::silent()).unwrap(), rows.t().dot(&rows));
    }
}
