//! How evenly a map uses the exemplar: cells of texels, each with as many sites as its share of whole texels.
//!
//! Seams alone are cheapest in the smoothest part of the exemplar, and a map would soon use nothing else. The cost of
//! reuse is w · Σ (h − e)² / 2e over cells that hold h sites and should hold e: one site more in a cell used
//! twice as often as it should costs about w.

use std::collections::BTreeMap;

use crate::exemplar::level::ExemplarLevel;
use crate::grid::{TexCoord, TexelGrid};
use crate::index::TexelIndex;

/// Sites that a cell should hold at least.
const FEWEST_SITES: f64 = 16.0;
/// What a site more costs in a cell that holds twice as many as it should, seams by chance costing 1 per site.
const WEIGHT: f64 = 0.4;

/// How many sites each cell holds.
#[derive(Clone, Debug)]
pub struct ReuseCost {
    grid: TexelGrid,
    /// Texels along a cell's side, and cells along a row.
    side: u32,
    columns: u32,
    expected: Vec<f64>,
    held: Vec<f64>,
}

impl ReuseCost {
    /// What the sites hold.
    pub fn of(exemplar: &ExemplarLevel<'_>, coords: &[TexCoord]) -> Self {
        let grid = exemplar.grid;
        let per_texel = coords.len() as f64 / exemplar.whole_texels.len().max(1) as f64;
        let longest = grid.width.max(grid.height);
        let fits = |side: &u32| f64::from(side * side) * per_texel >= FEWEST_SITES;
        let side = (1..longest).find(fits).unwrap_or(longest);
        let (columns, rows) = (grid.width.div_ceil(side), grid.height.div_ceil(side));
        let cells = (columns * rows) as usize;
        let mut reuse = Self {
            grid,
            side,
            columns,
            expected: vec![0.0; cells],
            held: vec![0.0; cells],
        };
        for &texel in &exemplar.whole_texels {
            let cell = reuse.cell(TexelIndex(texel));
            reuse.expected[cell] += per_texel;
        }
        for &at in coords {
            let cell = reuse.cell_at(at);
            reuse.held[cell] += 1.0;
        }
        reuse
    }

    /// The cell of a coordinate.
    pub fn cell_at(&self, at: TexCoord) -> usize {
        self.cell(self.grid.texel_nearest(at))
    }

    fn cell(&self, texel: TexelIndex) -> usize {
        let (row, col) = self.grid.row_col(texel);
        (row / self.side * self.columns + col / self.side) as usize
    }

    /// What one site more costs in a cell.
    pub fn price(&self, cell: usize) -> f64 {
        WEIGHT * (self.held[cell] / self.expected(cell) - 1.0)
    }

    /// What it costs that so many sites more, or fewer, are in some cells.
    pub fn cost_of(&self, changes: &BTreeMap<usize, f64>) -> f64 {
        let of_cell = |(&cell, &more): (&usize, &f64)| {
            let expected = self.expected(cell);
            WEIGHT * more * (2.0 * (self.held[cell] - expected) + more) / (2.0 * expected)
        };
        changes.iter().map(of_cell).sum()
    }

    /// So many sites more, or fewer, are in some cells.
    pub fn change(&mut self, changes: &BTreeMap<usize, f64>) {
        for (&cell, &more) in changes {
            self.held[cell] += more;
        }
    }

    /// What all cells cost.
    pub fn total(&self) -> f64 {
        let cells = 0..self.held.len();
        let of_cell = |cell| (self.held[cell] - self.expected(cell)).powi(2) / self.expected(cell);
        WEIGHT / 2.0 * cells.map(of_cell).sum::<f64>()
    }

    /// Cells without whole texels hold hardly anything, and should not.
    fn expected(&self, cell: usize) -> f64 {
        self.expected[cell].max(1.0)
    }
}
