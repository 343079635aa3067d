//! A pyramid level of the analysis: its texel grid, and the filter bank on it.

use std::ops::Range;

use ndarray::Array3;

use crate::grid::TexelGrid;
use crate::texton::fft_filters::FftFilters;

/// A texel grid and the filters on it.
pub struct FilteredLevel<'a> {
    /// The texels.
    pub grid: TexelGrid,
    /// The filters' taps, [48, 49, 49], the same at every level.
    pub bank: &'a Array3<f64>,
    /// The filters on planes of the grid.
    pub filters: FftFilters,
}

impl<'a> FilteredLevel<'a> {
    /// The filters of `bank` on a grid.
    pub fn new(grid: TexelGrid, bank: &'a Array3<f64>) -> Self {
        Self {
            grid,
            bank,
            filters: FftFilters::new(grid, bank),
        }
    }

    /// Components of appearance vectors that planes give, the first of them plane number `first`.
    pub fn components(&self, first: usize, planes: &[f32]) -> Range<usize> {
        let (count, filters) = (planes.len() / self.grid.len(), self.filters.count());
        first * filters..(first + count) * filters
    }
}
