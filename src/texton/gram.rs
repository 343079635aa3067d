//! Dot products of textons, the Gram matrix Φ of Tong 2002 §4, from their appearance vectors.
//!
//! In: rows of `f32`, which may stay in their file. Out: all products in `f64`, taken panel by panel
//! of components in `f64`, so that they are exact to the inputs' rounding.

use std::ops::Range;

use ndarray::{Array2, ArrayBase, ArrayView2, ArrayViewMut2, Data, Ix2, s};
use rayon::prelude::*;

use crate::error::Result;
use crate::format::stored_array::StoredArray;
use crate::matrix::{Update, as_rows, multiply};
use crate::texton::transpose::transpose;

/// Vectors in a strip, which is a side of the tiles of Φ: a multiple of the kernels' 32.
const STRIP: usize = 64;
/// Components converted to `f64` at once.
const PANEL: usize = 2048;

/// Row vectors that dot products are wanted of, in memory or in a file.
pub trait RowVectors: Sync {
    /// How many vectors, and numbers in each.
    fn sides(&self) -> (usize, usize);
    /// Adds some components of one vector to `numbers`.
    fn components(&self, row: usize, columns: Range<usize>, numbers: &mut Vec<f32>) -> Result<()>;
}

impl<S: Data<Elem = f32>> RowVectors for ArrayBase<S, Ix2>
where
    Self: Sync,
{
    fn sides(&self) -> (usize, usize) {
        self.dim()
    }

    fn components(&self, row: usize, columns: Range<usize>, numbers: &mut Vec<f32>) -> Result<()> {
        numbers.extend(self.row(row).slice_move(s![columns]));
        Ok(())
    }
}

impl RowVectors for StoredArray<f32> {
    fn sides(&self) -> (usize, usize) {
        match *self.shape() {
            [rows, columns] => (rows, columns),
            _ => (0, 0),
        }
    }

    fn components(&self, row: usize, columns: Range<usize>, numbers: &mut Vec<f32>) -> Result<()> {
        let held = numbers.len();
        numbers.resize(held + columns.len(), 0.0);
        self.read(row * self.sides().1 + columns.start, &mut numbers[held..])
    }
}

/// Φ [rows, rows] of row vectors.
pub fn gram_matrix(vectors: &impl RowVectors) -> Result<Array2<f64>> {
    let (count, length) = vectors.sides();
    let mut strips: Vec<Strip> = (0..count)
        .step_by(STRIP)
        .map(|start| Strip::new(start..(start + STRIP).min(count)))
        .collect();
    let mut tiles = lower_tiles(&strips);
    for from in (0..length).step_by(PANEL) {
        let panel = from..(from + PANEL).min(length);
        strips
            .par_iter_mut()
            .try_for_each(|strip| strip.take(vectors, panel.clone()))?;
        tiles.par_iter_mut().for_each(|tile| {
            let [rows, columns] = [tile.row, tile.column].map(|at| strips[at].panel());
            let target = tile.products.view_mut();
            multiply(rows.reversed_axes(), columns, target, Update::Add);
        });
    }
    let mut products = Array2::zeros((count, count));
    for tile in &tiles {
        let corner = [tile.row, tile.column].map(|at| strips[at].rows.start);
        tile.write(corner, products.view_mut());
    }
    Ok(products)
}

/// Some vectors, and a panel of their components.
struct Strip {
    rows: Range<usize>,
    numbers: Vec<f32>,
    wide: Vec<f64>,
}

impl Strip {
    fn new(rows: Range<usize>) -> Self {
        Self {
            rows,
            numbers: Vec::new(),
            wide: Vec::new(),
        }
    }

    fn take(&mut self, vectors: &impl RowVectors, panel: Range<usize>) -> Result<()> {
        self.numbers.clear();
        for row in self.rows.clone() {
            vectors.components(row, panel.clone(), &mut self.numbers)?;
        }
        let (width, components) = (self.rows.len(), panel.len());
        self.wide.resize(components * width, 0.0);
        transpose(&self.numbers, components, &mut self.wide, width, f64::from);
        Ok(())
    }

    /// [components, vectors]: what the kernels read together lies together.
    fn panel(&self) -> ArrayView2<'_, f64> {
        as_rows(
            &self.wide,
            self.wide.len() / self.rows.len(),
            self.rows.len(),
        )
    }
}

/// One strip times another.
struct Tile {
    row: usize,
    column: usize,
    products: Array2<f64>,
}

/// The tiles on the diagonal and left of it.
fn lower_tiles(strips: &[Strip]) -> Vec<Tile> {
    let side = |at: usize| strips[at].rows.len();
    let tile = |row, column| Tile {
        row,
        column,
        products: Array2::zeros((side(row), side(column))),
    };
    (0..strips.len())
        .flat_map(|row| (0..=row).map(move |column| tile(row, column)))
        .collect()
}

impl Tile {
    /// Writes the tile and its mirror image.
    fn write(&self, corner: [usize; 2], mut matrix: ArrayViewMut2<'_, f64>) {
        for ((row, column), &product) in self.products.indexed_iter() {
            let at = [corner[0] + row, corner[1] + column];
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
        for (a, b) in gram_matrix(&vectors).unwrap().iter().zip(&exact) {
            assert!((a - b).abs() <= 1e-12 * b.abs());
        }
        let products = gram_matrix(&vectors).unwrap();
        assert_eq!(products, products.t());
    }
}
