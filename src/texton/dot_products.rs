//! Dot products of textons, the Gram matrix Φ of Tong 2002 §4, from their appearance vectors.
//!
//! In: rows of `f32`. Out: all products in `f64`: products are taken panel by panel of components
//! in `f64`, so that they are exact to the inputs' rounding.

use ndarray::{Array2, ArrayView2, Axis, s};
use rayon::prelude::*;

use crate::texton::matrix::{Target, multiply};

/// Rows of Φ that one task makes.
const BLOCK: usize = 64;
/// Components converted to `f64` at once.
const PANEL: usize = 2048;

/// Φ [rows, rows] of row vectors.
pub fn dot_products(vectors: ArrayView2<'_, f32>) -> Array2<f64> {
    let mut products = Array2::<f64>::zeros((vectors.nrows(), vectors.nrows()));
    for panel in vectors.axis_chunks_iter(Axis(1), PANEL) {
        let panel = panel.mapv(f64::from);
        products
            .axis_chunks_iter_mut(Axis(0), BLOCK)
            .into_par_iter()
            .enumerate()
            .for_each(|(block, mut target)| {
                let (from, to) = (block * BLOCK, block * BLOCK + target.nrows());
                multiply(
                    panel.slice(s![from..to, ..]),
                    panel.slice(s![..to, ..]).reversed_axes(),
                    target.slice_mut(s![.., ..to]),
                    Target::Add,
                );
            });
    }
    for row in 0..products.nrows() {
        for col in row + 1..products.nrows() {
            products[[row, col]] = products[[col, row]];
        }
    }
    products
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn products_are_exact_in_f64() {
        let vectors =
            Array2::from_shape_fn((70, 5000), |(r, c)| ((r * 31 + c * 17) % 101) as f32 / 7.0);
        let exact = vectors.mapv(f64::from);
        let exact = exact.dot(&exact.t());
        for (a, b) in dot_products(vectors.view()).iter().zip(&exact) {
            assert!((a - b).abs() <= 1e-12 * b.abs());
        }
    }
}
