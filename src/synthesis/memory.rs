//! How much memory synthesis takes, before any work is done.
//!
//! Figures are of the lists that dominate, measured on exemplars of 64 × 64 to 256 × 256 texels and grids
//! of 256 × 256 to 1024 × 1024 sites: at most 1.5 times the peak of the process, and not below it. What a
//! mesh takes is for [`sites::vertices::memory`](crate::sites::vertices::memory) to say.

use crate::exemplar::neighbor_table::NeighborTable;
use crate::exemplar::space::{Features, Space, SpaceLevel};
use crate::synthesis::options::SynthesisOptions;

/// Bytes of a texel beside its neighbours and its vector: windows, projections, bounds.
const TEXEL: u64 = 360;
/// Bytes of a neighbour in the table: read, laid out, and as the metric has it.
const NEIGHBOR: u64 = 24;
/// Bytes of a number of Φ: read, in double precision, factored.
const DOT_PRODUCT: u64 = 24;
/// Bytes of a site of a flat grid: its mesh, its coordinates on all levels, quality figures.
const GRID_SITE: u64 = 260;
/// The program, and working memory of its threads.
const PROGRAM: u64 = 16 << 20;

/// Bytes that the exemplar, and what the method has beside it, take while so many sites are synthesized.
pub fn exemplar_bytes(
    (space, table): (&Space, &NeighborTable),
    sites: u64,
    options: &SynthesisOptions,
) -> u64 {
    let level = |level: &SpaceLevel| {
        let numbers = match &level.features {
            Features::Textons { gram, .. } => DOT_PRODUCT * gram.len() as u64,
            Features::Plain(vectors) => 8 * vectors.len() as u64,
        };
        level.grid.len() as u64 * (TEXEL + NEIGHBOR * table.k as u64) + numbers
    };
    let levels = space.levels.iter();
    let of_method = (options.method.description().bytes)(space, sites, options);
    levels.map(level).sum::<u64>() + of_method + PROGRAM
}

/// Bytes that a flat grid of this many sites takes while it is synthesized on.
pub fn grid_bytes(width: u32, height: u32) -> u64 {
    GRID_SITE * u64::from(width) * u64::from(height)
}
