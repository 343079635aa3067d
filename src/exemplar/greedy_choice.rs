//! Choosing neighbours greedily by (distance, flat index), each a least separation from all taken.
//!
//! In: distances of some texels to all texels. Out: their neighbours, nearest first, themselves in
//! column 0.

use std::ops::Range;

use ndarray::{Array2, ArrayViewMut1, ArrayViewMut2, Axis};
use rayon::prelude::*;

use crate::grid::TexelGrid;
use crate::index::TexelIndex;

/// Texels whose least distance is kept together.
const BLOCK: usize = 64;

/// Chooses the neighbours of `texels`, whose distances are the rows of `distances` (destroyed).
/// Only `whole` texels are listed as others' neighbours. Fails with the number found when a texel
/// has fewer neighbours than there are columns.
pub fn choose_neighbors(
    distances: &mut Array2<f32>,
    grid: TexelGrid,
    texels: Range<usize>,
    whole: &[bool],
    separation: u32,
    mut neighbors: ArrayViewMut2<'_, u32>,
    mut chosen_distances: ArrayViewMut2<'_, f32>,
) -> Result<(), usize> {
    distances
        .axis_iter_mut(Axis(0))
        .into_par_iter()
        .zip(neighbors.axis_iter_mut(Axis(0)))
        .zip(chosen_distances.axis_iter_mut(Axis(0)))
        .zip(texels)
        .map(|(((mut row, neighbors), chosen), texel)| {
            let Some(row) = row.as_slice_mut() else {
                return Ok(());
            };
            let own = row[texel];
            let barred = row.iter_mut().zip(whole).filter(|(_, whole)| !**whole);
            barred.for_each(|(distance, _)| *distance = f32::INFINITY);
            let mut field = Field::new(row, grid, separation);
            field.take(texel, own, neighbors, chosen)
        })
        // The first failure by texel, whatever the threads do.
        .collect::<Vec<_>>()
        .into_iter()
        .collect()
}

/// The distances from one texel, with those out of the question at infinity.
struct Field<'a> {
    distances: &'a mut [f32],
    /// The least distance of each block.
    minima: Vec<f32>,
    grid: TexelGrid,
    separation: i32,
}

impl<'a> Field<'a> {
    fn new(distances: &'a mut [f32], grid: TexelGrid, separation: u32) -> Self {
        let minima = distances.chunks(BLOCK).map(least).collect();
        Self {
            distances,
            minima,
            grid,
            separation: separation.max(1) as i32,
        }
    }

    /// Fills one texel's rows; fails with the number of neighbours found.
    fn take(
        &mut self,
        texel: usize,
        own: f32,
        mut neighbors: ArrayViewMut1<'_, u32>,
        mut chosen: ArrayViewMut1<'_, f32>,
    ) -> Result<(), usize> {
        (neighbors[0], chosen[0]) = (texel as u32, own);
        self.bar_around(texel);
        for at in 1..neighbors.len() {
            let (distance, nearest) = self.nearest().ok_or(at)?;
            (neighbors[at], chosen[at]) = (nearest as u32, distance);
            self.bar_around(nearest);
        }
        Ok(())
    }

    /// The nearest texel still in question; of equals the smaller index.
    fn nearest(&self) -> Option<(f32, usize)> {
        let distance = least(&self.minima);
        if distance == f32::INFINITY {
            return None;
        }
        let block = self.minima.iter().position(|&d| d == distance)?;
        let from = block * BLOCK;
        let to = (from + BLOCK).min(self.distances.len());
        let place = self.distances[from..to]
            .iter()
            .position(|&d| d == distance)?;
        Some((distance, from + place))
    }

    /// Puts everything closer than the separation out of the question.
    fn bar_around(&mut self, texel: usize) {
        let centre = TexelIndex(texel as u32);
        let reach = self.separation - 1;
        for drow in -reach..=reach {
            for dcol in -reach..=reach {
                if let Some(near) = self.grid.offset(centre, drow, dcol) {
                    self.bar(near.index());
                }
            }
        }
    }

    fn bar(&mut self, texel: usize) {
        let block = texel / BLOCK;
        let was_least = self.distances[texel] == self.minima[block];
        self.distances[texel] = f32::INFINITY;
        if was_least {
            let to = ((block + 1) * BLOCK).min(self.distances.len());
            self.minima[block] = least(&self.distances[block * BLOCK..to]);
        }
    }
}

fn least(values: &[f32]) -> f32 {
    values
        .iter()
        .fold(f32::INFINITY, |least, &v| if v < least { v } else { least })
}
