//! A symmetric matrix Σ xᵀ x that grows row by row of x: only its lower triangle is computed.
//!
//! In: blocks of rows. Out: the whole symmetric matrix, the same bits at any thread count.

use ndarray::{Array2, ArrayView2, ArrayViewMut2, Axis, s};
use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::format::stored_array::StoredArray;
use crate::matrix::{Update, multiply};
use crate::progress::Progress;

/// Rows of the matrix that one task updates.
const BLOCK: usize = 256;

/// Σ xᵀ x over the rows x added so far.
pub struct ScatterMatrix {
    /// Its lower triangle, block-wise.
    matrix: Array2<f32>,
}

impl ScatterMatrix {
    /// Nothing added yet, over rows of `side` numbers.
    pub fn new(side: usize) -> Self {
        Self {
            matrix: Array2::zeros((side, side)),
        }
    }

    /// Adds rows [count, side]. After an interruption, the matrix is invalid.
    pub fn add(&mut self, rows: ArrayView2<'_, f32>, progress: Progress<'_>) {
        self.each_block(progress, |from, target| add_block(rows, from, target));
    }

    /// Adds the sum over rows [count, side], made by itself first: what adding another sum of these rows alone gives,
    /// without room for all of it. After an interruption, the matrix is invalid.
    pub fn add_sum_of(&mut self, rows: ArrayView2<'_, f32>, progress: Progress<'_>) {
        self.each_block(progress, |from, mut target| {
            let mut sum = Array2::zeros(target.dim());
            add_block(rows, from, sum.view_mut());
            target += &sum;
        });
    }

    /// Works on blocks of the matrix's rows side by side: the number of the first, and the columns up to the diagonal.
    fn each_block(
        &mut self,
        progress: Progress<'_>,
        work: impl Fn(usize, ArrayViewMut2<'_, f32>) + Sync,
    ) {
        self.matrix
            .axis_chunks_iter_mut(Axis(0), BLOCK)
            .into_par_iter()
            .enumerate()
            .for_each(|(block, target)| {
                if progress.is_interrupted() {
                    return;
                }
                let from = block * BLOCK;
                let to = from + target.nrows();
                work(from, target.slice_move(s![.., ..to]));
            });
    }

    /// Adds another sum of the same side.
    pub fn add_all(&mut self, other: &Self) {
        let blocks = self.matrix.axis_chunks_iter_mut(Axis(0), BLOCK);
        blocks
            .into_par_iter()
            .zip(other.matrix.axis_chunks_iter(Axis(0), BLOCK))
            .enumerate()
            .for_each(|(block, (mut target, added))| {
                let computed = s![.., ..block * BLOCK + added.nrows()];
                let mut target = target.slice_mut(computed);
                target += &added.slice(computed);
            });
    }

    /// Nothing added, in the same memory.
    pub fn clear(&mut self) {
        let blocks = self.matrix.axis_chunks_iter_mut(Axis(0), BLOCK);
        blocks.into_par_iter().for_each(|mut rows| rows.fill(0.0));
    }

    /// What is computed, as it is stored: block after block of rows, each up to the end of its square on the
    /// diagonal.
    pub fn stored(&self) -> impl Iterator<Item = Vec<f32>> {
        let blocks = self.matrix.axis_chunks_iter(Axis(0), BLOCK);
        blocks.enumerate().map(|(block, rows)| {
            let computed = s![.., ..block * BLOCK + rows.nrows()];
            rows.slice(computed).iter().copied().collect()
        })
    }

    /// How many numbers a sum of a side stores.
    pub fn stored_length(side: usize) -> usize {
        stored_blocks(side)
            .map(|[rows, columns]| rows * columns)
            .sum()
    }

    /// A stored sum.
    pub fn read(side: usize, stored: &StoredArray<f32>) -> Result<Self> {
        let mut sum = Self::new(side);
        sum.take(stored, |target, number| *target = number)?;
        Ok(sum)
    }

    /// Adds a stored sum of the same side.
    pub fn add_stored(&mut self, stored: &StoredArray<f32>) -> Result<()> {
        self.take(stored, |target, number| *target += number)
    }

    /// Brings every stored number to its place.
    fn take(
        &mut self,
        stored: &StoredArray<f32>,
        put: impl Fn(&mut f32, f32) + Sync,
    ) -> Result<()> {
        // Check the length.
        let side = self.matrix.nrows();
        if stored.len() != Self::stored_length(side) {
            return Err(
                Error::data("dot products", format!("{} numbers", stored.len()))
                    .expected(format!("{}", Self::stored_length(side))),
            );
        }
        // Read block after block of rows.
        let mut first = 0;
        let blocks = self.matrix.axis_chunks_iter_mut(Axis(0), BLOCK);
        for (mut target, [rows, columns]) in blocks.zip(stored_blocks(side)) {
            let mut numbers = vec![0.0; rows * columns];
            stored.read(first, &mut numbers)?;
            if let Some(number) = numbers.iter().find(|number| !number.is_finite()) {
                return Err(
                    Error::data("dot products", number.to_string()).expected("finite numbers")
                );
            }
            let mut target = target.slice_mut(s![.., ..columns]);
            let rows = target.axis_iter_mut(Axis(0)).into_par_iter();
            rows.zip(numbers.par_chunks(columns))
                .for_each(|(target, numbers)| {
                    target
                        .into_iter()
                        .zip(numbers)
                        .for_each(|(t, &v)| put(t, v));
                });
            first += numbers.len();
        }
        Ok(())
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

/// Rows and columns of every stored block of rows.
fn stored_blocks(side: usize) -> impl Iterator<Item = [usize; 2]> {
    let blocks = (0..side).step_by(BLOCK);
    blocks.map(move |from| {
        let to = (from + BLOCK).min(side);
        [to - from, to]
    })
}

fn mirror(mut tile: ArrayViewMut2<'_, f32>) {
    for row in 0..tile.nrows() {
        for col in row + 1..tile.ncols() {
            tile[[row, col]] = tile[[col, row]];
        }
    }
}

/// Adds the dot products of some columns, from the given one on, with all up to the last of them.
fn add_block(rows: ArrayView2<'_, f32>, from: usize, target: ArrayViewMut2<'_, f32>) {
    let to = target.ncols();
    multiply(
        rows.slice(s![.., from..to]).reversed_axes(),
        rows.slice(s![.., ..to]),
        target,
        Update::Add,
    );
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::format::npy;
    use crate::format::stored_array::Bytes;

    #[test]
    fn the_sum_is_the_product_and_symmetric() {
        let rows = Array2::from_shape_fn((40, 300), |(r, c)| ((r * 13 + c * 7) % 19) as f32 - 9.0);
        let mut sum = ScatterMatrix::new(300);
        sum.add(rows.slice(s![..25, ..]), Progress::silent());
        sum.add(rows.slice(s![25.., ..]), Progress::silent());
        assert_eq!(sum.finish(Progress::silent()).unwrap(), rows.t().dot(&rows));
    }

    #[test]
    fn sums_are_added_in_memory_as_from_a_file() {
        let rows = Array2::from_shape_fn((9, 600), |(r, c)| ((r * 31 + c * 7) % 23) as f32 / 7.0);
        let of = |rows: ArrayView2<'_, f32>| {
            let mut sum = ScatterMatrix::new(600);
            sum.add(rows, Progress::silent());
            sum
        };
        let [one, other] = [s![..4, ..], s![4.., ..]].map(|part| of(rows.slice(part)));
        let stored = |sum: &ScatterMatrix| {
            let numbers: Vec<f32> = sum.stored().flatten().collect();
            assert_eq!(numbers.len(), ScatterMatrix::stored_length(600));
            let mut bytes = Vec::new();
            npy::encode(&mut bytes, ndarray::aview1(&numbers).into_dyn()).unwrap();
            StoredArray::<f32>::new(Bytes::Expanded(bytes)).unwrap()
        };
        let mut joined = ScatterMatrix::read(600, &stored(&one)).unwrap();
        joined.add_stored(&stored(&other)).unwrap();
        let mut added = ScatterMatrix::new(600);
        added.add(rows.slice(s![..1, ..]), Progress::silent());
        added.clear();
        added.add_all(&one);
        added.add_sum_of(rows.slice(s![4.., ..]), Progress::silent());
        let [joined, added] = [joined, added].map(|sum| sum.finish(Progress::silent()).unwrap());
        assert_eq!(joined, added);
        let short = ScatterMatrix::read(599, &stored(&one)).err().unwrap();
        assert!(short.to_string().contains("dot products"), "{short}");
    }
}
