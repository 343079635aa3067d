//! Appearance vectors in few numbers, for levels whose dot products are too many to hold.
//!
//! In: the representative images. Out: for every texel its coordinates in a subspace of the
//! appearance vectors' space, found from the data, leading directions first. The subspace is the
//! span of sums of the texels' vectors with random signs (Halko, Martinsson and Tropp 2011 §1.3): with V
//! [texels, components] and sparse random signs G, the rows of G V; they are summed as
//! centres are. The coordinates are V Qᵀ with Q an orthonormal basis of them, a product of every
//! plane's responses with Q's columns. An orthogonal projection shortens distances and never
//! lengthens them; by how much is measured on a sub-grid of texels against their exact vectors.

use ndarray::{Array2, Array3, ArrayView2, Axis, s};

use crate::error::Result;
use crate::grid::TexelGrid;
use crate::matrix::{Update, as_rows, eigen, multiply_on_all_threads};
use crate::progress::Progress;
use crate::texton::fft_filters::FftFilters;
use crate::texton::gram::gram_matrix;
use crate::texton::point_filters::PointFilters;
use crate::texton::scatter_matrix::ScatterMatrix;

/// Numbers per texel.
pub const COORDINATES: usize = 256;
/// Responses held at once.
const BATCH_NUMBERS: usize = 1 << 24;
/// Directions with less than this share of the largest direction's energy are rounding.
const RANK_TOLERANCE: f64 = 1e-9;
/// Texel rows and columns on which the sketch is measured.
const PROBES: usize = 24;

/// An orthonormal basis [directions, components] of the rows' span.
pub fn orthonormal_rows(rows: &Array2<f32>) -> Result<Array2<f32>> {
    let (values, vectors) = eigen(gram_matrix(rows)?);
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
        Update::Replace,
    );
    Ok(basis)
}

/// Coordinates under construction: V Qᵀ, growing plane by plane.
pub struct Coordinates<'a> {
    filters: &'a FftFilters,
    /// Q [directions, components].
    directions: Array2<f32>,
    /// [texels, directions].
    sums: Array2<f32>,
}

impl<'a> Coordinates<'a> {
    /// Coordinates along the rows of `directions`, no plane added yet.
    pub fn new(filters: &'a FftFilters, directions: Array2<f32>) -> Self {
        let sums = Array2::zeros((filters.texels(), directions.nrows()));
        Self {
            filters,
            directions,
            sums,
        }
    }

    /// Adds planes, one after another, the first of them plane number `first`.
    pub fn add(&mut self, planes: &[f32], first: usize) {
        let (texels, count) = (self.filters.texels(), self.filters.count());
        let batch = 2 * (BATCH_NUMBERS / (2 * texels * count)).max(1);
        for (at, planes) in planes.chunks(batch * texels).enumerate() {
            let responses = self.filters.responses(planes);
            let from = (first + at * batch) * count;
            let components = s![.., from..from + responses.nrows()];
            multiply_on_all_threads(
                responses.t(),
                self.directions.slice(components).reversed_axes(),
                self.sums.view_mut(),
                Update::Add,
            );
        }
    }

    /// Coordinates [texels, directions].
    pub fn finish(self) -> Array2<f32> {
        self.sums
    }
}

/// Texels on a sub-grid whose dot products are made exactly, to measure a sketch by.
pub struct Probes {
    point_filters: PointFilters,
    products: ScatterMatrix,
}

impl Probes {
    /// Probes of a grid; no plane added yet.
    pub fn new(grid: TexelGrid, bank: &Array3<f64>) -> Self {
        let point_filters = PointFilters::new(grid, bank, PROBES);
        let products = ScatterMatrix::new(point_filters.points().len());
        Self {
            point_filters,
            products,
        }
    }

    /// Adds planes, one after another.
    pub fn add(&mut self, planes: &[f32], progress: Progress<'_>) {
        let responses = self.point_filters.responses(planes);
        let points = self.point_filters.points().len();
        for response in responses.outer_iter() {
            if let Some(numbers) = response.to_slice() {
                let filters = numbers.len() / points;
                let columns = as_rows(numbers, points, filters).reversed_axes();
                self.products.add(columns, progress);
            }
        }
    }

    /// The probe texels and their dot products.
    pub fn finish(self, progress: Progress<'_>) -> Result<(Vec<usize>, Array2<f32>)> {
        Ok((self.point_filters.points(), self.products.finish(progress)?))
    }
}

/// Turns coordinates so that their variance falls from component to component, and takes off
/// their mean.
pub fn principal(mut coordinates: Array2<f32>, progress: Progress<'_>) -> Result<Array2<f32>> {
    if let Some(mean) = coordinates.mapv(f64::from).mean_axis(Axis(0)) {
        coordinates -= &mean.mapv(|v| v as f32);
    }
    let mut covariance = ScatterMatrix::new(coordinates.ncols());
    covariance.add(coordinates.view(), progress);
    let (_, vectors) = eigen(covariance.finish(progress)?.mapv(f64::from));
    progress.check()?;
    let vectors = vectors.mapv(|v| v as f32);
    let mut turned = Array2::zeros(coordinates.raw_dim());
    multiply_on_all_threads(
        coordinates.view(),
        vectors.view(),
        turned.view_mut(),
        Update::Replace,
    );
    Ok(turned)
}

/// How faithful coordinates are, measured on some texels against their exact dot products.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fidelity {
    /// Share of the exact vectors' variance that the coordinates keep.
    pub explained_variance: f64,
    /// Mean of 1 − (distance² in coordinates) / (exact distance²) over pairs.
    pub distortion: f64,
    /// Exact variance that the coordinates lose, per texel.
    pub lost_per_texel: f64,
}

impl Fidelity {
    /// Compares coordinates of probe texels [probes, directions] with their exact Gram matrix.
    pub fn measure(coordinates: ArrayView2<'_, f32>, exact: &Array2<f32>) -> Result<Self> {
        let found = gram_matrix(&coordinates)?;
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
        Ok(Self {
            explained_variance: if exact_sum > 0.0 {
                found_sum / exact_sum
            } else {
                1.0
            },
            distortion: if pairs > 0.0 { ratio_sum / pairs } else { 0.0 },
            // Σ over pairs of distance² is probes² times the variance.
            lost_per_texel: ((exact_sum - found_sum) / (probes * probes)).max(0.0),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::stream;
    use crate::texton::filter_bank::{FILTERS, leung_malik};
    use crate::texton::oracle;
    use crate::texton::response_sums::sum_responses;
    use crate::texton::texel_sums::TexelSums;

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
            let filters = FftFilters::new(grid, &bank);
            let place = |texel| filters.place(texel);
            let texel_sums = TexelSums::random(48, 48, place, &mut stream(1, "mix", 0, 0));
            let mut rows = Array2::zeros((48, 5 * FILTERS));
            sum_responses(
                &filters,
                &texel_sums,
                &planes.concat(),
                vec![rows.view_mut()],
            );
            let mut sketch = Coordinates::new(&filters, orthonormal_rows(&rows).unwrap());
            sketch.add(&planes[..2].concat(), 0);
            sketch.add(&planes[2..].concat(), 2);
            let coordinates = sketch.finish();
            let vectors = oracle::appearance_vectors(grid, &bank, &planes);
            let exact = vectors.dot(&vectors.t()).mapv(|v| v as f32);
            let fidelity = Fidelity::measure(coordinates.view(), &exact).unwrap();
            assert!(
                (fidelity.explained_variance - 1.0).abs() < 1e-4,
                "{fidelity:?}"
            );
            let turned = principal(coordinates, Progress::silent()).unwrap();
            let turned = Fidelity::measure(turned.view(), &exact).unwrap();
            assert!(turned.distortion.abs() < 1e-3, "{turned:?}");
        }
    }

    #[test]
    fn probes_are_exact_dot_products_of_their_texels() {
        let bank = leung_malik();
        let grid = TexelGrid {
            width: 30,
            height: 5,
            tileable: false,
        };
        let plane = |p: usize| (0..150).map(move |i| ((i * i * 7 + p * 17) % 29) as f32 / 29.0);
        let planes: Vec<Vec<f32>> = (0..2).map(|p| plane(p).collect()).collect();
        let mut probes = Probes::new(grid, &bank);
        probes.add(&planes.concat(), Progress::silent());
        let (texels, products) = probes.finish(Progress::silent()).unwrap();
        assert_eq!(texels.len(), 24 * 5);
        let vectors = oracle::appearance_vectors(grid, &bank, &planes).select(Axis(0), &texels);
        for (a, b) in products.iter().zip(&vectors.dot(&vectors.t())) {
            assert!((f64::from(*a) - b).abs() < 1e-5, "{a} against {b}");
        }
    }
}
