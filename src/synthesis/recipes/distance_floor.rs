//! The distance floor: a share of the distance between random texels, added to all distances of a choice.
//!
//! In a periodic sample, windows one period apart are at distance almost 0. Multiplying by κ then has no
//! effect and rounding decides; with a floor, coherence does.

use rand::Rng;

use crate::random;
use crate::sites::level::Sites;
use crate::synthesis::metric::Metric;
use crate::synthesis::recipes::k_coherence::KCoherence;
use crate::synthesis::state::Texels;

/// Sites that are enough to estimate the distance between random texels.
const PROBED_SITES: usize = 256;

/// The floor of a level: `share` of the distance between random texels, four times as much on each coarser level.
pub fn distance_floor<const N: usize, S: Sites<N>, M: Metric>(
    rule: &KCoherence<'_, N, S, M>,
    share: f64,
    (seed, level): (u64, u32),
) -> f64 {
    match share > 0.0 {
        true => share * 4_f64.powi(level as i32) * by_chance(rule, seed, level),
        false => 0.0,
    }
}

/// The mean distance of random texels in a map of random texels, at a few sites.
fn by_chance<const N: usize, S: Sites<N>, M: Metric>(
    rule: &KCoherence<'_, N, S, M>,
    seed: u64,
    level: u32,
) -> f64 {
    let (whole, sites) = (&rule.exemplar.whole_texels, rule.sites.count());
    let state = Texels::random(rule.exemplar, sites, (seed, level));
    let mut stream = random::stream(seed, "distance by chance", level, 0);
    let mut pattern = M::Pattern::default();
    let step = sites.div_ceil(PROBED_SITES).max(1);
    let distances = (0..sites).step_by(step).map(|site| {
        rule.metric
            .read(&rule.neighborhood(&state, site), &mut pattern);
        let texel = whole[stream.gen_range(0..whole.len())];
        rule.metric.distance(&pattern, texel, f64::INFINITY)
    });
    let distances: Vec<f64> = distances.collect();
    distances.iter().sum::<f64>() / distances.len().max(1) as f64
}
