//! Polishing: a discrete optimisation over a finished map, after Kwatra 2003 and Boykov 2001.
//!
//! Neighbourhood search changes one site at a time. Where two copied patches do not line up, or a feature of
//! the sample is missing, no change of a single site is an improvement. Here all sites of a region are offered one
//! copied patch at once: a patch of the region [continued](proposals::Patches::continued) over all of it, or one
//! [placed anew](proposals::laid_anew). A smallest [cut](max_flow) tells which of them take it, so that the seam runs
//! where it costs least. A move is made only if all that it changes costs less in sum.
//!
//! | file | what it does |
//! | --- | --- |
//! | [`links`], [`features`], [`seam_cost`], [`reuse_cost`] | what a map costs |
//! | [`effort`], [`repeats`] | how many rounds, over which regions |
//! | [`region`], [`proposals`] | what a region is offered |
//! | [`max_flow`], [`moves`] | what is taken of it |
//! | [`rounds`] | which regions, in which order, side by side |

mod effort;
mod features;
mod links;
mod max_flow;
mod moves;
mod proposals;
mod region;
mod repeats;
mod reuse_cost;
mod rounds;
mod seam_cost;
#[cfg(test)]
mod tests;

pub use effort::Effort;

use crate::error::Result;
use crate::exemplar::embedding::Embedding;
use crate::exemplar::level::ExemplarLevel;
use crate::grid::TexCoord;
use crate::progress::Progress;
use crate::sites::level::Sites;
use crate::synthesis::polish::features::PlaneFeatures;
use crate::synthesis::polish::links::{Links, MOST_LINKS};
use crate::synthesis::polish::moves::Judge;
use crate::synthesis::polish::reuse_cost::ReuseCost;
use crate::synthesis::polish::rounds::Rounds;
use crate::synthesis::polish::seam_cost::SeamCost;

/// Bytes per site at the most: its links, what they cost, whether it is covered or changed, and four in every
/// thread.
pub const SITE_BYTES: u64 = 12 * MOST_LINKS as u64 + 64;

/// Polishes the coordinates of the sites of level 0, in as many rounds as the effort asks for. Patches are laid at real
/// coordinates; at the end every site holds the centre of its texel. Returns what the map costs per site, before the
/// first round and after each.
pub fn polish<const N: usize, S: Sites<N>>(
    (exemplar, embedding): (&ExemplarLevel<'_>, &Embedding),
    sites: &S,
    coords: &mut [TexCoord],
    (effort, seed): (Effort, u64),
    progress: Progress<'_>,
) -> Result<Vec<f64>> {
    let features = PlaneFeatures::new(exemplar, embedding);
    let links = Links::new(sites, progress)?;
    let judge = Judge {
        exemplar,
        links: &links,
        seams: SeamCost::new(&features, exemplar.grid),
    };
    let reuse = ReuseCost::of(exemplar, coords);
    let mut work = Rounds::new(judge, coords, reuse, seed);
    let mut costs = vec![work.cost()];
    let grid = exemplar.grid;
    for round in 0..effort.rounds(grid.tileable) {
        match effort {
            Effort::Auto => work.round_where_repeated(progress)?,
            Effort::Rounds(_) => work.round(round, progress)?,
        }
        costs.push(work.cost());
    }
    for at in coords {
        *at = grid.centre(grid.texel_nearest(*at));
    }
    Ok(costs)
}
