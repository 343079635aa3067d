//! Neighbours through the parent level (Tong 2002 §5.2, "a two-level pyramid is built"): the m
//! nearest parents of a texel's parent, then the best among their children.
//!
//! In: window distances of a level and of its parent level. Out: rows of the neighbour table. Not
//! exact; how often it finds what exact search finds is measured on some rows of texels.
//! Deviation: parents whose children all lie within the separation of the texel are no candidates,
//! and where m leaves fewer than k neighbours, m doubles.

use ndarray::Array2;
use rayon::prelude::*;

use crate::error::Result;
use crate::exemplar::level_distances::{BlockDistances, LevelDistances, SpareDistances};
use crate::exemplar::neighbor_list::{Near, Row, Rows, assemble};
use crate::exemplar::separated_neighbors::Choice;
use crate::exemplar::texel_block::TexelBlock;
use crate::grid::TexelGrid;
use crate::index::TexelIndex;
use crate::progress::Progress;

/// Rows of texels on which exact search is run too.
const PROBED_ROWS: usize = 4;

/// The search of one level.
pub struct TwoLevelSearch<'a> {
    /// Window distances of the level.
    pub fine: &'a LevelDistances,
    /// Window distances of its parent level.
    pub coarse: &'a LevelDistances,
    /// Exact search's choice.
    pub choice: &'a Choice,
    /// Which texels may be listed.
    pub whole: &'a [bool],
    /// Least distance between listed texels.
    pub separation: u32,
    /// Neighbours a texel, itself included.
    pub k: usize,
    /// Parents considered first.
    pub candidates: usize,
}

impl TwoLevelSearch<'_> {
    /// The neighbours of all texels; fails with the number found where a texel has fewer than k.
    pub fn run(&self, progress: Progress<'_>) -> Result<std::result::Result<Rows, usize>> {
        let spare = SpareDistances::default();
        let of_block = |block: &TexelBlock| {
            progress.check()?;
            let of_parent =
                |(parent, distances): (_, &mut [f32])| self.of_parent(parent, distances);
            let rows = |distances: &mut BlockDistances| {
                let parents = self.coarse.of_block(block, distances);
                parents.flat_map(of_parent).collect()
            };
            Ok(spare.with(rows))
        };
        let found = TexelBlock::of_grid(self.coarse.grid())
            .par_iter()
            .map(of_block)
            .collect::<Result<Vec<Vec<_>>>>()?;
        Ok(assemble(
            self.fine.grid().len(),
            self.k,
            found.into_iter().flatten(),
        ))
    }

    /// Rows of the children of one parent.
    fn of_parent(&self, parent: TexelIndex, distances: &[f32]) -> Vec<(TexelIndex, Row)> {
        let mut order = self.parents_in_question(parent, distances);
        let mut sorted = 0;
        let children = self.fine.grid().children(parent);
        children
            .map(|texel| {
                let mut count = self.candidates;
                loop {
                    sort_first(&mut order, &mut sorted, count);
                    let listed = &order[..count.min(order.len())];
                    let row = self.choose(texel, listed);
                    if row.len() == self.k || count >= order.len() {
                        return (texel, self.choice.completed(row));
                    }
                    count *= 2;
                }
            })
            .collect()
    }

    /// Parents with a child that may be listed, with their distances.
    fn parents_in_question(&self, parent: TexelIndex, distances: &[f32]) -> Vec<Near> {
        // Children of parents c apart are at most 2c + 1 apart.
        let nearest = (i64::from(self.separation) - 1).max(1).div_euclid(2).max(1);
        let grid = self.coarse.grid();
        let far = |other: u32| max_norm(grid, parent, TexelIndex(other)) >= nearest;
        distances
            .iter()
            .zip(0_u32..)
            .filter(|&(_, other)| other == parent.0 || far(other))
            .map(|(&distance, other)| (distance, other))
            .collect()
    }

    /// Greedy choice among the children of some parents; may be short.
    fn choose(&self, texel: TexelIndex, parents: &[Near]) -> Vec<Near> {
        let grid = self.fine.grid();
        let mut open: Vec<Near> = parents
            .iter()
            .flat_map(|&(_, parent)| grid.children(TexelIndex(parent)))
            .filter(|&child| self.whole[child.index()] && self.choice.in_band(texel, child))
            .map(|child| (self.fine.between(texel, child), child.0))
            .collect();
        open.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let mut row = vec![(self.fine.between(texel, texel), texel.0)];
        let least = i64::from(self.separation.max(1));
        for candidate in open {
            if row.len() == self.k {
                break;
            }
            let apart = |&(_, taken): &(f32, u32)| {
                max_norm(grid, TexelIndex(taken), TexelIndex(candidate.1)) >= least
            };
            if row.iter().all(apart) {
                row.push(candidate);
            }
        }
        row
    }

    /// The share of exact search's neighbours (the texel itself left out) that `found` lists, on a
    /// few rows of texels.
    pub fn recall(&self, found: &Array2<u32>) -> f64 {
        let grid = self.fine.grid();
        let height = grid.height as usize;
        let mut distances = BlockDistances::default();
        let (mut hits, mut listed) = (0, 0);
        for probe in 0..PROBED_ROWS.min(height) {
            let row = (2 * probe + 1) * height / (2 * PROBED_ROWS.min(height));
            for block in TexelBlock::of_rows(grid, row..row + 1) {
                for (texel, distances) in self.fine.of_block(&block, &mut distances) {
                    let Ok(exact) = self.choice.choose(texel, distances) else {
                        continue;
                    };
                    let found = found.row(texel.index());
                    let hit = |near: &&Near| found.iter().any(|&other| other == near.1);
                    hits += exact.iter().skip(1).filter(hit).count();
                    listed += self.k - 1;
                }
            }
        }
        if listed == 0 {
            1.0
        } else {
            hits as f64 / listed as f64
        }
    }
}

/// Sorts the `count` nearest to the front, keeping what is sorted already.
fn sort_first(order: &mut [Near], sorted: &mut usize, count: usize) {
    let count = count.min(order.len());
    if count <= *sorted {
        return;
    }
    let nearer = |a: &Near, b: &Near| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1));
    let rest = &mut order[*sorted..];
    let wanted = count - *sorted;
    if wanted < rest.len() {
        rest.select_nth_unstable_by(wanted - 1, nearer);
    }
    rest[..wanted].sort_unstable_by(nearer);
    *sorted = count;
}

/// Distance of two texels in the max norm, wrapped when tileable.
fn max_norm(grid: TexelGrid, a: TexelIndex, b: TexelIndex) -> i64 {
    let ((row_a, col_a), (row_b, col_b)) = (grid.row_col(a), grid.row_col(b));
    let along = |a: u32, b: u32, side: u32| {
        let distance = a.abs_diff(b);
        i64::from(if grid.tileable {
            distance.min(side - distance)
        } else {
            distance
        })
    };
    along(row_a, row_b, grid.height).max(along(col_a, col_b, grid.width))
}
