//! All dot products of a level's appearance vectors, K = V Vᵀ, without one filter response.
//!
//! In: the images' coefficients in the basis where filters are diagonal. Out: K [texels, texels].
//! With Î the coefficients and Ĉ = Î Îᵀ,
//!
//! K = Σ_{p,q} S_p (Ĉ ∘ Σ_f d_{f,p} d_{f,q}ᵀ) S_qᵀ,
//!
//! summed over the parities p and q (see [`filter_eigenbasis`](crate::texton::filter_eigenbasis)): a product of
//! coefficients, a Hadamard product of rank 48, and transforms along four axes. Nothing is
//! approximated; numbers are `f32`, means of images never enter. Needs two matrices of texels²
//! numbers; a level too large for them takes another route.

use ndarray::{Array2, ArrayView2, Axis, s};
use rayon::prelude::*;

use crate::error::Result;
use crate::matrix::{Update, as_rows, as_rows_mut, multiply, multiply_on_all_threads, product_of};
use crate::progress::Progress;
use crate::texton::filter_eigenbasis::{FilterEigenbasis, PARITIES, PLANE_PARITIES, Transfer};

/// Columns transformed at once along the rows' y axis.
const PANEL: usize = 8192;

/// Bytes that Ĉ and [`texel_gram`] need together.
pub fn bytes(texels: usize) -> u64 {
    2 * 4 * (texels as u64) * (texels as u64)
}

/// K [texels, texels], from the images' Ĉ [waves, waves].
pub fn texel_gram(
    covariance: Array2<f32>,
    basis: &FilterEigenbasis,
    transfer: &Transfer,
    progress: Progress<'_>,
) -> Result<Array2<f32>> {
    let (height, width) = basis.sides();
    let pairs = ParityPairs::new(transfer);
    let mut even = covariance;
    let mut odd = Array2::zeros(even.raw_dim());
    progress.begin("texel dot products", height as u64);
    even.axis_chunks_iter_mut(Axis(0), width)
        .into_par_iter()
        .zip(odd.axis_chunks_iter_mut(Axis(0), width))
        .enumerate()
        .try_for_each(|(wave_y, (mut even, mut odd))| {
            let [with_even, with_odd] =
                pairs.transform_rows(basis, wave_y, even.view(), progress)?;
            even.assign(&with_even);
            odd.assign(&with_odd);
            progress.advance(1)
        })?;
    finish_along_y(basis, &mut even, &odd, progress)?;
    progress.end();
    Ok(even)
}

/// The transfer factors of the filters that two parities share.
struct ParityPairs {
    /// For p and q: d_p and d_q of the shared filters, [filters, waves]; `None` without any.
    shared: Vec<Option<[Array2<f32>; 2]>>,
}

impl ParityPairs {
    fn new(transfer: &Transfer) -> Self {
        let count = PLANE_PARITIES.len();
        let shared = (0..count * count)
            .map(|pair| {
                let (p, q) = (pair / count, pair % count);
                let filters = transfer.filters_with(p, q);
                let select = |parity| transfer.factors(parity).select(Axis(0), &filters);
                (!filters.is_empty()).then(|| [select(p), select(q)])
            })
            .collect();
        Self { shared }
    }

    /// Rows (ky, all kx) of Ĉ, weighted, transformed along both axes of the columns and along x
    /// of the rows: what is to be transformed along y by the even and by the odd waves.
    fn transform_rows(
        &self,
        basis: &FilterEigenbasis,
        wave_y: usize,
        rows: ArrayView2<'_, f32>,
        progress: Progress<'_>,
    ) -> Result<[Array2<f32>; 2]> {
        let mut sums = PARITIES.map(|_| Array2::zeros(rows.raw_dim()));
        for (p, [py, px]) in PLANE_PARITIES.into_iter().enumerate() {
            progress.check()?;
            let columns = self.transform_columns(basis, wave_y, p, rows);
            multiply(
                basis.x.synthesis(px),
                columns.view(),
                sums[py as usize].view_mut(),
                Update::Add,
            );
        }
        Ok(sums)
    }

    /// Σ_q (Ĉ ∘ Σ_f d_p d_qᵀ) S_qᵀ for the rows of one ky.
    fn transform_columns(
        &self,
        basis: &FilterEigenbasis,
        wave_y: usize,
        p: usize,
        rows: ArrayView2<'_, f32>,
    ) -> Array2<f32> {
        let (height, width) = basis.sides();
        let lines = rows.nrows() * height;
        // Weight the waves, and transform them along x.
        let mut along_x = PARITIES.map(|_| Array2::<f32>::zeros((lines, width)));
        for (q, [qy, qx]) in PLANE_PARITIES.into_iter().enumerate() {
            let Some([left, right]) = &self.shared[p * PLANE_PARITIES.len() + q] else {
                continue;
            };
            let left = left.slice(s![.., wave_y * width..(wave_y + 1) * width]);
            let mut weighted = product_of(left.reversed_axes(), right.view());
            weighted *= &rows;
            let Some(numbers) = weighted.as_slice() else {
                continue;
            };
            multiply(
                as_rows(numbers, lines, width),
                basis.x.synthesis(qx).reversed_axes(),
                along_x[qy as usize].view_mut(),
                Update::Add,
            );
        }
        // Transform them along y.
        let mut columns = Array2::zeros(rows.raw_dim());
        for (qy, lines) in PARITIES.into_iter().zip(&along_x) {
            for (mut row, plane) in columns
                .outer_iter_mut()
                .zip(lines.axis_chunks_iter(Axis(0), height))
            {
                let Some(row) = row.as_slice_mut() else {
                    continue;
                };
                let target = as_rows_mut(row, height, width);
                multiply(basis.y.synthesis(qy), plane, target, Update::Add);
            }
        }
        columns
    }
}

/// K = S_e even + S_o odd along the y axis of the rows; `even` becomes K.
fn finish_along_y(
    basis: &FilterEigenbasis,
    even: &mut Array2<f32>,
    odd: &Array2<f32>,
    progress: Progress<'_>,
) -> Result<()> {
    let (height, width) = basis.sides();
    let columns = width * even.ncols();
    let (Some(even), Some(odd)) = (even.as_slice_mut(), odd.as_slice()) else {
        unreachable!("both were made in rows");
    };
    let (mut even, odd) = (
        as_rows_mut(even, height, columns),
        as_rows(odd, height, columns),
    );
    for from in (0..columns).step_by(PANEL) {
        progress.check()?;
        let panel = s![.., from..(from + PANEL).min(columns)];
        let waves = [even.slice(panel).to_owned(), odd.slice(panel).to_owned()];
        for (parity, waves) in PARITIES.into_iter().zip(&waves) {
            // The first product takes the place of the waves.
            let update = match parity == PARITIES[0] {
                true => Update::Replace,
                false => Update::Add,
            };
            multiply_on_all_threads(
                basis.y.synthesis(parity),
                waves.view(),
                even.slice_mut(panel),
                update,
            );
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::TexelGrid;
    use crate::texton::filter_bank::leung_malik;
    use crate::texton::oracle;
    use crate::texton::scatter_matrix::ScatterMatrix;

    fn planes(grid: TexelGrid, count: usize) -> Vec<Vec<f32>> {
        (0..count)
            .map(|p| {
                (0..grid.len())
                    .map(|i| ((i * 7919 + p * 104_729 + i * i * (p + 3)) % 257) as f32 / 257.0)
                    .collect()
            })
            .collect()
    }

    #[test]
    fn the_gram_route_is_the_plain_route_at_both_borders() {
        let bank = leung_malik();
        for (height, width) in [(8, 12), (9, 7)] {
            for tileable in [true, false] {
                let grid = TexelGrid {
                    width,
                    height,
                    tileable,
                };
                let planes = planes(grid, 5);
                let vectors = oracle::appearance_vectors(grid, &bank, &planes);
                let exact = vectors.dot(&vectors.t());
                let basis = FilterEigenbasis::new(grid);
                let mut covariance = ScatterMatrix::new(grid.len());
                let coefficients = basis.coefficients(&planes.concat());
                covariance.add(
                    as_rows(&coefficients, planes.len(), grid.len()),
                    Progress::silent(),
                );
                let transfer = basis.transfer(&bank);
                let covariance = covariance.finish(Progress::silent()).unwrap();
                let gram = texel_gram(covariance, &basis, &transfer, Progress::silent()).unwrap();
                let scale = exact.diag().iter().fold(0.0_f64, |a, &b| a.max(b));
                for (a, b) in gram.iter().zip(&exact) {
                    assert!((f64::from(*a) - b).abs() < 1e-6 * scale, "{a} against {b}");
                }
            }
        }
    }
}
