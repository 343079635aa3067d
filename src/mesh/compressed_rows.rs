//! Lists of different length for every row, in one flat array: built in parallel over fixed blocks
//! of rows, so that the result does not depend on the number of threads.

use rayon::prelude::*;

/// Rows a block; each block is filled by one thread with one state.
const BLOCK: usize = 2048;

/// Compressed rows: row i is `entries[starts[i]..starts[i + 1]]`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Rows<T> {
    /// Where each row begins; one more entry than rows.
    pub starts: Vec<u32>,
    /// The rows, one after the other.
    pub entries: Vec<T>,
}

impl<T: Copy + Send + Sync> Rows<T> {
    /// Fills `count` rows; `fill` appends row i to the list it is given, using a state that
    /// `prepare` makes once a block.
    pub fn collect<S>(
        count: usize,
        prepare: impl Fn() -> S + Sync,
        fill: impl Fn(&mut S, usize, &mut Vec<T>) + Sync,
    ) -> Self {
        let blocks: Vec<(Vec<u32>, Vec<T>)> = (0..count.div_ceil(BLOCK))
            .into_par_iter()
            .map(|block| {
                let mut state = prepare();
                let (mut ends, mut entries) = (Vec::with_capacity(BLOCK), Vec::new());
                for row in block * BLOCK..((block + 1) * BLOCK).min(count) {
                    fill(&mut state, row, &mut entries);
                    ends.push(entries.len() as u32);
                }
                (ends, entries)
            })
            .collect();
        let mut rows = Self {
            starts: Vec::with_capacity(count + 1),
            entries: Vec::with_capacity(blocks.iter().map(|(_, entries)| entries.len()).sum()),
        };
        rows.starts.push(0);
        for (ends, entries) in blocks {
            let base = rows.entries.len() as u32;
            rows.starts.extend(ends.iter().map(|end| base + end));
            rows.entries.extend_from_slice(&entries);
        }
        rows
    }

    /// One row.
    #[inline]
    pub fn row(&self, row: usize) -> &[T] {
        &self.entries[self.range(row)]
    }

    /// Where a row stands among the entries.
    #[inline]
    pub fn range(&self, row: usize) -> std::ops::Range<usize> {
        self.starts[row] as usize..self.starts[row + 1] as usize
    }

    /// Rows in all.
    pub fn len(&self) -> usize {
        self.starts.len().saturating_sub(1)
    }

    /// Whether there is no row.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_keep_their_order_across_blocks() {
        let rows = Rows::collect(
            5000,
            || (),
            |(), row, out| out.extend((0..row % 3).map(|k| row + k)),
        );
        assert_eq!(rows.len(), 5000);
        for row in 0..5000 {
            let expected: Vec<_> = (0..row % 3).map(|k| row + k).collect();
            assert_eq!(rows.row(row), expected);
        }
    }
}
