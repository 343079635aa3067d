//! Searches that the metrics of whole windows share, compiled for the processors that they run on.
//!
//! Each function is compiled once per kind of processor, with the metric's distance inside its loop. What differs
//! between the metrics is how a distance is summed ([`WindowMetric::distance_inline`]) and how a site is read.

use macro_rules_attribute::apply;

use crate::lanes::vectorized;
use crate::sites::level::Sites;
use crate::synthesis::candidates::forward::Candidate;
use crate::synthesis::keep::{Keep, Pick, smallest};
use crate::synthesis::metric::Metric;
use crate::synthesis::metric::lower_bounds::{
    MANY, ProjectedWindows, search_within, smallest_within,
};
use crate::synthesis::metric::site_values::SiteNeighborhood;

/// A metric that sums the differences of a pattern and a texel's windows, number by number.
pub trait WindowMetric: Sync {
    /// What a site's neighbourhood holds.
    type Pattern: Default + Send;

    /// Whether lower bounds are asked before candidates are compared, too, and not only in full searches.
    const BOUNDS_CANDIDATES: bool;

    /// The distance, or infinity once it exceeds `limit`. To be inlined, so that every loop has a copy of its own.
    fn distance_inline(&self, pattern: &Self::Pattern, texel: u32, limit: f32) -> f32;

    /// All numbers of a pattern, those of the finer window first.
    fn parts(pattern: &Self::Pattern) -> [&[f32]; 2];

    /// The texels that a search may find, ascending.
    fn whole_texels(&self) -> &[u32];

    /// Lower bounds of the distances to a pattern, where they are prepared and hold for it.
    fn bounds(&self, pattern: &Self::Pattern) -> Option<&ProjectedWindows>;

    /// Reads what a site's neighbourhood holds.
    fn read_windows<const N: usize, S: Sites<N>>(
        &self,
        site: &SiteNeighborhood<'_, S>,
        pattern: &mut Self::Pattern,
    );
}

impl<W: WindowMetric> Metric for W {
    type Pattern = W::Pattern;

    fn read<const N: usize, S: Sites<N>>(
        &self,
        site: &SiteNeighborhood<'_, S>,
        pattern: &mut W::Pattern,
    ) {
        self.read_windows(site, pattern);
    }

    fn distance(&self, pattern: &W::Pattern, texel: u32, limit: f64) -> f64 {
        f64::from(distance(self, pattern, texel, limit as f32))
    }

    fn best(
        &self,
        pattern: &W::Pattern,
        candidates: &[Candidate],
        first: Option<Pick>,
        floor: f64,
    ) -> Option<Pick> {
        let asks = W::BOUNDS_CANDIDATES && first.is_some() && candidates.len() >= MANY;
        match self.bounds(pattern) {
            Some(windows) if asks => best_bounded(self, windows, pattern, candidates, first, floor),
            _ => best_candidate(self, pattern, candidates, first, floor),
        }
    }

    fn search(&self, pattern: &mut W::Pattern, keep: &mut impl Keep) {
        match self.bounds(pattern) {
            Some(windows) => search_bounded(self, windows, pattern, keep),
            None => search_all(self, pattern, keep),
        }
    }
}

#[apply(vectorized!)]
fn distance<M: WindowMetric>(metric: &M, pattern: &M::Pattern, texel: u32, limit: f32) -> f32 {
    metric.distance_inline(pattern, texel, limit)
}

/// The best of `first` and some candidates, with `floor` added to all distances.
#[apply(vectorized!)]
fn best_candidate<M: WindowMetric>(
    metric: &M,
    pattern: &M::Pattern,
    candidates: &[Candidate],
    first: Option<Pick>,
    floor: f64,
) -> Option<Pick> {
    smallest(candidates, first, floor, |texel, limit| {
        f64::from(metric.distance_inline(pattern, texel, limit as f32))
    })
}

/// As [`best_candidate`], skipping those whose lower bound is above the best so far.
#[apply(vectorized!)]
fn best_bounded<M: WindowMetric>(
    metric: &M,
    windows: &ProjectedWindows,
    pattern: &M::Pattern,
    candidates: &[Candidate],
    first: Option<Pick>,
    floor: f64,
) -> Option<Pick> {
    let parts = M::parts(pattern);
    smallest_within(windows, parts, candidates, first, floor, |texel, limit| {
        f64::from(metric.distance_inline(pattern, texel, limit as f32))
    })
}

/// Compares every whole texel.
#[apply(vectorized!)]
fn search_all<M: WindowMetric, K: Keep>(metric: &M, pattern: &M::Pattern, keep: &mut K) {
    for &texel in metric.whole_texels() {
        let distance = metric.distance_inline(pattern, texel, keep.limit() as f32);
        keep.offer(texel, f64::from(distance));
    }
}

/// Compares the whole texels that lower bounds do not rule out.
#[apply(vectorized!)]
fn search_bounded<M: WindowMetric, K: Keep>(
    metric: &M,
    windows: &ProjectedWindows,
    pattern: &M::Pattern,
    keep: &mut K,
) {
    search_within(windows, M::parts(pattern), keep, |texel, limit| {
        f64::from(metric.distance_inline(pattern, texel, limit as f32))
    });
}
