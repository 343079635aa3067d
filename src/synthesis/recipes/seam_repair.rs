//! The end of the finest level: sites where the map fits far worse than elsewhere are searched in full.
//!
//! Where two copied patches do not line up, the neighbours of a site propose few texels, and the nearest of those fit
//! one patch or the other. A texel that would join the two patches is never a candidate, however many passes are
//! made. Such sites are few, so every whole texel is tried there. Deviation: Tong 2002 §5.2 searches by k-coherence
//! alone, or everywhere in full.

use rayon::prelude::*;

use crate::error::Result;
use crate::progress::Progress;
use crate::sites::level::{SampleLocation, Sites};
use crate::synthesis::drive::class_by_class;
use crate::synthesis::keep::Preference;
use crate::synthesis::metric::Metric;
use crate::synthesis::options::CandidateSearch;
use crate::synthesis::recipes::k_coherence::KCoherence;
use crate::synthesis::state::Texels;

/// How many times the mean distance a site's is that is searched in full.
const FAR_WORSE: f64 = 8.0;
/// The most that coherence is preferred there: what fits badly is less worth keeping whole.
const MOST_COHERENCE: f64 = 1.2;

/// `rounds` times the sites that fit [`FAR_WORSE`] than the mean are searched in full; then all that fit worse
/// choose once more.
pub fn repair_seams<const N: usize, S: Sites<N>, M: Metric>(
    rule: &KCoherence<'_, N, S, M>,
    state: &mut Texels,
    (classes, rounds): (&[Vec<u32>], u32),
    progress: Progress<'_>,
) -> Result<()> {
    let everywhere = KCoherence {
        search: CandidateSearch::Full,
        preference: Preference {
            coherence: rule.preference.coherence.min(MOST_COHERENCE),
            ..rule.preference
        },
        ..*rule
    };
    let mut distances = vec![0.0; state.coords.len()];
    let all = vec![true; state.coords.len()];
    measure(rule, state, &all, &mut distances, progress)?;
    for _ in 0..rounds {
        let before = state.coords.clone();
        let worst = above_the_mean(classes, &distances, FAR_WORSE);
        class_by_class(&everywhere, rule.sites, state, (&worst, 1), progress)?;
        let pairs = state.coords.iter().zip(&before);
        let changed: Vec<bool> = pairs.map(|(now, before)| now != before).collect();
        measure(rule, state, &changed, &mut distances, progress)?;
    }
    let worse = above_the_mean(classes, &distances, 1.0);
    class_by_class(rule, rule.sites, state, (&worse, 1), progress)
}

/// Measures what every site holds, where it or a site that its samples read has `changed`.
pub fn measure<const N: usize, S: Sites<N>, M: Metric>(
    rule: &KCoherence<'_, N, S, M>,
    state: &Texels,
    changed: &[bool],
    distances: &mut [f32],
    progress: Progress<'_>,
) -> Result<()> {
    let at_site = |pattern: &mut M::Pattern, (site, distance): (usize, &mut f32)| {
        let any_changed =
            |sample: SampleLocation<N>| sample.sites().iter().any(|&read| changed[read as usize]);
        if progress.is_interrupted() || !changed[site] && !rule.sites.samples(site).any(any_changed)
        {
            return;
        }
        let texel = rule.exemplar.grid.texel_nearest(state.coords[site]);
        rule.metric.read(&rule.neighborhood(state, site), pattern);
        *distance = rule.metric.distance(pattern, texel.0, f64::INFINITY) as f32;
    };
    let sites = distances.par_iter_mut().enumerate();
    sites.for_each_init(M::Pattern::default, at_site);
    progress.check()
}

/// Of every class the sites whose distance is above `factor` times the mean.
fn above_the_mean(classes: &[Vec<u32>], distances: &[f32], factor: f64) -> Vec<Vec<u32>> {
    let sum: f64 = distances.iter().map(|&distance| f64::from(distance)).sum();
    let limit = factor * sum / distances.len().max(1) as f64;
    let above = |site: &u32| f64::from(distances[*site as usize]) > limit;
    let of_class = |class: &Vec<u32>| class.iter().copied().filter(above).collect();
    classes.iter().map(of_class).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_stands_out_is_searched() {
        let mut distances = vec![1.0; 200];
        distances[7] = 20.0;
        distances[150] = 5.0;
        let classes = [(0..100).collect(), (100..200).collect()];
        let above = |factor| above_the_mean(&classes, &distances, factor);
        assert_eq!(above(8.0), [vec![7], vec![]]);
        assert_eq!(above(1.0), [vec![7], vec![150]]);
        // Nothing stands out of what is nothing throughout.
        let nothing: [Vec<u32>; 2] = Default::default();
        assert_eq!(above_the_mean(&classes, &[0.0; 200], 1.0), nothing);
    }
}
