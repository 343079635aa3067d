//! Neighbourhood distances of a level: its own window and its parent level's.
//!
//! In: two levels of a space. Out: squared neighbourhood distances, of blocks of texels to all, or of
//! single pairs, summed in the same order.

use std::sync::{Mutex, MutexGuard, PoisonError};

use macro_rules_attribute::apply;

use crate::exemplar::aligned_buffer::AlignedNumbers;
use crate::exemplar::space::SpaceLevel;
use crate::exemplar::texel_block::TexelBlock;
use crate::exemplar::window_distance::{WindowBuffers, WindowDistances};
use crate::grid::TexelGrid;
use crate::index::TexelIndex;
use crate::lanes::vectorized;

/// Both windows of a level.
pub struct LevelDistances {
    grid: TexelGrid,
    fine: WindowDistances,
    coarse: Option<WindowDistances>,
}

/// Working memory of one thread, and the distances found last.
#[derive(Clone, Debug, Default)]
pub struct BlockDistances {
    windows: WindowBuffers,
    distances: AlignedNumbers,
    of_parents: AlignedNumbers,
    /// Distances of one parent to a row of parents, each as often as it has children in a row.
    repeated: Vec<f32>,
}

/// Working memories that no thread has in use: as many are made as threads work at a time.
#[derive(Debug, Default)]
pub struct SpareDistances(Mutex<Vec<BlockDistances>>);

impl SpareDistances {
    /// Does some work with one of them.
    pub fn with<T>(&self, work: impl FnOnce(&mut BlockDistances) -> T) -> T {
        let mut distances = self.all().pop().unwrap_or_default();
        let done = work(&mut distances);
        self.all().push(distances);
        done
    }

    fn all(&self) -> MutexGuard<'_, Vec<BlockDistances>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
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

    /// The texels of a block, each with its distances to all texels.
    pub fn of_block<'b>(
        &self,
        block: &TexelBlock,
        found: &'b mut BlockDistances,
    ) -> impl Iterator<Item = (TexelIndex, &'b mut [f32])> + use<'b> {
        let BlockDistances {
            windows,
            distances,
            of_parents,
            repeated,
        } = found;
        let distances = self.fine.of_block(block, windows, distances);
        if let Some(coarse) = &self.coarse {
            let parents = block.parents();
            let of_parents = coarse.of_block(&parents, windows, of_parents);
            self.add_parents(block, (&parents, of_parents), repeated, distances);
        }
        let rows = distances.chunks_exact_mut(self.grid.len());
        block.texels(self.grid).zip(rows)
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
        block: &TexelBlock,
        (parents, of_parents): (&TexelBlock, &[f32]),
        repeated: &mut Vec<f32>,
        sums: &mut [f32],
    ) {
        let (grid, coarser) = (self.grid, self.grid.coarser());
        let (width, parent_width) = (grid.width as usize, coarser.width as usize);
        repeated.resize(2 * parent_width, 0.0);
        let of_parents = of_parents.chunks_exact(coarser.len());
        for (parent, distances) in parents.texels(coarser).zip(of_parents) {
            for (row, distances) in distances.chunks_exact(parent_width).enumerate() {
                repeat_each(distances, repeated);
                for place in grid
                    .children(parent)
                    .filter_map(|child| block.place(grid, child))
                {
                    let own = &mut sums[place * grid.len()..][..grid.len()];
                    for row in own.chunks_exact_mut(width).skip(2 * row).take(2) {
                        add(row, repeated);
                    }
                }
            }
        }
    }
}

/// Every number twice.
fn repeat_each(numbers: &[f32], twice: &mut [f32]) {
    for (pair, &number) in twice.as_chunks_mut::<2>().0.iter_mut().zip(numbers) {
        *pair = [number; 2];
    }
}

#[apply(vectorized!)]
fn add(sums: &mut [f32], numbers: &[f32]) {
    sums.iter_mut().zip(numbers).for_each(|(sum, n)| *sum += n);
}
