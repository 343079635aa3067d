//! Texton centres: the means of their members' appearance vectors, exactly, from the images.
//!
//! In: labels, and the images' coefficients in the basis where filters are diagonal. Out: rows of
//! appearance vectors [textons, planes · 48], component (plane · 48 + filter). With A the members'
//! averages, a centre's response is (Aᵀ F_f) I: the few textons are filtered backwards
//! instead of the many images forwards, and one matrix product per filter does the rest.

use std::ops::Range;

use ndarray::{Array2, ArrayView2, ArrayViewMut2, Axis, azip, s};
use rayon::prelude::*;

use crate::texton::basis::{PLANE_PARITIES, PlaneBasis, Transfer};
use crate::texton::matrix::{Target, multiply};

/// Planes multiplied at once.
const PANEL: usize = 512;
/// Waves weighted at once.
const WAVES: usize = 2048;

/// The members' averages of a level, seen by every filter backwards.
pub struct BackwardFilters<'a> {
    transfer: &'a Transfer,
    /// S_pᵀ A for every parity, [textons, waves].
    averages: Vec<Array2<f32>>,
}

impl<'a> BackwardFilters<'a> {
    /// Averages over the members that `labels` and `counts` name.
    pub fn new(basis: &PlaneBasis, transfer: &'a Transfer, labels: &[u32], counts: &[u32]) -> Self {
        let texels = labels.len();
        let mut members = vec![0.0; counts.len() * texels];
        for (texel, &label) in labels.iter().enumerate() {
            members[label as usize * texels + texel] = 1.0 / counts[label as usize] as f32;
        }
        Self::of_functions(basis, transfer, &members)
    }

    /// Over functions on the grid instead of averages, one after another.
    pub fn of_functions(basis: &PlaneBasis, transfer: &'a Transfer, functions: &[f32]) -> Self {
        let texels = basis.grid.len();
        let count = functions.len() / texels;
        let averages = PLANE_PARITIES
            .into_iter()
            .map(|parities| {
                let mut functions = functions.to_vec();
                basis.adjoint(parities, &mut functions);
                rows_of(functions, count, texels)
            })
            .collect();
        Self { transfer, averages }
    }

    /// Writes the centres' components for planes of coefficients [planes, waves] into
    /// [textons, planes · 48].
    pub fn centroids_into(&self, planes: ArrayView2<'_, f32>, mut target: ArrayViewMut2<'_, f32>) {
        let filters = self.transfer.factors(0).nrows();
        for from in (0..planes.nrows()).step_by(PANEL) {
            let to = (from + PANEL).min(planes.nrows());
            let part = planes.slice(s![from..to, ..]);
            let by_filter: Vec<Array2<f32>> = (0..filters)
                .into_par_iter()
                .map(|filter| self.components(filter, part))
                .collect();
            interleave(
                &by_filter,
                target.slice_mut(s![.., from * filters..to * filters]),
            );
        }
    }

    /// One filter's components, [textons, planes].
    fn components(&self, filter: usize, planes: ArrayView2<'_, f32>) -> Array2<f32> {
        let (textons, waves) = self.averages[0].dim();
        let mut out = Array2::zeros((textons, planes.nrows()));
        for from in (0..waves).step_by(WAVES) {
            let block = s![.., from..(from + WAVES).min(waves)];
            let backward = self.backward(filter, from..(from + WAVES).min(waves));
            let planes = planes.slice(block).reversed_axes();
            multiply(backward.view(), planes, out.view_mut(), Target::Add);
        }
        out
    }

    /// One filter seen backwards by every average, on some waves: Σ_p d_{f,p} ∘ S_pᵀ A.
    fn backward(&self, filter: usize, waves: Range<usize>) -> Array2<f32> {
        let mut sum = Array2::zeros((self.averages[0].nrows(), waves.len()));
        for (parity, averages) in self.averages.iter().enumerate() {
            let factors = self.transfer.factors(parity);
            let factors = factors.slice(s![filter, waves.clone()]);
            if factors.iter().all(|&d| d == 0.0) {
                continue;
            }
            let averages = averages.slice(s![.., waves.clone()]);
            azip!((mut row in sum.outer_iter_mut(), averages in averages.outer_iter()) {
                azip!((sum in &mut row, &a in &averages, &d in &factors) *sum += a * d);
            });
        }
        sum
    }
}

/// Numbers as the rows of a matrix.
fn rows_of(numbers: Vec<f32>, rows: usize, columns: usize) -> Array2<f32> {
    match Array2::from_shape_vec((rows, columns), numbers) {
        Ok(matrix) => matrix,
        Err(error) => unreachable!("{rows} × {columns}: {error}"),
    }
}

/// Component plane · 48 + filter of every texton.
fn interleave(by_filter: &[Array2<f32>], mut target: ArrayViewMut2<'_, f32>) {
    target
        .axis_iter_mut(Axis(0))
        .into_par_iter()
        .enumerate()
        .for_each(|(texton, mut row)| {
            for (filter, components) in by_filter.iter().enumerate() {
                let from = components.row(texton);
                row.slice_mut(s![filter..;by_filter.len()]).assign(&from);
            }
        });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::TexelGrid;
    use crate::texton::filter_bank::leung_malik;
    use crate::texton::matrix::as_rows;
    use crate::texton::oracle;

    #[test]
    fn centroids_are_the_means_of_their_members() {
        let bank = leung_malik();
        for tileable in [true, false] {
            let grid = TexelGrid {
                width: 9,
                height: 6,
                tileable,
            };
            let planes: Vec<Vec<f32>> = (0..4)
                .map(|p| {
                    (0..54)
                        .map(|i| ((i * i * 31 + p * 17) % 29) as f32 / 29.0)
                        .collect()
                })
                .collect();
            let labels: Vec<u32> = (0..54).map(|i| (i * i + i / 7) % 5).collect();
            let counts: Vec<u32> = (0..5)
                .map(|j| labels.iter().filter(|&&l| l == j).count() as u32)
                .collect();
            let basis = PlaneBasis::new(grid);
            let transfer = basis.transfer(&bank);
            let mut coefficients = planes.concat();
            basis.analyze(&mut coefficients);
            let mut centroids = Array2::zeros((5, 4 * 48));
            BackwardFilters::new(&basis, &transfer, &labels, &counts)
                .centroids_into(as_rows(&coefficients, 4, 54), centroids.view_mut());
            let vectors = oracle::appearance_vectors(grid, &bank, &planes);
            for ((texton, d), v) in centroids.indexed_iter() {
                let members = (0..54).filter(|&i| labels[i] == texton as u32);
                let mean =
                    members.map(|i| vectors[[i, d]]).sum::<f64>() / f64::from(counts[texton]);
                assert!((f64::from(*v) - mean).abs() < 1e-6, "{v} against {mean}");
            }
        }
    }
}
