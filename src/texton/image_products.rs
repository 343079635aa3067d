//! Ĉ of several levels: the dot products of all images' coefficients, from which come those of the texels.
//!
//! In: planes of images, block after block, or stored sums of blocks. Out: a sum per level. A block is summed
//! by itself and then added to those before it, so that the result does not depend on who summed it.

use crate::error::Result;
use crate::format::stored_array::StoredArray;
use crate::grid::TexelGrid;
use crate::matrix::as_rows;
use crate::progress::Progress;
use crate::texton::filter_eigenbasis::FilterEigenbasis;
use crate::texton::scatter_matrix::ScatterMatrix;

/// The sums of some levels.
pub struct ImageProducts {
    levels: Vec<LevelProducts>,
}

/// The sum of one level.
pub struct LevelProducts {
    basis: FilterEigenbasis,
    side: usize,
    /// Of the blocks that are done.
    total: Option<ScatterMatrix>,
    /// Of the block under way.
    block: Option<ScatterMatrix>,
}

impl ImageProducts {
    /// Nothing added yet, on these texel grids.
    pub fn new(grids: &[TexelGrid]) -> Self {
        let level = |&grid: &TexelGrid| LevelProducts {
            basis: FilterEigenbasis::new(grid),
            side: grid.len(),
            total: None,
            block: None,
        };
        Self {
            levels: grids.iter().map(level).collect(),
        }
    }

    /// Adds planes of every level, one after another, to the block under way.
    pub fn add(&mut self, planes: &[Vec<f32>], progress: Progress<'_>) {
        for (level, planes) in self.levels.iter_mut().zip(planes) {
            let coefficients = level.basis.coefficients(planes);
            let rows = as_rows(&coefficients, coefficients.len() / level.side, level.side);
            let side = level.side;
            let block = level.block.get_or_insert_with(|| ScatterMatrix::new(side));
            block.add(rows, progress);
        }
    }

    /// Adds planes of every level that are a whole block.
    pub fn add_block(&mut self, planes: &[Vec<f32>], progress: Progress<'_>) {
        for (level, planes) in self.levels.iter_mut().zip(planes) {
            let coefficients = level.basis.coefficients(planes);
            let rows = as_rows(&coefficients, coefficients.len() / level.side, level.side);
            match &mut level.total {
                Some(total) => total.add_sum_of(rows, progress),
                total => {
                    let mut first = ScatterMatrix::new(level.side);
                    first.add(rows, progress);
                    *total = Some(first);
                }
            }
        }
    }

    /// Ends a block: its sums are added to those of the blocks before.
    pub fn end_block(&mut self) {
        for level in &mut self.levels {
            match (&mut level.total, &mut level.block) {
                (Some(total), Some(block)) => {
                    total.add_all(block);
                    block.clear();
                }
                (total, block) => *total = block.take(),
            }
        }
    }

    /// The sums of the block under way, finest level first.
    pub fn block(&self) -> impl Iterator<Item = &ScatterMatrix> {
        self.levels.iter().filter_map(|level| level.block.as_ref())
    }

    /// Forgets the block under way.
    pub fn clear_block(&mut self) {
        let blocks = self.levels.iter_mut();
        blocks
            .filter_map(|level| level.block.as_mut())
            .for_each(ScatterMatrix::clear);
    }

    /// How many numbers the sums of one block take on every level, as they are stored.
    pub fn stored_lengths(grids: &[TexelGrid]) -> Vec<usize> {
        let lengths = grids.iter();
        lengths
            .map(|grid| ScatterMatrix::stored_length(grid.len()))
            .collect()
    }

    /// Adds the stored sums of a block to those of the blocks before.
    pub fn add_stored(&mut self, level: usize, block: &StoredArray<f32>) -> Result<()> {
        let LevelProducts { side, total, .. } = &mut self.levels[level];
        match total {
            Some(total) => total.add_stored(block),
            None => {
                *total = Some(ScatterMatrix::read(*side, block)?);
                Ok(())
            }
        }
    }

    /// The levels, finest first.
    pub fn into_levels(mut self) -> Vec<LevelProducts> {
        self.levels.iter_mut().for_each(|level| level.block = None);
        self.levels
    }
}

impl LevelProducts {
    /// The basis of the coefficients, and their dot products.
    pub fn into_total(self) -> (FilterEigenbasis, ScatterMatrix) {
        let total = self.total.unwrap_or_else(|| ScatterMatrix::new(self.side));
        (self.basis, total)
    }
}
