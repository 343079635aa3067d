//! How good a finished map is (docs/synthesis.md, Quality): coherence and drift of its texture coordinates
//! along edges, energy of its neighbourhoods, and the texton histogram. Read them together: a map that uses few texels
//! has low energy, one that drifts has high coherence.

pub(crate) mod agreement;
mod coherence;
pub(crate) mod energy;
pub(crate) mod figures;
mod fragments;
pub(crate) mod histogram;

use serde::Serialize;

use crate::error::Result;
use crate::exemplar::space::Space;
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
    /// Neighbourhood distances, where the target has square windows to measure them in.
    #[serde(flatten)]
    pub energies: Option<MeanEnergies>,
    /// Distance of the texton histograms, surface by area against sample; `None` for plain images.
    pub histogram_chi2: Option<f64>,
    /// Whether the elements of the texture stay whole, where the exemplar has a mask.
    #[serde(flatten)]
    pub fragments: Option<fragments::Fragments>,
}

/// The mean neighbourhood distance of a map, over others.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct MeanEnergies {
    /// Over that of a random map.
    pub energy: f64,
    /// Over that of the best whole texel at each site.
    pub energy_ratio_full: f64,
    /// Sites that both were measured at.
    pub energy_sites: usize,
}

/// Measures what needs no neighbourhoods: `areas` are those of the sites.
pub fn measure_edges(
    space: &Space,
    coords: &[TexCoord],
    edges: &[SiteEdge],
    areas: &[f32],
) -> Quality {
    let coherence = coherence::Coherence::measure(space.levels[0].grid, coords, edges);
    Quality {
        coherence_half: coherence.half,
        coherence_one: coherence.one,
        drift: coherence.drift,
        edges: edges.len(),
        mean_edge: coherence.mean_edge,
        energies: None,
        histogram_chi2: histogram::chi2(space, coords, areas),
        fragments: fragments::measure(space, coords, edges, areas),
    }
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
    progress.check()?;
    let areas = inputs.sites.levels[0].areas();
    let (quality, energies) = rayon::join(
        || measure_edges(inputs.space, coords, edges, areas),
        || energy::measure(inputs, coords, seed, progress),
    );
    let energies = energies?;
    progress.end();
    Ok(Quality {
        energies: Some(MeanEnergies {
            energy: energies.over_random(),
            energy_ratio_full: energies.over_best(),
            energy_sites: energies.sites.len(),
        }),
        ..quality
    })
}
