//! Many long rows in memory that goes back to the system block by block.
//!
//! In: how many rows, how long. Out: their columns, to be filled, and then the rows, block by
//! block. Who writes them to a file and drops each block after it needs the memory of the rows
//! once, not once more for the file's pages. Large pages make that true: the system gives them to
//! the file as they come back, where small ones gather elsewhere (`docs/performance/texton.md`).

use std::io;
use std::ops::Range;

use memmap2::MmapMut;
use ndarray::{ArrayViewMut2, s};

use crate::matrix::as_rows_mut;

/// Bytes of a block, about.
const BLOCK: usize = 64 << 20;

/// A matrix in blocks of rows.
#[derive(Debug)]
pub struct RowBlocks {
    rows: usize,
    length: usize,
    blocks: Vec<RowBlock>,
}

/// Some rows.
#[derive(Debug)]
pub struct RowBlock {
    rows: usize,
    length: usize,
    memory: MmapMut,
}

impl RowBlocks {
    /// Zeros, none of them in memory before it is written.
    pub fn zeros(rows: usize, length: usize) -> io::Result<Self> {
        let of_block = BLOCK.div_ceil(length.max(1) * size_of::<f32>());
        let starts = (0..rows).step_by(of_block);
        let block = |start: usize| RowBlock::zeros(of_block.min(rows - start), length);
        Ok(Self {
            rows,
            length,
            blocks: starts.map(block).collect::<io::Result<_>>()?,
        })
    }

    /// How many rows, and numbers in each.
    pub fn sides(&self) -> [usize; 2] {
        [self.rows, self.length]
    }

    /// Some columns of every block.
    pub fn columns_mut(&mut self, range: Range<usize>) -> Vec<ArrayViewMut2<'_, f32>> {
        let blocks = self.blocks.iter_mut();
        blocks
            .map(|block| block.view_mut().slice_move(s![.., range.clone()]))
            .collect()
    }

    /// The blocks, to be dropped one by one.
    pub fn into_blocks(self) -> impl Iterator<Item = RowBlock> {
        self.blocks.into_iter()
    }
}

impl RowBlock {
    fn zeros(rows: usize, length: usize) -> io::Result<Self> {
        let bytes = rows * length * size_of::<f32>();
        let memory = MmapMut::map_anon(bytes.max(1))?;
        #[cfg(target_os = "linux")]
        // A wish: a kernel without large pages refuses it, and small ones hold the same numbers.
        let _ = memory.advise(memmap2::Advice::HugePage);
        Ok(Self {
            rows,
            length,
            memory,
        })
    }

    fn view_mut(&mut self) -> ArrayViewMut2<'_, f32> {
        let bytes = self.rows * self.length * size_of::<f32>();
        let numbers = bytemuck::cast_slice_mut(&mut self.memory[..bytes]);
        as_rows_mut(numbers, self.rows, self.length)
    }
}

impl AsRef<[f32]> for RowBlock {
    /// The rows, one after another.
    fn as_ref(&self) -> &[f32] {
        bytemuck::cast_slice(&self.memory[..self.rows * self.length * size_of::<f32>()])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_hold_all_rows_in_order() {
        let long = BLOCK / size_of::<f32>() / 2 + 1;
        let mut rows = RowBlocks::zeros(5, long).unwrap();
        assert_eq!(rows.sides(), [5, long]);
        let mut next = 0.0;
        for mut block in rows.columns_mut(3..4) {
            for number in &mut block {
                *number = next;
                next += 1.0;
            }
        }
        let mut found = Vec::new();
        for block in rows.into_blocks() {
            let rows = block.as_ref().chunks(long);
            found.extend(rows.map(|row| (block.as_ref().len() / long, row[2], row[3])));
        }
        assert_eq!(
            found,
            [
                (2, 0.0, 0.0),
                (2, 0.0, 1.0),
                (2, 0.0, 2.0),
                (2, 0.0, 3.0),
                (1, 0.0, 4.0)
            ]
        );
    }

    #[test]
    fn a_matrix_may_be_empty() {
        let rows = RowBlocks::zeros(2, 0).unwrap();
        assert_eq!(
            rows.into_blocks()
                .map(|block| block.as_ref().len())
                .sum::<usize>(),
            0
        );
    }
}
