//! Vectors on their leading directions (Castellanos and Williams §6.2).

use nalgebra::{DMatrix, SymmetricEigen};
use rayon::prelude::*;

/// Vectors summed by one thread.
const BLOCK: usize = 512;

/// The eigenvectors of Σ x xᵀ with the largest eigenvalues. As in the paper, the mean is not subtracted.
#[derive(Clone, Debug, PartialEq)]
pub struct PrincipalComponents {
    /// All eigenvalues, the largest first.
    pub eigenvalues: Vec<f64>,
    /// Numbers per vector.
    length: usize,
    /// Directions kept.
    kept: usize,
    /// Row i has entry i of every kept direction.
    basis: Vec<f32>,
}

impl PrincipalComponents {
    /// The `kept` leading directions of `count` vectors of `length` numbers; `vector` writes one of them.
    ///
    /// The numbers stand in `sectors` equal parts. Vectors with the parts rotated by one place, any number of times,
    /// count as well: a sample of an isotropic texture stands for its turned copies.
    pub fn new(
        (count, length, sectors): (usize, usize, usize),
        kept: usize,
        vector: impl Fn(usize, &mut [f32]) + Sync,
    ) -> Self {
        let sums = second_moments(count, length, &vector);
        let eigen = SymmetricEigen::new(over_turns(&sums, sectors));
        let mut order: Vec<usize> = (0..length).collect();
        let values = &eigen.eigenvalues;
        order.sort_by(|&a, &b| values[b].total_cmp(&values[a]).then(a.cmp(&b)));
        let kept = kept.min(length);
        let entries = (0..length).flat_map(|row| {
            let leading = order[..kept].iter();
            leading.map(move |&column| (row, column))
        });
        let basis = entries.map(|entry| eigen.eigenvectors[entry] as f32);
        Self {
            basis: basis.collect(),
            eigenvalues: order.iter().map(|&at| values[at].max(0.0)).collect(),
            length,
            kept,
        }
    }

    /// Directions kept.
    pub fn kept(&self) -> usize {
        self.kept
    }

    /// What a vector gives in every kept direction.
    #[inline]
    pub fn project(&self, vector: &[f32], out: &mut [f32]) {
        debug_assert_eq!(vector.len(), self.length);
        out[..self.kept].fill(0.0);
        for (&number, row) in vector.iter().zip(self.basis.chunks_exact(self.kept)) {
            for (sum, &entry) in out.iter_mut().zip(row) {
                *sum += number * entry;
            }
        }
    }
}

/// Σ x xᵀ, added up in blocks whose order is fixed.
fn second_moments(
    count: usize,
    length: usize,
    vector: &(impl Fn(usize, &mut [f32]) + Sync),
) -> DMatrix<f64> {
    let of_block = |block: usize| {
        let mut sums = DMatrix::<f64>::zeros(length, length);
        let mut held = vec![0.0f32; length];
        for index in block * BLOCK..((block + 1) * BLOCK).min(count) {
            vector(index, &mut held);
            for column in 0..length {
                let factor = f64::from(held[column]);
                let rows = &mut sums.as_mut_slice()[column * length..][..=column];
                for (sum, &row) in rows.iter_mut().zip(&held) {
                    *sum += factor * f64::from(row);
                }
            }
        }
        sums
    };
    // A few blocks at a time, so that few matrices are held at once.
    const AT_ONCE: usize = 8;
    let mut total = DMatrix::zeros(length, length);
    let blocks = count.div_ceil(BLOCK);
    for first in (0..blocks).step_by(AT_ONCE) {
        let several = first..(first + AT_ONCE).min(blocks);
        let sums: Vec<DMatrix<f64>> = several.into_par_iter().map(of_block).collect();
        sums.into_iter().for_each(|sums| total += sums);
    }
    total.fill_lower_triangle_with_upper_triangle();
    total
}

/// The sum over all turns of the sectors.
fn over_turns(sums: &DMatrix<f64>, sectors: usize) -> DMatrix<f64> {
    let length = sums.nrows();
    let part = length / sectors.max(1);
    let mut turned = DMatrix::zeros(length, length);
    for turn in 0..sectors.max(1) {
        let moved = |at: usize| (at + turn * part) % length;
        turned += DMatrix::from_fn(length, length, |row, column| {
            sums[(moved(row), moved(column))]
        });
    }
    turned
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random;
    use rand::Rng;

    fn vectors(count: usize, length: usize) -> Vec<Vec<f32>> {
        let mut stream = random::stream(6, "vectors", 0, 0);
        let mut vector = || {
            (0..length)
                .map(|at| stream.gen_range(0.0..1.0 / (1 + at) as f32))
                .collect()
        };
        (0..count).map(|_| vector()).collect()
    }

    fn components(vectors: &[Vec<f32>], sectors: usize, kept: usize) -> PrincipalComponents {
        let size = (vectors.len(), vectors[0].len(), sectors);
        PrincipalComponents::new(size, kept, |index, out| {
            out.copy_from_slice(&vectors[index])
        })
    }

    fn square(a: &[f32], b: &[f32]) -> f32 {
        a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum()
    }

    #[test]
    fn all_directions_keep_distances_and_few_never_enlarge_them() {
        let vectors = vectors(1300, 12);
        let (all, few) = (components(&vectors, 3, 12), components(&vectors, 3, 4));
        let projected = |components: &PrincipalComponents, index: usize| {
            let mut out = vec![0.0; components.kept()];
            components.project(&vectors[index], &mut out);
            out
        };
        for (one, other) in [(0, 1), (7, 1200), (600, 900)] {
            let wanted = square(&vectors[one], &vectors[other]);
            let kept = square(&projected(&all, one), &projected(&all, other));
            assert!((kept - wanted).abs() < 1e-5);
            let fewer = square(&projected(&few, one), &projected(&few, other));
            assert!(fewer <= wanted + 1e-5 && fewer > 0.0);
        }
    }

    #[test]
    fn eigenvalues_fall_and_sum_to_the_squares_of_all_turned_vectors() {
        let vectors = vectors(700, 12);
        let components = components(&vectors, 3, 5);
        assert!(components.eigenvalues.is_sorted_by(|a, b| a >= b));
        let squares: f64 = vectors
            .iter()
            .flatten()
            .map(|&n| f64::from(n).powi(2))
            .sum();
        let sum: f64 = components.eigenvalues.iter().sum();
        assert!((sum / (3.0 * squares) - 1.0).abs() < 1e-6);
    }
}
