//! Dot products of textons, the Gram matrix Φ of Tong 2002 §4, from their appearance vectors.
//!
//! In: rows of `f32`, which may stay in their file. Out: all products in `f64`, taken panel by panel of components
//! in `f64`, so that they are exact to the inputs' rounding.

use std::ops::Range;

use ndarray::{Array2, ArrayBase, ArrayView2, ArrayViewMut2, Axis, Data, Ix2, s};
use rayon::prelude::*;

use crate::format::stored_array::StoredArray;
use crate::texton::matrix::{Target, multiply};

/// Sides of the tiles of Φ.
const TILE: usize = 128;
/// Components converted to `f64` at once.
const PANEL: usize = 4096;

/// Row vectors that dot products are wanted of, in memory or in a file.
pub trait RowVectors: Sync {
    /// How many vectors, and numbers in each.
    fn sides(&self) -> (usize, usize);
    /// Some components of one vector.
    fn components(&self, row: usize, columns: Range<usize>) -> impl Iterator<Item = f32>;
}

impl<S: Data<Elem = f32>> RowVectors for ArrayBase<S, Ix2>
where
    Self: Sync,
{
    fn sides(&self) -> (usize, usize) {
        self.dim()
    }

    fn components(&self, row: usize, columns: Range<usize>) -> impl Iterator<Item = f32> {
        self.row(row).slice_move(s![columns]).into_iter().copied()
    }
}

impl RowVectors for StoredArray<f32> {
    fn sides(&self) -> (usize, usize) {
        match *self.shape() {
            [rows, columns] => (rows, columns),
            _ => (0, 0),
        }
    }

    fn components(&self, row: usize, columns: Range<usize>) -> impl Iterator<Item = f32> {
        let from = row * self.sides().1;
        self.numbers(from + columns.start..from + columns.end)
    }
}

/// Φ [rows, rows] of row vectors.
pub fn dot_products(vectors: &impl RowVectors) -> Array2<f64> {
    let (count, length) = vectors.sides();
    let mut tiles = lower_tiles(count);
    for from in (0..length).step_by(PANEL) {
        let panel = widened(vectors, from..(from + PANEL).min(length));
        tiles.par_iter_mut().for_each(|tile| {
            let [rows, columns] = [tile.row, tile.column].map(|from| part(&panel, from));
            let target = tile.products.view_mut();
            multiply(rows, columns.reversed_axes(), target, Target::Add);
        });
    }
    let mut products = Array2::zeros((count, count));
    tiles
        .iter()
        .for_each(|tile| tile.write(products.view_mut()));
    products
}

/// Some rows times some rows.
struct Tile {
    row: usize,
    column: usize,
    products: Array2<f64>,
}

/// The tiles on the diagonal and left of it.
fn lower_tiles(count: usize) -> Vec<Tile> {
    let starts = || (0..count).step_by(TILE);
    let side = |from: usize| TILE.min(count - from);
    let tile = |row, column| Tile {
        row,
        column,
        products: Array2::zeros((side(row), side(column))),
    };
    let of_row = |row| starts().take_while(move |&column| column <= row);
    starts()
        .flat_map(|row| of_row(row).map(move |column| tile(row, column)))
        .collect()
}

fn part(panel: &Array2<f64>, from: usize) -> ArrayView2<'_, f64> {
    panel.slice(s![from..(from + TILE).min(panel.nrows()), ..])
}

/// Components of all vectors.
fn widened(vectors: &impl RowVectors, columns: Range<usize>) -> Array2<f64> {
    let mut wide = Array2::zeros((vectors.sides().0, columns.len()));
    wide.axis_iter_mut(Axis(0))
        .into_par_iter()
        .enumerate()
        .for_each(|(row, mut wide)| {
            let numbers = vectors.components(row, columns.clone());
            wide.iter_mut()
                .zip(numbers)
                .for_each(|(w, v)| *w = f64::from(v));
        });
    wide
}

impl Tile {
    /// Writes the tile and its mirror image.
    fn write(&self, mut matrix: ArrayViewMut2<'_, f64>) {
        for ((row, column), &product) in self.products.indexed_iter() {
            let at = [self.row + row, self.column + column];
            if at[1] <= at[0] {
                matrix[at] = product;
                matrix[[at[1], at[0]]] = product;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn products_are_exact_in_f64() {
        let vectors =
            Array2::from_shape_fn((300, 5000), |(r, c)| ((r * 31 + c * 17) % 101) as f32 / 7.0);
        let exact = vectors.mapv(f64::from);
        let exact = exact.dot(&exact.t());
        for (a, b) in dot_products(&vectors).iter().zip(&exact) {
            assert!((a - b).abs() <= 1e-12 * b.abs());
        }
        let products = dot_products(&vectors);
        assert_eq!(products, products.t());
    }
}
