//! The distance of two neighbourhoods, a site's and a texel's: Σ wₚ ‖s(p) − t(p)‖² over the samples
//! of both windows that count (Tong 2002 §5.1), not divided by their number.

mod bound_tree;
pub(crate) mod dense;
pub(crate) mod embedded;
pub(crate) mod feature_metric;
mod fine_bounds;
pub(crate) mod gram;
mod lower_bounds;
pub(crate) mod of_level;
mod projection;
pub(crate) mod site_values;
mod window_metric;

use crate::sites::level::Sites;
use crate::synthesis::candidates::forward::Candidate;
use crate::synthesis::keep::{Best, Keep, Pick, Preference, smallest};
use crate::synthesis::metric::site_values::SiteNeighborhood;

/// A way to compare neighbourhoods on one level.
pub trait Metric: Sync {
    /// What a site's neighbourhood holds, in the metric's own terms; reused from site to site.
    type Pattern: Default + Send;

    /// Reads what a site's neighbourhood holds.
    fn read<const N: usize, S: Sites<N>>(
        &self,
        site: &SiteNeighborhood<'_, S>,
        pattern: &mut Self::Pattern,
    );

    /// The distance to a texel's neighbourhood, or infinity once it is known to exceed `limit`.
    fn distance(&self, pattern: &Self::Pattern, texel: u32, limit: f64) -> f64;

    /// The best of `first` and some candidates, with `floor` added to all distances.
    fn best(
        &self,
        pattern: &Self::Pattern,
        candidates: &[Candidate],
        first: Option<Pick>,
        floor: f64,
    ) -> Option<Pick> {
        smallest(candidates, first, floor, |texel, limit| {
            self.distance(pattern, texel, limit)
        })
    }

    /// Compares all whole texels, as far as what they are kept by makes it necessary.
    fn search(&self, pattern: &mut Self::Pattern, keep: &mut impl Keep);

    /// The best of all whole texels; `coherent` are those that are preferred.
    fn best_of_all(
        &self,
        pattern: &mut Self::Pattern,
        coherent: &[Candidate],
        preference: Preference,
    ) -> Option<Pick> {
        let pick = self.best(pattern, coherent, None, preference.floor);
        let mut keep = Best { pick, preference };
        self.search(pattern, &mut keep);
        keep.pick
    }
}
