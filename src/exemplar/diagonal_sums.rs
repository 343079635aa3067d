//! Sums of the distances of two rows of places along a moving window, many columns at once.
//!
//! In: what stands at the places of two rows. Out: for some columns x of one and all columns x′ of the
//! other Σ_o d(x + o, x′ + o).
//!
//! Lanes hold *shifts*: lane c beside column x stands for column x + c, so that a window moves along a
//! diagonal within its lane. Column numbers wrap, those of the border included; sums are stored at the columns
//! they are for.

use std::iter::Take;
use std::slice::ChunksMut;

use macro_rules_attribute::apply;
use ndarray::Array2;

use crate::lanes::{LANES, LaneBlock, vectorized};

/// The part of two rows that is summed along x.
#[derive(Clone, Copy)]
pub struct WindowRow {
    /// The first column.
    pub first: usize,
    /// How many columns.
    pub columns: usize,
    /// The window's width.
    pub window: usize,
    /// Columns after which the other row begins again.
    pub period: usize,
}

/// Sums along x of the distances of labelled places.
#[apply(vectorized!)]
pub fn label_sums(
    along: WindowRow,
    table: &Array2<f32>,
    from: &[u32],
    to: &[u32],
    sums: &mut [f32],
) {
    let (features, table) = (table.ncols(), table.as_slice().unwrap_or_default());
    let pair = LabelRows {
        features,
        table,
        from,
        to,
    };
    along.add(pair, sums);
}

/// Sums along x of the squared distances of vectors.
#[apply(vectorized!)]
pub fn vector_sums(along: WindowRow, depth: usize, from: &[f32], to: &[f32], sums: &mut [f32]) {
    let pair = VectorRows {
        depth,
        from,
        side: to.len() / depth,
        to,
    };
    along.add(pair, sums);
}

/// Two rows of the bordered grid.
trait RowPair {
    /// Distances of a place of one row to those of the other that lie some shifts behind, lane by lane.
    fn distances(&self, place: usize, shift: usize) -> LaneBlock;
}

struct LabelRows<'a> {
    features: usize,
    table: &'a [f32],
    from: &'a [u32],
    to: &'a [u32],
}

impl RowPair for LabelRows<'_> {
    #[inline(always)]
    fn distances(&self, place: usize, shift: usize) -> LaneBlock {
        let row = &self.table[self.from[place] as usize * self.features..][..self.features];
        let others = &self.to[place + shift..][..LANES];
        let mut distances = [0.0; LANES];
        for lane in 0..LANES {
            distances[lane] = row[others[lane] as usize];
        }
        distances
    }
}

struct VectorRows<'a> {
    depth: usize,
    from: &'a [f32],
    /// Numbers that follow each other in `to` before those of the next dimension.
    side: usize,
    to: &'a [f32],
}

impl RowPair for VectorRows<'_> {
    #[inline(always)]
    fn distances(&self, place: usize, shift: usize) -> LaneBlock {
        let own = &self.from[place * self.depth..][..self.depth];
        let mut distances = [0.0; LANES];
        let mut begin = place + shift;
        for own in own {
            let others = &self.to[begin..][..LANES];
            for lane in 0..LANES {
                let apart = own - others[lane];
                distances[lane] += apart * apart;
            }
            begin += self.side;
        }
        distances
    }
}

impl WindowRow {
    /// Turns, rounded up to whole lanes.
    pub fn shifts(self) -> usize {
        self.period.next_multiple_of(LANES)
    }

    /// Numbers from one column's sums to the next column's; they begin with a block of lanes that is
    /// not used.
    pub fn step(self) -> usize {
        self.shifts() + LANES
    }

    /// Numbers of all columns' sums, and the block of lanes behind them that is not used.
    pub fn size(self) -> usize {
        self.columns * self.step() + LANES
    }

    /// Σ_o d(x + o, x′ + o), o below the window's width, for all columns x and x′.
    #[inline(always)]
    fn add(self, rows: impl RowPair, sums: &mut [f32]) {
        match self.window {
            3 => self.add_at_hand::<3>(rows, sums),
            5 => self.add_at_hand::<5>(rows, sums),
            7 => self.add_at_hand::<7>(rows, sums),
            _ => self.add_any(rows, sums),
        }
    }

    /// The window's distances stay in registers.
    #[inline(always)]
    fn add_at_hand<const WINDOW: usize>(self, rows: impl RowPair, sums: &mut [f32]) {
        for shift in (0..self.shifts()).step_by(LANES) {
            let mut latest = [[0.0; LANES]; WINDOW];
            for at in 0..self.columns + WINDOW - 1 {
                for newer in 1..WINDOW {
                    latest[newer - 1] = latest[newer];
                }
                latest[WINDOW - 1] = rows.distances(self.first + at, shift);
                if at + 1 >= WINDOW {
                    let mut sum = latest[0];
                    for term in &latest[1..] {
                        add_lanes(&mut sum, term);
                    }
                    self.store(sums, at + 1 - WINDOW, shift, sum);
                }
            }
        }
    }

    #[inline(always)]
    fn add_any(self, rows: impl RowPair, sums: &mut [f32]) {
        let mut found = vec![[0.0; LANES]; self.columns + self.window - 1];
        for shift in (0..self.shifts()).step_by(LANES) {
            for (at, found) in found.iter_mut().enumerate() {
                *found = rows.distances(self.first + at, shift);
            }
            for (column, window) in found.windows(self.window).enumerate() {
                let mut sum = [0.0; LANES];
                window.iter().for_each(|term| add_lanes(&mut sum, term));
                self.store(sums, column, shift, sum);
            }
        }
    }

    /// Puts down the sums of a column at the columns they are for; twice where they go round.
    #[inline(always)]
    fn store(self, sums: &mut [f32], column: usize, shift: usize, sum: LaneBlock) {
        let begin = column * self.step() + LANES;
        let mut other = self.first + column + shift;
        if other >= self.period {
            other -= self.period;
        }
        sums[begin + other..][..LANES].copy_from_slice(&sum);
        if other + LANES > self.period {
            sums[begin + other - self.period..][..LANES].copy_from_slice(&sum);
        }
    }
}

#[inline(always)]
fn add_lanes(sum: &mut LaneBlock, term: &LaneBlock) {
    for lane in 0..LANES {
        sum[lane] += term[lane];
    }
}

/// Adds the sums of pairs of rows that follow each other, as many as a window has. A target each column
/// begins with the distances to `width` columns.
#[apply(vectorized!)]
pub fn add_rows(along: WindowRow, rows: &[f32], targets: Take<ChunksMut<'_, f32>>, width: usize) {
    for (column, target) in targets.enumerate() {
        let begin = column * along.step() + LANES;
        let (whole, rest) = target[..width].as_chunks_mut::<LANES>();
        for (block, target) in whole.iter_mut().enumerate() {
            *target = sum_of_rows(along, rows, begin + block * LANES);
        }
        if !rest.is_empty() {
            let last = sum_of_rows(along, rows, begin + whole.len() * LANES);
            rest.copy_from_slice(&last[..rest.len()]);
        }
    }
}

#[inline(always)]
fn sum_of_rows(along: WindowRow, rows: &[f32], begin: usize) -> LaneBlock {
    let mut total = [0.0; LANES];
    for row in 0..along.window {
        let sums = &rows[row * along.size() + begin..][..LANES];
        for lane in 0..LANES {
            total[lane] += sums[lane];
        }
    }
    total
}
