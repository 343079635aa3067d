//! The end of the finest level: where the map fits worse than elsewhere, it is looked at again.
//!
//! A site's distance grows when its neighbours change after its last choice; and where two copied
//! patches meet out of step, the neighbours of a site propose few texels, whose nearest are in step
//! with one patch or the other: k-coherence finds nothing better however often it passes, though
//! the sample holds it. Such sites are few, so every whole texel is tried there.
//! Deviation: Tong 2002 §5.2 searches by k-coherence alone, or everywhere in full.

use rayon::prelude::*;

use crate::error::Result;
use crate::mesh::stencil::SampleLocation;
use crate::progress::Progress;
use crate::synthesis::metric::Metric;
use crate::synthesis::options::{Search, SynthesisOptions};
use crate::synthesis::passes::{LevelPass, LevelState};

/// How many times the mean distance a site's is that is searched in full.
const FAR_WORSE: f64 = 8.0;
/// The most that coherence is preferred there: what fits badly is less worth keeping whole.
const MOST_COHERENCE: f64 = 1.2;

impl<M: Metric> LevelPass<'_, M> {
    /// `rounds` times the sites that fit [`FAR_WORSE`] than the mean are searched in full; then all that
    /// fit worse choose once more.
    pub fn mend(
        &self,
        state: &mut LevelState,
        classes: &[Vec<u32>],
        rounds: u32,
        progress: Progress<'_>,
    ) -> Result<()> {
        let options = SynthesisOptions {
            search: Search::Full,
            coherence: self.options.coherence.min(MOST_COHERENCE),
            ..self.options.clone()
        };
        let everywhere = LevelPass {
            options: &options,
            ..*self
        };
        let mut distances = vec![0.0; self.sites.site_count];
        self.measure(
            state,
            &vec![true; state.coords.len()],
            &mut distances,
            progress,
        )?;
        for _ in 0..rounds {
            let before = state.coords.clone();
            let worst = above_the_mean(classes, &distances, FAR_WORSE);
            everywhere.refine(state, &worst, 1, progress)?;
            let pairs = state.coords.iter().zip(&before);
            let changed: Vec<bool> = pairs.map(|(now, before)| now != before).collect();
            self.measure(state, &changed, &mut distances, progress)?;
        }
        let worse = above_the_mean(classes, &distances, 1.0);
        self.refine(state, &worse, 1, progress)
    }

    /// Measures what every site holds, where it or a site that its samples read has `changed`.
    pub fn measure(
        &self,
        state: &LevelState,
        changed: &[bool],
        distances: &mut [f32],
        progress: Progress<'_>,
    ) -> Result<()> {
        let at_site = |pattern: &mut M::Pattern, (site, distance): (usize, &mut f32)| {
            let any_changed =
                |sample: SampleLocation| sample.sites().iter().any(|&read| changed[read as usize]);
            if progress.is_interrupted()
                || !changed[site] && !self.sites.fine.of_site(site).any(any_changed)
            {
                return;
            }
            let texel = self.exemplar.grid.texel_nearest(state.coords[site]);
            self.metric
                .read(&self.neighborhood(site, state, None), pattern);
            *distance = self.metric.distance(pattern, texel.0, f64::INFINITY) as f32;
        };
        let sites = distances.par_iter_mut().enumerate();
        sites.for_each_init(M::Pattern::default, at_site);
        progress.check()
    }
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
