//! Sparse Hermitian matrices of a connection: real diagonal, complex entries between neighbours.
//! Complex numbers stand as `DVec2`.

use glam::DVec2;
use rayon::prelude::*;

use crate::mesh::rows::Rows;

/// Rows a parallel task, and numbers a partial sum: fixed, so that sums do not depend on threads.
pub const CHUNK: usize = 4096;

/// a · conj(b).
#[inline]
pub fn times_conjugate(a: DVec2, b: DVec2) -> DVec2 {
    DVec2::new(a.x * b.x + a.y * b.y, a.y * b.x - a.x * b.y)
}

/// A matrix entry off the diagonal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Entry {
    /// Column.
    pub column: u32,
    /// Value.
    pub value: DVec2,
}

/// A Hermitian matrix.
#[derive(Clone, Debug)]
pub struct Hermitian {
    /// The diagonal.
    pub diagonal: Vec<f64>,
    /// What stands beside it, row by row.
    pub rows: Rows<Entry>,
    /// The sum of magnitudes of each row, diagonal included.
    magnitudes: Vec<f64>,
}

impl Hermitian {
    /// A matrix of its diagonal and what stands beside it.
    pub fn new(diagonal: Vec<f64>, rows: Rows<Entry>) -> Self {
        let magnitude = |row: usize| {
            let beside: f64 = rows.row(row).iter().map(|entry| entry.value.length()).sum();
            beside + diagonal[row].abs().max(f64::MIN_POSITIVE)
        };
        Self {
            magnitudes: (0..diagonal.len()).into_par_iter().map(magnitude).collect(),
            diagonal,
            rows,
        }
    }

    /// Rows (and columns).
    pub fn len(&self) -> usize {
        self.diagonal.len()
    }

    /// One component of the product with a vector.
    #[inline]
    fn row_times(&self, row: usize, x: &[DVec2]) -> DVec2 {
        let mut sum = self.diagonal[row] * x[row];
        for entry in self.rows.row(row) {
            sum += entry.value.rotate(x[entry.column as usize]);
        }
        sum
    }

    /// y = A x.
    pub fn apply(&self, x: &[DVec2], y: &mut [DVec2]) {
        y.par_chunks_mut(CHUNK)
            .enumerate()
            .for_each(|(chunk, out)| {
                for (k, y) in out.iter_mut().enumerate() {
                    *y = self.row_times(chunk * CHUNK + k, x);
                }
            });
    }

    /// x' = x + ω D⁻¹ (b − A x), damped Jacobi with ω = 1.2, D the sums of magnitudes over rows: it
    /// never diverges on a definite matrix, whatever the signs.
    fn relax(&self, x: &[DVec2], b: &[DVec2], out: &mut [DVec2]) {
        out.par_chunks_mut(CHUNK)
            .enumerate()
            .for_each(|(chunk, out)| {
                for (k, y) in out.iter_mut().enumerate() {
                    let row = chunk * CHUNK + k;
                    let residual = b[row] - self.row_times(row, x);
                    *y = x[row] + residual * (1.2 / self.magnitudes[row]);
                }
            });
    }

    /// Relaxes x a number of times.
    pub fn smooth(&self, x: &mut Vec<DVec2>, b: &[DVec2], times: usize, spare: &mut Vec<DVec2>) {
        spare.resize(x.len(), DVec2::ZERO);
        for _ in 0..times {
            self.relax(x, b, spare);
            std::mem::swap(x, spare);
        }
    }
}

/// The real part of ⟨a, b⟩, summed over fixed chunks.
pub fn dot(a: &[DVec2], b: &[DVec2]) -> f64 {
    let partial: Vec<f64> = a
        .par_chunks(CHUNK)
        .zip(b.par_chunks(CHUNK))
        .map(|(a, b)| a.iter().zip(b).map(|(a, b)| a.dot(*b)).sum())
        .collect();
    partial.into_iter().sum()
}

/// y += factor · x, factor real.
pub fn add_scaled(y: &mut [DVec2], factor: f64, x: &[DVec2]) {
    y.par_chunks_mut(CHUNK)
        .zip(x.par_chunks(CHUNK))
        .for_each(|(y, x)| y.iter_mut().zip(x).for_each(|(y, x)| *y += factor * *x));
}
