//! Orthonormal bases of a few long columns, in `f64` from `f32`.
//!
//! In: Z [rows, l]. Out: W [rows, l′] with the same span, columns by falling weight. The order matters beyond
//! the span: with X the images, X W then has columns as short as its small singular values, and `f32` keeps their
//! digits. So eigenvectors of ZᵀZ make a first basis of columns in any order. Columns that are in order already
//! are made orthonormal each against those before it, by the Cholesky factor of ZᵀZ, twice (Fukaya and
//! others 2014: once leaves the square of Z's condition in the angles).

use ndarray::{Array1, Array2, ArrayView2, Axis, s};

use crate::matrix::{Update, eigen, multiply_on_all_threads};

/// Rows widened to `f64` at once.
const ROWS: usize = 1 << 14;
/// Directions with less than this share of the largest one's energy, or of their own, are rounding.
const TOLERANCE: f64 = 1e-13;

/// An orthonormal basis of columns in no order, by falling energy.
pub fn principal_columns(columns: &Array2<f32>) -> Array2<f32> {
    let (values, vectors) = eigen(inner_products(columns.view()));
    let least = TOLERANCE * values.first().copied().unwrap_or(0.0);
    let sound = values.iter().take_while(|&&v| v > least && v > 0.0).count();
    let mut transform = vectors.slice(s![.., ..sound]).to_owned();
    for (mut column, value) in transform.columns_mut().into_iter().zip(&values) {
        column.mapv_inplace(|v| v / value.sqrt());
    }
    orthogonalized(&times(columns, &transform))
}

/// An orthonormal basis of columns in order of falling energy, in that order.
pub fn orthonormal_columns(columns: &Array2<f32>) -> Array2<f32> {
    orthogonalized(&orthogonalized(columns))
}

/// Every column less its part along those before it, at length 1; columns that are then nothing but rounding
/// are left out.
fn orthogonalized(columns: &Array2<f32>) -> Array2<f32> {
    let products = inner_products(columns.view());
    // Gram and Schmidt on the coefficients of Z's columns, each kept with its product with ZᵀZ.
    let mut kept: Vec<[Array1<f64>; 2]> = Vec::new();
    for at in 0..columns.ncols() {
        let own = products[[at, at]];
        let mut coefficients = Array1::zeros(columns.ncols());
        coefficients[at] = 1.0;
        for [before, weighted] in &kept {
            let along = coefficients.dot(weighted);
            coefficients.scaled_add(-along, before);
        }
        let weighted = products.dot(&coefficients);
        let left = coefficients.dot(&weighted);
        if left > TOLERANCE * own && own > 0.0 {
            kept.push([coefficients, weighted].map(|vector| vector / left.sqrt()));
        }
    }
    let transform = Array2::from_shape_fn((columns.ncols(), kept.len()), |(i, j)| kept[j][0][i]);
    times(columns, &transform)
}

/// ZᵀZ of the columns of Z.
pub fn inner_products(columns: ArrayView2<'_, f32>) -> Array2<f64> {
    let mut products = Array2::zeros((columns.ncols(), columns.ncols()));
    for rows in columns.axis_chunks_iter(Axis(0), ROWS) {
        let wide = rows.mapv(f64::from);
        multiply_on_all_threads(wide.t(), wide.view(), products.view_mut(), Update::Add);
    }
    products
}

/// Z times a small matrix, summed in `f64`.
pub fn times(columns: &Array2<f32>, transform: &Array2<f64>) -> Array2<f32> {
    let mut out = Array2::zeros((columns.nrows(), transform.ncols()));
    for first in (0..columns.nrows()).step_by(ROWS) {
        let rows = s![first..columns.nrows().min(first + ROWS), ..];
        let wide = columns.slice(rows).mapv(f64::from);
        let mut product = Array2::zeros((wide.nrows(), transform.ncols()));
        multiply_on_all_threads(
            wide.view(),
            transform.view(),
            product.view_mut(),
            Update::Replace,
        );
        out.slice_mut(rows).assign(&product.mapv(|v| v as f32));
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bases_are_orthonormal_and_span_the_columns() {
        // Columns of very different lengths, and two that depend on the others.
        let columns = Array2::from_shape_fn((500, 6), |(r, c)| {
            let wave = |c: usize| ((r * (c + 2)) as f32 * 0.37).sin() * 10_f32.powi(-(c as i32));
            match c {
                4 => wave(0) + wave(1),
                5 => 0.0,
                _ => wave(c),
            }
        });
        for basis in [principal_columns(&columns), orthonormal_columns(&columns)] {
            check(&columns, &basis);
        }
    }

    fn check(columns: &Array2<f32>, basis: &Array2<f32>) {
        assert_eq!(basis.ncols(), 4);
        let products = inner_products(basis.view());
        for ((i, j), &product) in products.indexed_iter() {
            let wanted = if i == j { 1.0 } else { 0.0 };
            assert!((product - wanted).abs() < 1e-6, "{i} {j} {product}");
        }
        let wide = basis.mapv(f64::from);
        for column in columns.mapv(f64::from).columns() {
            let coordinates = wide.t().dot(&column);
            let rest = &column - &wide.dot(&coordinates);
            assert!(rest.dot(&rest) <= 1e-9 * column.dot(&column) + 1e-12);
        }
    }
}
