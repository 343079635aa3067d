//! Appearance vectors in few numbers, for levels whose dot products are too many to hold.
//!
//! In: the representative images. Out: for every texel its coordinates in a subspace of the
//! appearance vectors' space, found from the data, leading directions first. The subspace is the
//! span of random mixtures of the texels' vectors (Halko, Martinsson and Tropp 2011 §1.3): with V
//! [texels, components] and random signs G, the rows of G V; they are filtered backwards as
//! centres are. The coordinates are V Qᵀ with Q an orthonormal basis of them, filtered forwards:
//! V Qᵀ = Σ_p S_p Σ_f d_{f,p} ∘ (Q_f Î). An orthogonal projection shortens distances and never
//! lengthens them; by how much is measured on a sub-grid of texels against their exact vectors.

use nalgebra::{DMatrix, SymmetricEigen};
use ndarray::{Array2, ArrayView2, Axis, s};
use rand::Rng;
use rayon::prelude::*;

use crate::random::Stream;
use crate::texton::basis::{PLANE_PARITIES, PlaneBasis, Transfer};
use crate::texton::dot_products::dot_products;
use crate::texton::filter_bank::FILTERS;
use crate::texton::matrix::{
    Target, as_rows, as_rows_mut, multiply, multiply_on_all_threads, product_of,
};
use crate::texton::outer_products::OuterProducts;

/// Numbers a texel.
pub const COORDINATES: usize = 256;
/// Waves that one task weights.
const WAVES: usize = 2048;
/// Directions with less than this share of the largest direction's energy are rounding.
const RANK_TOLERANCE: f64 = 1e-9;
/// Texel rows and columns on which the sketch is measured.
pub const PROBES: usize = 24;

/// Random signs over texels, [mixtures · texels].
pub fn random_mixtures(texels: usize, random: &mut Stream) -> Vec<f32> {
    let scale = (texels as f32).sqrt().recip();
    let sign = |positive: bool| if positive { scale } else { -scale };
    (0..COORDINATES.min(texels) * texels)
        .map(|_| sign(random.r#gen()))
        .collect()
}

/// An orthonormal basis [directions, components] of the rows' span.
pub fn orthonormal_rows(rows: &Array2<f32>) -> Array2<f32> {
    let (values, vectors) = eigen(dot_products(rows.view()));
    let largest = values.first().copied().unwrap_or(0.0);
    let kept = values
        .iter()
        .take_while(|&&v| v > RANK_TOLERANCE * largest && v > 0.0)
        .count();
    let scaled = Array2::from_shape_fn((kept, rows.nrows()), |(direction, row)| {
        (vectors[[row, direction]] / values[direction].sqrt()) as f32
    });
    let mut basis = Array2::zeros((kept, rows.ncols()));
    multiply_on_all_threads(
        scaled.view(),
        rows.view(),
        basis.view_mut(),
        Target::Replace,
    );
    basis
}

/// Eigenvalues, largest first, and eigenvectors as columns of a symmetric matrix.
fn eigen(matrix: Array2<f64>) -> (Vec<f64>, Array2<f64>) {
    let side = matrix.nrows();
    let found = SymmetricEigen::new(DMatrix::from_fn(side, side, |i, j| matrix[[i, j]]));
    let mut order: Vec<usize> = (0..side).collect();
    order.sort_by(|&a, &b| found.eigenvalues[b].total_cmp(&found.eigenvalues[a]));
    let values = order.iter().map(|&at| found.eigenvalues[at]).collect();
    let vectors = Array2::from_shape_fn((side, side), |(i, j)| found.eigenvectors[(i, order[j])]);
    (values, vectors)
}

/// Coordinates under construction: Σ_f d_{f,p} ∘ (Q_f Î), growing image by image.
pub struct ForwardSketch<'a> {
    basis: &'a PlaneBasis,
    transfer: &'a Transfer,
    /// Q [directions, components].
    directions: Array2<f32>,
    /// For each block of waves and each parity [directions, waves of the block].
    blocks: Vec<Vec<Array2<f32>>>,
}

impl<'a> ForwardSketch<'a> {
    /// Coordinates along the rows of `directions`, no image added yet.
    pub fn new(basis: &'a PlaneBasis, transfer: &'a Transfer, directions: Array2<f32>) -> Self {
        let waves = basis.grid.len();
        let blocks = (0..waves)
            .step_by(WAVES)
            .map(|from| {
                let sides = (directions.nrows(), WAVES.min(waves - from));
                PLANE_PARITIES
                    .iter()
                    .map(|_| Array2::zeros(sides))
                    .collect()
            })
            .collect();
        Self {
            basis,
            transfer,
            directions,
            blocks,
        }
    }

    /// Adds planes of coefficients [planes, waves], the first of them plane number `first`.
    pub fn add(&mut self, planes: ArrayView2<'_, f32>, first: usize) {
        let (directions, transfer) = (&self.directions, self.transfer);
        let components = s![.., first * FILTERS..(first + planes.nrows()) * FILTERS];
        let directions = directions.slice(components);
        self.blocks.par_iter_mut().enumerate().for_each(|(at, sums)| {
            let waves = s![.., at * WAVES..at * WAVES + sums[0].ncols()];
            let planes = planes.slice(waves);
            for filter in 0..FILTERS {
                let of_filter = directions.slice(s![.., filter..;FILTERS]);
                let mixed = product_of(of_filter, planes);
                for (parity, sum) in sums.iter_mut().enumerate() {
                    let factors = transfer.factors(parity).slice_move(waves);
                    let factors = factors.row(filter);
                    if factors.iter().any(|&d| d != 0.0) {
                        ndarray::azip!((mut row in sum.outer_iter_mut(), mixed in mixed.outer_iter()) {
                            ndarray::azip!((s in &mut row, &m in &mixed, &d in &factors) *s += m * d);
                        });
                    }
                }
            }
        });
    }

    /// Coordinates [texels, directions].
    pub fn finish(self) -> Array2<f32> {
        let (height, width) = self.basis.sides();
        let texels = height * width;
        let count = self.directions.nrows();
        let mut by_direction = Array2::<f32>::zeros((count, texels));
        by_direction
            .axis_iter_mut(Axis(0))
            .into_par_iter()
            .enumerate()
            .for_each(|(direction, mut out)| {
                let Some(out) = out.as_slice_mut() else {
                    return;
                };
                for (parity, [y, x]) in PLANE_PARITIES.into_iter().enumerate() {
                    let waves: Vec<f32> = self
                        .blocks
                        .iter()
                        .flat_map(|block| block[parity].row(direction).to_vec())
                        .collect();
                    let lines = as_rows(&waves, height, width);
                    let along_x = product_of(lines, self.basis.x.synthesis(x).reversed_axes());
                    let target = as_rows_mut(out, height, width);
                    multiply(
                        self.basis.y.synthesis(y),
                        along_x.view(),
                        target,
                        Target::Add,
                    );
                }
            });
        by_direction.reversed_axes().as_standard_layout().to_owned()
    }
}

/// Turns coordinates so that their variance falls from component to component, and takes off
/// their mean.
pub fn principal(mut coordinates: Array2<f32>) -> Array2<f32> {
    if let Some(mean) = coordinates.mapv(f64::from).mean_axis(Axis(0)) {
        coordinates -= &mean.mapv(|v| v as f32);
    }
    let mut covariance = OuterProducts::new(coordinates.ncols());
    covariance.add(coordinates.view());
    let (_, vectors) = eigen(covariance.finish().mapv(f64::from));
    let vectors = vectors.mapv(|v| v as f32);
    let mut turned = Array2::zeros(coordinates.raw_dim());
    multiply_on_all_threads(
        coordinates.view(),
        vectors.view(),
        turned.view_mut(),
        Target::Replace,
    );
    turned
}

/// How faithful coordinates are, measured on some texels against their exact dot products.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fidelity {
    /// Share of the exact vectors' variance that the coordinates keep.
    pub explained_variance: f64,
    /// Mean of 1 − (distance² in coordinates) / (exact distance²) over pairs.
    pub distortion: f64,
    /// Exact variance that the coordinates lose, a texel.
    pub lost_per_texel: f64,
}

impl Fidelity {
    /// Compares coordinates of probe texels [probes, directions] with their exact Gram matrix.
    pub fn measure(coordinates: ArrayView2<'_, f32>, exact: &Array2<f32>) -> Self {
        let found = dot_products(coordinates);
        let distance =
            |gram: &dyn Fn(usize, usize) -> f64, a, b| gram(a, a) + gram(b, b) - 2.0 * gram(a, b);
        let (mut exact_sum, mut found_sum, mut ratio_sum, mut pairs) = (0.0, 0.0, 0.0, 0.0);
        for a in 0..exact.nrows() {
            for b in a + 1..exact.nrows() {
                let true_distance = distance(&|i, j| f64::from(exact[[i, j]]), a, b);
                let kept = distance(&|i, j| found[[i, j]], a, b);
                exact_sum += true_distance;
                found_sum += kept;
                if true_distance > 0.0 {
                    ratio_sum += 1.0 - kept / true_distance;
                    pairs += 1.0;
                }
            }
        }
        let probes = exact.nrows() as f64;
        Self {
            explained_variance: if exact_sum > 0.0 {
                found_sum / exact_sum
            } else {
                1.0
            },
            distortion: if pairs > 0.0 { ratio_sum / pairs } else { 0.0 },
            // Σ over pairs of distance² is probes² times the variance.
            lost_per_texel: ((exact_sum - found_sum) / (probes * probes)).max(0.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::TexelGrid;
    use crate::random::stream;
    use crate::texton::centroids::BackwardFilters;
    use crate::texton::filter_bank::leung_malik;
    use crate::texton::oracle;

    #[test]
    fn with_as_many_directions_as_texels_the_sketch_is_exact() {
        let bank = leung_malik();
        for tileable in [true, false] {
            let grid = TexelGrid {
                width: 8,
                height: 6,
                tileable,
            };
            let planes: Vec<Vec<f32>> = (0..5)
                .map(|p| {
                    (0..48)
                        .map(|i| ((i * i * 31 + p * 17 + i * p) % 29) as f32 / 29.0)
                        .collect()
                })
                .collect();
            let basis = PlaneBasis::new(grid);
            let transfer = basis.transfer(&bank);
            let mut coefficients = planes.concat();
            basis.analyze(&mut coefficients);
            let coefficients = as_rows(&coefficients, 5, 48);
            let mixtures = random_mixtures(48, &mut stream(1, "mix", 0, 0));
            let mut rows = Array2::zeros((48, 5 * FILTERS));
            BackwardFilters::of_functions(&basis, &transfer, &mixtures)
                .centroids_into(coefficients, rows.view_mut());
            let mut sketch = ForwardSketch::new(&basis, &transfer, orthonormal_rows(&rows));
            sketch.add(coefficients.slice(s![..2, ..]), 0);
            sketch.add(coefficients.slice(s![2.., ..]), 2);
            let coordinates = sketch.finish();
            let vectors = oracle::appearance_vectors(grid, &bank, &planes);
            let exact = vectors.dot(&vectors.t()).mapv(|v| v as f32);
            let fidelity = Fidelity::measure(coordinates.view(), &exact);
            assert!(
                (fidelity.explained_variance - 1.0).abs() < 1e-4,
                "{fidelity:?}"
            );
            let turned = Fidelity::measure(principal(coordinates).view(), &exact);
            assert!(turned.distortion.abs() < 1e-3, "{turned:?}");
        }
    }
}
