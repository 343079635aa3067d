//! Neighbours through the parent level (Tong 2002 §5.2, "a two-level pyramid is built"): the m
//! nearest parents of a texel's parent, then the best among their children.
//!
//! In: window distances of a level and of its parent level. Out: rows of the neighbour table. Not
//! exact; how often it finds what exact search finds is measured on some rows of texels.
//! Deviation: parents whose children all lie within the separation of the texel are no candidates,
//! and where m leaves fewer than k neighbours, m doubles.

use ndarray::{Array2, ArrayView1, Axis, s};
use rayon::prelude::*;

use crate::error::Result;
use crate::exemplar::greedy_choice::choose_neighbors;
use crate::exemplar::level_distances::LevelDistances;
use crate::grid::TexelGrid;
use crate::index::TexelIndex;
use crate::progress::Progress;

/// Rows of texels on which exact search is run too.
const PROBED_ROWS: usize = 4;
/// Rows of parents whose distances are held at once.
const STRIP: usize = 4;

/// The search of one level.
pub struct TwoLevelSearch<'a> {
    /// Window distances of the level.
    pub fine: &'a LevelDistances,
    /// Window distances of its parent level.
    pub coarse: &'a LevelDistances,
    /// Which texels may be listed.
    pub whole: &'a [bool],
    /// Least distance between listed texels.
    pub separation: u32,
    /// Neighbours a texel, itself included.
    pub k: usize,
    /// Parents considered first.
    pub candidates: usize,
}

/// A texel's neighbours, or how few there are.
type Row = std::result::Result<Vec<(f32, u32)>, usize>;

/// A level's neighbours and their distances.
pub type Rows = (Array2<u32>, Array2<f32>);

/// A child texel with its row (distance, flat index), or how many were found where too few.
type ChildRow = (TexelIndex, std::result::Result<Vec<(f32, u32)>, usize>);

impl TwoLevelSearch<'_> {
    /// The neighbours of all texels; fails with the number found where a texel has fewer than k.
    pub fn run(&self, progress: Progress<'_>) -> Result<std::result::Result<Rows, usize>> {
        let (grid, parents) = (self.fine.grid(), self.coarse.grid());
        let mut neighbors = Array2::zeros((grid.len(), self.k));
        let mut distances = Array2::zeros((grid.len(), self.k));
        for first in (0..parents.height as usize).step_by(STRIP) {
            let rows = first..(first + STRIP).min(parents.height as usize);
            let strip = self.coarse.strip(rows.clone());
            let found: Vec<_> = strip
                .outer_iter()
                .into_par_iter()
                .enumerate()
                .flat_map_iter(|(at, distances)| {
                    let parent = TexelIndex((rows.start * parents.width as usize + at) as u32);
                    self.of_parent(parent, distances)
                })
                .collect();
            for (texel, row) in found {
                let Ok(row) = row else {
                    return Ok(Err(row.err().unwrap_or(0)));
                };
                for (column, (distance, neighbor)) in row.into_iter().enumerate() {
                    neighbors[[texel.index(), column]] = neighbor;
                    distances[[texel.index(), column]] = distance;
                }
            }
            progress.advance(rows.len() as u64)?;
        }
        Ok(Ok((neighbors, distances)))
    }

    /// Rows of the children of one parent.
    fn of_parent(&self, parent: TexelIndex, distances: ArrayView1<'_, f32>) -> Vec<ChildRow> {
        let mut order = self.parents_in_question(parent, distances);
        let mut sorted = 0;
        children(self.fine.grid(), parent)
            .into_iter()
            .map(|texel| {
                let mut count = self.candidates;
                loop {
                    sort_first(&mut order, &mut sorted, count);
                    let listed = &order[..count.min(order.len())];
                    let row = self.choose(texel, listed);
                    if row.is_ok() || count >= order.len() {
                        return (texel, row);
                    }
                    count *= 2;
                }
            })
            .collect()
    }

    /// Parents with a child that may be listed, with their distances.
    fn parents_in_question(
        &self,
        parent: TexelIndex,
        distances: ArrayView1<'_, f32>,
    ) -> Vec<(f32, u32)> {
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

    /// Greedy choice among the children of some parents.
    fn choose(&self, texel: TexelIndex, parents: &[(f32, u32)]) -> Row {
        let grid = self.fine.grid();
        let mut open: Vec<(f32, u32)> = parents
            .iter()
            .flat_map(|&(_, parent)| children(grid, TexelIndex(parent)))
            .filter(|child| self.whole[child.index()])
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
        if row.len() == self.k {
            Ok(row)
        } else {
            Err(row.len())
        }
    }

    /// The share of exact search's neighbours (the texel itself left out) that `found` lists, on a
    /// few rows of texels.
    pub fn recall(&self, found: &Array2<u32>) -> f64 {
        let grid = self.fine.grid();
        let (height, width) = (grid.height as usize, grid.width as usize);
        let (mut hits, mut listed) = (0, 0);
        for probe in 0..PROBED_ROWS.min(height) {
            let row = (2 * probe + 1) * height / (2 * PROBED_ROWS.min(height));
            let texels = row * width..(row + 1) * width;
            let mut strip = self.fine.strip(row..row + 1);
            let mut exact = Array2::zeros((width, self.k));
            let mut distances = Array2::zeros((width, self.k));
            let chosen = choose_neighbors(
                &mut strip,
                grid,
                texels.clone(),
                self.whole,
                self.separation,
                exact.view_mut(),
                distances.view_mut(),
            );
            if chosen.is_err() {
                continue;
            }
            let found = found.slice(s![texels, ..]);
            for (exact, found) in exact.axis_iter(Axis(0)).zip(found.axis_iter(Axis(0))) {
                let hit = |neighbor: &&u32| found.iter().any(|other| other == *neighbor);
                hits += exact.iter().skip(1).filter(hit).count();
                listed += self.k - 1;
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
fn sort_first(order: &mut [(f32, u32)], sorted: &mut usize, count: usize) {
    let count = count.min(order.len());
    if count <= *sorted {
        return;
    }
    let nearer = |a: &(f32, u32), b: &(f32, u32)| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1));
    let rest = &mut order[*sorted..];
    let wanted = count - *sorted;
    if wanted < rest.len() {
        rest.select_nth_unstable_by(wanted - 1, nearer);
    }
    rest[..wanted].sort_unstable_by(nearer);
    *sorted = count;
}

/// The texels whose parent this is.
fn children(grid: TexelGrid, parent: TexelIndex) -> Vec<TexelIndex> {
    let (row, col) = grid.coarser().row_col(parent);
    let rows = 2 * row..(2 * row + 2).min(grid.height);
    let of_row = |row| {
        let cols = 2 * col..(2 * col + 2).min(grid.width);
        cols.map(move |col| grid.texel(row, col))
    };
    rows.flat_map(of_row).collect()
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
