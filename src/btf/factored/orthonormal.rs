//! Orthonormal bases of a few long columns, in `f64` from `f32`.
//!
//! In: Z [rows, l]. Out: W [rows, l′] with the same span, columns by falling weight. The columns are
//! scaled to length 1 first, and the eigenvectors of the small matrix ZᵀZ make the basis; done
//! twice, since once leaves the square of ZᵀZ's condition in the angles (as Cholesky QR does:
//! Fukaya and others 2014).

use ndarray::{Array2, ArrayView2, Axis, s};

use crate::matrix::{Target, eigen, multiply_on_all_threads};

/// Rows widened to `f64` at once.
const ROWS: usize = 1 << 14;
/// Directions with less than this share of the largest one's energy are rounding.
const TOLERANCE: f64 = 1e-12;

/// An orthonormal basis of the columns.
pub fn orthonormal_columns(columns: &Array2<f32>) -> Array2<f32> {
    let once = whitened(columns);
    whitened(&once)
}

fn whitened(columns: &Array2<f32>) -> Array2<f32> {
    let products = inner_products(columns.view());
    let scales: Vec<f64> = products.diag().iter().map(|square| square.sqrt()).collect();
    let kept: Vec<usize> = (0..scales.len()).filter(|&at| scales[at] > 0.0).collect();
    let scaled = Array2::from_shape_fn((kept.len(), kept.len()), |(i, j)| {
        let (i, j) = (kept[i], kept[j]);
        products[[i, j]] / (scales[i] * scales[j])
    });
    let (values, vectors) = eigen(scaled);
    let least = TOLERANCE * values.first().copied().unwrap_or(0.0);
    let sound = values.iter().take_while(|&&value| value > least).count();
    let mut transform = Array2::zeros((scales.len(), sound));
    for (from, &to) in kept.iter().enumerate() {
        for direction in 0..sound {
            transform[[to, direction]] =
                vectors[[from, direction]] / (values[direction].sqrt() * scales[to]);
        }
    }
    times(columns, &transform)
}

/// ZᵀZ of the columns of Z.
pub fn inner_products(columns: ArrayView2<'_, f32>) -> Array2<f64> {
    let mut products = Array2::zeros((columns.ncols(), columns.ncols()));
    for rows in columns.axis_chunks_iter(Axis(0), ROWS) {
        let wide = rows.mapv(f64::from);
        multiply_on_all_threads(wide.t(), wide.view(), products.view_mut(), Target::Add);
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
            Target::Replace,
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
        let basis = orthonormal_columns(&columns);
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
