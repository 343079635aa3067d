//! The distance of two neighbourhoods, a site's and a texel's: Σ wₚ ‖s(p) − t(p)‖² over the samples
//! of both windows that count (Tong 2002 §5.1), not divided by their number.

use crate::synthesis::candidates::Candidate;
use crate::synthesis::choice::{Pick, smallest};
use crate::synthesis::site_samples::SiteNeighborhood;

/// A way to compare neighbourhoods on one level.
pub trait Metric: Sync {
    /// What a site's neighbourhood holds, in the metric's own terms; reused from site to site.
    type Pattern: Default + Send;

    /// Reads what a site's neighbourhood holds.
    fn read(&self, site: &SiteNeighborhood<'_>, pattern: &mut Self::Pattern);

    /// The distance to a texel's neighbourhood, or infinity once it is known to exceed `limit`.
    fn distance(&self, pattern: &Self::Pattern, texel: u32, limit: f64) -> f64;

    /// The best of some candidates.
    fn best(&self, pattern: &Self::Pattern, candidates: &[Candidate]) -> Option<Pick> {
        smallest(candidates, |texel, limit| {
            self.distance(pattern, texel, limit)
        })
    }

    /// The best of all whole texels; `coherent` are those whose distances do not count
    /// `coherence` times.
    fn best_of_all(
        &self,
        pattern: &mut Self::Pattern,
        coherent: &[Candidate],
        coherence: f64,
    ) -> Option<Pick>;
}

/// The better of `first` and every texel of a list, whose distances count `factor` times.
#[inline(always)]
pub fn best_of_whole(
    texels: &[u32],
    first: Option<Pick>,
    factor: f64,
    mut distance: impl FnMut(u32, f64) -> f64,
) -> Option<Pick> {
    let mut best = first;
    for &texel in texels {
        let limit = best.map_or(f64::INFINITY, |best| best.score / factor);
        let score = factor * distance(texel, limit);
        let pick = Pick { texel, score };
        if best.is_none_or(|best| pick.beats(&best)) {
            best = Some(pick);
        }
    }
    best
}
