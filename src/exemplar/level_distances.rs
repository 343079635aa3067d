//! Neighbourhood distances of a level: its own window and its parent level's.
//!
//! In: two levels of a space. Out: squared neighbourhood distances, of strips or of single pairs.

use std::ops::Range;

use ndarray::{Array2, Axis};
use rayon::prelude::*;

use crate::exemplar::space::SpaceLevel;
use crate::exemplar::window_distance::WindowDistances;
use crate::grid::TexelGrid;
use crate::index::TexelIndex;

/// Both windows of a level.
pub struct LevelDistances {
    grid: TexelGrid,
    fine: WindowDistances,
    coarse: Option<WindowDistances>,
}

impl LevelDistances {
    /// Windows of odd widths on a level and on its parent level, if it has one.
    pub fn new(
        level: &SpaceLevel,
        coarser: Option<&SpaceLevel>,
        fine_width: u32,
        coarse_width: u32,
    ) -> Self {
        Self {
            grid: level.grid,
            fine: WindowDistances::new(level, fine_width),
            coarse: coarser.map(|coarser| WindowDistances::new(coarser, coarse_width)),
        }
    }

    /// The level's grid.
    pub fn grid(&self) -> TexelGrid {
        self.grid
    }

    /// Distances of the texels in `rows` to all texels, [texels of rows, texels].
    pub fn strip(&self, rows: Range<usize>) -> Array2<f32> {
        let mut strip = self.fine.strip(rows.clone());
        if let Some(coarse) = &self.coarse {
            let parents = rows.start / 2..rows.end.div_ceil(2);
            let coarse = coarse.strip(parents.clone());
            self.add_parents(&mut strip, &coarse, rows.start, parents.start);
        }
        strip
    }

    /// Distance of two texels.
    pub fn between(&self, a: TexelIndex, b: TexelIndex) -> f32 {
        let fine = self.fine.between(a, b);
        let Some(coarse) = &self.coarse else {
            return fine;
        };
        fine + coarse.between(self.grid.parent(a), self.grid.parent(b))
    }

    /// Adds to every pair of texels the distance of their parents.
    fn add_parents(
        &self,
        strip: &mut Array2<f32>,
        coarse: &Array2<f32>,
        first: usize,
        first_parent: usize,
    ) {
        let width = self.grid.width as usize;
        let parent_width = width.div_ceil(2);
        strip
            .axis_iter_mut(Axis(0))
            .into_par_iter()
            .enumerate()
            .for_each(|(at, mut row)| {
                let (texel_row, col) = (first + at / width, at % width);
                let parent = (texel_row / 2 - first_parent) * parent_width + col / 2;
                let (Some(parents), Some(row)) =
                    (coarse.row(parent).to_slice(), row.as_slice_mut())
                else {
                    return;
                };
                for (texel_row, row) in row.chunks_mut(width).enumerate() {
                    let parents = &parents[texel_row / 2 * parent_width..][..parent_width];
                    for (pair, &distance) in row.chunks_mut(2).zip(parents) {
                        pair.iter_mut().for_each(|d| *d += distance);
                    }
                }
            });
    }
}
