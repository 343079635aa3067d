//! How much memory synthesis takes, before any work is done.
//!
//! Figures are of the lists that dominate, measured on exemplars of 64 × 64 to 256 × 256 texels and grids
//! of 256 × 256 to 1024 × 1024 sites: at most 1.5 times the peak of the process, and not below it. What a
//! mesh takes is for [`sites::vertices::memory`](crate::sites::vertices::memory) to say.

use crate::exemplar::controls::MASK_LABELS;
use crate::exemplar::neighbor_table::NeighborTable;
use crate::exemplar::space::{Features, Space, SpaceLevel};
use crate::synthesis::options::{Method, SynthesisOptions};
use crate::synthesis::polish;

/// Bytes of a texel beside its neighbours and its vector: windows, projections, bounds.
const TEXEL: u64 = 360;
/// Bytes of a neighbour in the table: read, laid out, and as the metric has it.
const NEIGHBOR: u64 = 24;
/// Bytes of a number of Φ: read, in double precision, factored.
const DOT_PRODUCT: u64 = 24;
/// Bytes of a site of a flat grid: its mesh, its coordinates on all levels, quality figures.
const GRID_SITE: u64 = 260;
/// Bytes of a site that is polished.
const POLISHED_SITE: u64 = polish::SITE_BYTES;
/// The program, and working memory of its threads.
const PROGRAM: u64 = 16 << 20;

/// Bytes that the exemplar takes while it is synthesized from.
pub fn exemplar_bytes(space: &Space, table: &NeighborTable, options: &SynthesisOptions) -> u64 {
    let level = |level: &SpaceLevel| {
        let numbers = match &level.features {
            Features::Textons { gram, .. } => DOT_PRODUCT * gram.len() as u64,
            Features::Vectors(vectors) => 8 * vectors.len() as u64,
        };
        level.grid.len() as u64 * (TEXEL + NEIGHBOR * table.k as u64) + numbers
    };
    let levels = space.levels.iter();
    let windows = match options.method {
        Method::Progressive => levels
            .clone()
            .map(|level| window_bytes(level, options))
            .sum(),
        _ => 0,
    };
    levels.map(level).sum::<u64>() + windows + PROGRAM
}

/// Bytes of the windows of a level that the progressive method resamples: its colours at most twice, for the
/// level itself and for the one below.
fn window_bytes(level: &SpaceLevel, options: &SynthesisOptions) -> u64 {
    let dimensions = match &level.features {
        Features::Textons { gram, .. } => gram.nrows(),
        Features::Vectors(vectors) => vectors.dim().2,
    };
    let samples = |width: u32| u64::from(width).pow(2);
    let asked = &options.progressive;
    let numbers = dimensions as u64 * samples(asked.color_window.widest())
        + u64::from(MASK_LABELS) * samples(asked.widest());
    2 * 4 * level.grid.len() as u64 * numbers
}

/// Bytes that polishing so many sites takes.
pub fn polish_bytes(sites: u64, tileable: bool, options: &SynthesisOptions) -> u64 {
    match options.k_coherence.polish.rounds(tileable) {
        0 => 0,
        _ => POLISHED_SITE * sites,
    }
}

/// Bytes that a flat grid of this many sites takes while it is synthesized on.
pub fn grid_bytes(width: u32, height: u32) -> u64 {
    GRID_SITE * u64::from(width) * u64::from(height)
}
