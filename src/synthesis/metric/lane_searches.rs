//! Searches by metrics whose distance is a loop over lanes, compiled for each kind of vector registers.
//!
//! The distance is inlined into every search, so that a search is one function for one processor.

use multiversion::multiversion;

use crate::synthesis::candidates::forward::Candidate;
use crate::synthesis::keep::{Keep, Pick, smallest};
use crate::synthesis::metric::lower_bounds::{ProjectedWindows, search_within, smallest_within};
use crate::synthesis::metric::{Metric, search_texels};

/// A metric whose distance is a loop over lanes.
pub trait LaneMetric: Metric {
    /// The distance to a texel's neighbourhood, or infinity once it exceeds `limit`; always inlined.
    fn lane_distance(&self, pattern: &Self::Pattern, texel: u32, limit: f32) -> f32;

    /// The texels that a search compares.
    fn whole_texels(&self) -> &[u32];

    /// All numbers of a pattern, the fine window's first.
    fn numbers(pattern: &Self::Pattern) -> [&[f32]; 2];
}

#[multiversion(targets(
    "x86_64+avx512f+avx512bw+avx512vl+avx2+fma",
    "x86_64+avx2+fma",
    "aarch64+neon"
))]
pub fn distance<M: LaneMetric>(metric: &M, pattern: &M::Pattern, texel: u32, limit: f32) -> f32 {
    metric.lane_distance(pattern, texel, limit)
}

/// The best of `first` and some candidates.
#[multiversion(targets(
    "x86_64+avx512f+avx512bw+avx512vl+avx2+fma",
    "x86_64+avx2+fma",
    "aarch64+neon"
))]
pub fn best_candidate<M: LaneMetric>(
    metric: &M,
    pattern: &M::Pattern,
    candidates: &[Candidate],
    first: Option<Pick>,
    floor: f64,
) -> Option<Pick> {
    smallest(candidates, first, floor, |texel, limit| {
        f64::from(metric.lane_distance(pattern, texel, limit as f32))
    })
}

/// As [`best_candidate`], skipping those whose lower bound is above the best so far.
#[multiversion(targets(
    "x86_64+avx512f+avx512bw+avx512vl+avx2+fma",
    "x86_64+avx2+fma",
    "aarch64+neon"
))]
pub fn best_bounded<M: LaneMetric>(
    metric: &M,
    windows: &ProjectedWindows,
    pattern: &M::Pattern,
    candidates: &[Candidate],
    first: Option<Pick>,
    floor: f64,
) -> Option<Pick> {
    let numbers = M::numbers(pattern);
    smallest_within(
        windows,
        numbers,
        candidates,
        first,
        floor,
        |texel, limit| f64::from(metric.lane_distance(pattern, texel, limit as f32)),
    )
}

/// Compares every whole texel.
#[multiversion(targets(
    "x86_64+avx512f+avx512bw+avx512vl+avx2+fma",
    "x86_64+avx2+fma",
    "aarch64+neon"
))]
pub fn search_all<M: LaneMetric, K: Keep>(metric: &M, pattern: &M::Pattern, keep: &mut K) {
    search_texels(metric.whole_texels(), keep, |texel, limit| {
        f64::from(metric.lane_distance(pattern, texel, limit as f32))
    });
}

/// Compares the whole texels that lower bounds do not rule out.
#[multiversion(targets(
    "x86_64+avx512f+avx512bw+avx512vl+avx2+fma",
    "x86_64+avx2+fma",
    "aarch64+neon"
))]
pub fn search_bounded<M: LaneMetric, K: Keep>(
    metric: &M,
    windows: &ProjectedWindows,
    pattern: &M::Pattern,
    keep: &mut K,
) {
    search_within(windows, M::numbers(pattern), keep, |texel, limit| {
        f64::from(metric.lane_distance(pattern, texel, limit as f32))
    });
}
