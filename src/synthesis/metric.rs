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
