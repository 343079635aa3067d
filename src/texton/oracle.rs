//! Slow exact routes in `f64`, for tests: convolution by its definition, appearance vectors in
//! full, dot products one by one.

use ndarray::{Array2, Array3};

use crate::grid::TexelGrid;
use crate::texton::filter_bank::CENTRE;

/// Responses [filters, texels] of an image by direct convolution, wrapped or repeatedly reflected.
pub fn responses(grid: TexelGrid, bank: &Array3<f64>, image: &[f32]) -> Array2<f64> {
    let (filters, taps, _) = bank.dim();
    let (height, width) = (i64::from(grid.height), i64::from(grid.width));
    let at = |x: i64, side: i64| {
        if grid.tileable {
            return x.rem_euclid(side);
        }
        let folded = x.rem_euclid(2 * side);
        folded.min(2 * side - 1 - folded)
    };
    Array2::from_shape_fn((filters, grid.len()), |(filter, texel)| {
        let (row, col) = (texel as i64 / width, texel as i64 % width);
        let mut sum = 0.0;
        for u in 0..taps {
            for v in 0..taps {
                let (y, x) = (
                    row - (u as i64 - CENTRE as i64),
                    col - (v as i64 - CENTRE as i64),
                );
                let value = image[(at(y, height) * width + at(x, width)) as usize];
                sum += bank[[filter, u, v]] * f64::from(value);
            }
        }
        sum
    })
}

/// Appearance vectors [texels, planes · 48] of a stack of planes.
pub fn appearance_vectors(grid: TexelGrid, bank: &Array3<f64>, planes: &[Vec<f32>]) -> Array2<f64> {
    let filters = bank.dim().0;
    let mut vectors = Array2::zeros((grid.len(), planes.len() * filters));
    for (at, plane) in planes.iter().enumerate() {
        for ((filter, texel), r) in responses(grid, bank, plane).indexed_iter() {
            vectors[[texel, at * filters + filter]] = *r;
        }
    }
    vectors
}
