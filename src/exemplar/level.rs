//! One level of the exemplar as the engine reads it: feature rows, windows, whole texels, and the
//! neighbour lists.
//!
//! A *feature row* is an index into a level's feature vectors: the texton label where the exemplar
//! has textons, the texel itself where it has a feature vector per texel. One more row, the last, is that of the
//! default texton.

use crate::exemplar::neighbor_table::NeighborTable;
use crate::exemplar::space::{Features, Space, SpaceLevel};
use crate::exemplar::windows::Windows;
use crate::grid::TexelGrid;
use crate::index::TexelIndex;
use crate::neighborhood::Neighborhood;

/// A level's texels, their windows and their neighbours.
#[derive(Clone, Debug)]
pub struct ExemplarLevel<'a> {
    /// The level's texels.
    pub grid: TexelGrid,
    /// The feature row of each texel.
    pub rows: Vec<u32>,
    /// Which texels may be picked.
    pub whole: Vec<bool>,
    /// The texels that may be picked, ascending.
    pub whole_texels: Vec<u32>,
    /// The windows on this level.
    pub fine: Windows,
    /// The windows on the parent level, where synthesis uses one.
    pub coarse: Option<CoarseWindows>,
    /// The neighbourhood's offsets and weights.
    pub neighborhood: &'a Neighborhood,
    /// The neighbour lists, `listed` texels each, of which `k` are used.
    neighbors: &'a [u32],
    listed: usize,
    k: usize,
}

/// The windows round the parents of a level's texels.
#[derive(Clone, Debug)]
pub struct CoarseWindows {
    /// Windows of the parent level's texels.
    pub windows: Windows,
    /// The parent of each texel.
    pub parents: Vec<u32>,
}

impl<'a> ExemplarLevel<'a> {
    /// Level `level` of an exemplar, of whose table `k` neighbours per texel are used; with windows on
    /// the parent level if `two_level`.
    ///
    /// Space and table must have passed [`check`](crate::synthesis::check).
    pub fn new(
        space: &Space,
        table: &'a NeighborTable,
        level: usize,
        k: usize,
        two_level: bool,
    ) -> Self {
        let listed = &table.levels[level];
        let neighborhood = &listed.neighborhood;
        let whole = table.whole_texels(level, space.levels[level].grid);
        Self {
            neighbors: listed.neighbors.as_slice().unwrap_or_default(),
            listed: table.k,
            k,
            ..Self::of_windows(space, level, neighborhood, whole, two_level)
        }
    }

    /// Level `level` of an exemplar with square windows that need not be a table's, and without neighbour
    /// lists; `whole` says which texels may be picked.
    pub fn of_windows(
        space: &Space,
        level: usize,
        neighborhood: &'a Neighborhood,
        whole: Vec<bool>,
        two_level: bool,
    ) -> Self {
        Self {
            coarse: two_level.then(|| CoarseWindows::new(space, level, neighborhood)),
            ..Self::without_table(&space.levels[level], whole, neighborhood)
        }
    }

    /// A level without neighbour lists and parent level, for methods with neighbourhoods of their own; `whole` says
    /// which texels may be picked, `neighborhood` is empty where no square windows are compared.
    pub fn without_table(
        level: &SpaceLevel,
        whole: Vec<bool>,
        neighborhood: &'a Neighborhood,
    ) -> Self {
        let rows = feature_rows(level);
        Self {
            grid: level.grid,
            fine: Windows::new(level.grid, &rows, default_row(level), &neighborhood.offsets),
            whole_texels: (0..level.grid.len() as u32)
                .filter(|&texel| whole[texel as usize])
                .collect(),
            rows,
            whole,
            coarse: None,
            neighborhood,
            neighbors: &[],
            listed: 0,
            k: 0,
        }
    }

    /// The nearest texels of a texel, itself first.
    #[inline]
    pub fn nearest(&self, texel: u32) -> &[u32] {
        &self.neighbors[texel as usize * self.listed..][..self.k]
    }
}

impl CoarseWindows {
    fn new(space: &Space, level: usize, neighborhood: &Neighborhood) -> Self {
        let (at, coarser) = (&space.levels[level], &space.levels[level + 1]);
        Self {
            windows: Windows::new(
                coarser.grid,
                &feature_rows(coarser),
                default_row(coarser),
                &neighborhood.coarse_offsets,
            ),
            parents: (0..at.grid.len() as u32)
                .map(|texel| at.grid.parent(TexelIndex(texel)).0)
                .collect(),
        }
    }
}

/// The feature row of every texel of a level.
pub fn feature_rows(level: &SpaceLevel) -> Vec<u32> {
    match &level.features {
        Features::Textons { labels, .. } => labels.iter().map(|&label| u32::from(label)).collect(),
        Features::Plain(_) => (0..level.grid.len() as u32).collect(),
    }
}

/// The feature row of a level's default: one past all others.
pub fn default_row(level: &SpaceLevel) -> u32 {
    match &level.features {
        Features::Textons { gram, .. } => gram.nrows() as u32 - 1,
        Features::Plain(_) => level.grid.len() as u32,
    }
}
