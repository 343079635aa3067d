//! How much memory synthesis takes, before any work is done.
//!
//! Figures are of the lists that dominate, measured on exemplars of 64 × 64 to 256 × 256 texels and grids
//! of 256 × 256 to 1024 × 1024 sites: at most 1.5 times the peak of the process, and not below it. What a
//! mesh takes is for [`sites::vertices::memory`](crate::sites::vertices::memory) to say.

use crate::exemplar::neighbor_table::NeighborTable;
use crate::exemplar::space::{Features, Space};

/// Bytes of a texel beside its neighbours and its vector: windows, projections, bounds.
const TEXEL: u64 = 280;
/// Bytes of a neighbour in the table: read, laid out, and as the metric has it.
const NEIGHBOR: u64 = 24;
/// Bytes of a number of Φ: read, in double precision, factored.
const DOT_PRODUCT: u64 = 24;
/// Bytes of a site of a flat grid: its mesh, its coordinates on all levels, quality figures.
const GRID_SITE: u64 = 260;
/// The program, and working memory of its threads.
const PROGRAM: u64 = 16 << 20;

/// Bytes that the exemplar takes while it is synthesized from.
pub fn exemplar_bytes(space: &Space, table: &NeighborTable) -> u64 {
    let level = |level: &crate::exemplar::space::SpaceLevel| {
        let numbers = match &level.features {
            Features::Textons { gram, .. } => DOT_PRODUCT * gram.len() as u64,
            Features::Vectors(vectors) => 8 * vectors.len() as u64,
        };
        level.grid.len() as u64 * (TEXEL + NEIGHBOR * table.k as u64) + numbers
    };
    space.levels.iter().map(level).sum::<u64>() + PROGRAM
}

/// Bytes that a flat grid of so many sites takes while it is synthesized on.
pub fn grid_bytes(width: u32, height: u32) -> u64 {
    GRID_SITE * u64::from(width) * u64::from(height)
}
