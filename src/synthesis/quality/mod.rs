//! How good a finished map is, as DESIGN's section "What good looks like" defines it: coherence and
//! drift of its texture coordinates along edges, energy of its neighbourhoods, and the texton
//! histogram. Read them together: a collapsed map has low energy, a drifting one high coherence.

pub mod agreement;
pub mod coherence;
pub mod energy;
pub mod histogram;

use serde::Serialize;

use crate::error::Result;
use crate::grid::TexCoord;
use crate::progress::Progress;
use crate::sites::level::{SiteEdge, Sites};
use crate::synthesis::inputs::Inputs;

/// The figures of one map.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Quality {
    /// Share of edges whose texture offset is within half a texel of their own (max norm).
    pub coherence_half: f64,
    /// The same within a texel.
    pub coherence_one: f64,
    /// The 2×2 matrix (rows s, t) that best maps edge offsets to texture offsets.
    pub drift: [[f64; 2]; 2],
    /// Edges in all.
    pub edges: usize,
    /// Mean edge length, in texels.
    pub mean_edge: f64,
    /// Mean neighbourhood distance over that of a random map.
    pub energy: f64,
    /// Mean neighbourhood distance over that of the best whole texel at each site.
    pub energy_ratio_full: f64,
    /// Sites the two energies were measured at.
    pub energy_sites: usize,
    /// Distance of the texton histograms, surface by area against sample; `None` for plain images.
    pub histogram_chi2: Option<f64>,
}

/// Measures a map: `coords` per site of level 0, `edges` among the sites.
pub fn measure<const N: usize, S: Sites<N>>(
    inputs: Inputs<'_, S>,
    coords: &[TexCoord],
    edges: &[SiteEdge],
    seed: u64,
    progress: Progress<'_>,
) -> Result<Quality> {
    progress.begin("quality figures", 0);
    let grid = inputs.space.levels[0].grid;
    progress.check()?;
    let (coherence, energies) = rayon::join(
        || coherence::Coherence::measure(grid, coords, edges),
        || energy::measure(inputs, coords, seed, progress),
    );
    let energies = energies?;
    progress.end();
    Ok(Quality {
        coherence_half: coherence.half,
        coherence_one: coherence.one,
        drift: coherence.drift,
        edges: edges.len(),
        mean_edge: coherence.mean_edge,
        energy: energies.over_random(),
        energy_ratio_full: energies.over_best(),
        energy_sites: energies.sites.len(),
        histogram_chi2: histogram::chi2(inputs.space, coords, inputs.sites.levels[0].areas()),
    })
}
