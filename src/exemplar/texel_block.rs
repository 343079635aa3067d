//! Rectangles of texels: what the search of the neighbour table does at a time, so that their distances to all texels
//! stay in the cache.

use std::ops::Range;

use crate::grid::TexelGrid;
use crate::index::TexelIndex;

/// Rows and columns of a block; even, so that blocks of children have whole blocks of parents.
const ROWS: usize = 8;
const COLS: usize = 16;

/// Texels of some rows and columns.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TexelBlock {
    /// Rows of the grid.
    pub rows: Range<usize>,
    /// Columns of the grid.
    pub cols: Range<usize>,
}

impl TexelBlock {
    /// Blocks that hold every texel of a grid once.
    pub fn of_grid(grid: TexelGrid) -> Vec<Self> {
        Self::of_rows(grid, 0..grid.height as usize)
    }

    /// Blocks that hold every texel of some rows once.
    pub fn of_rows(grid: TexelGrid, rows: Range<usize>) -> Vec<Self> {
        let (bottom, right) = (rows.end, grid.width as usize);
        let of_row = |row: usize| {
            (0..right).step_by(COLS).map(move |col| Self {
                rows: row..(row + ROWS).min(bottom),
                cols: col..(col + COLS).min(right),
            })
        };
        rows.step_by(ROWS).flat_map(of_row).collect()
    }

    /// The parents of the block's texels.
    #[must_use]
    pub fn parents(&self) -> Self {
        let halved = |range: &Range<usize>| range.start / 2..range.end.div_ceil(2);
        Self {
            rows: halved(&self.rows),
            cols: halved(&self.cols),
        }
    }

    /// How many texels it holds.
    pub fn len(&self) -> usize {
        self.rows.len() * self.cols.len()
    }

    /// Which of its texels a texel is, if any.
    pub fn place(&self, grid: TexelGrid, texel: TexelIndex) -> Option<usize> {
        let (row, col) = grid.row_col(texel);
        let (row, col) = (row as usize, col as usize);
        let inside = self.rows.contains(&row) && self.cols.contains(&col);
        inside.then(|| (row - self.rows.start) * self.cols.len() + col - self.cols.start)
    }

    /// Its texels, row by row.
    pub fn texels(&self, grid: TexelGrid) -> impl Iterator<Item = TexelIndex> + use<> {
        let (rows, cols) = (self.rows.clone(), self.cols.clone());
        rows.flat_map(move |row| {
            let texel = move |col| grid.texel(row as u32, col as u32);
            cols.clone().map(texel)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_hold_every_texel_once() {
        let grid = TexelGrid {
            width: 37,
            height: 19,
            tileable: false,
        };
        let blocks = TexelBlock::of_grid(grid);
        let mut texels: Vec<u32> = blocks
            .iter()
            .flat_map(|block| block.texels(grid))
            .map(|texel| texel.0)
            .collect();
        assert_eq!(
            texels.len(),
            blocks.iter().map(TexelBlock::len).sum::<usize>()
        );
        texels.sort_unstable();
        assert!(texels.into_iter().eq(0..grid.len() as u32));
        for block in blocks {
            let parents: Vec<_> = block.parents().texels(grid.coarser()).collect();
            let places = block.texels(grid).map(|texel| block.place(grid, texel));
            assert!(places.eq((0..block.len()).map(Some)));
            let mut texels = block.texels(grid);
            assert!(texels.all(|texel| parents.contains(&grid.parent(texel))));
        }
    }
}
