//! How far the listed neighbours of every texel lie from it: what spares most of their distances.
//!
//! Distances are squares in a Euclidean space, so for a pattern f, a texel c and its neighbour e
//! |‖e − c‖ − ‖f − c‖| ≤ ‖f − e‖: once ‖f − c‖ is known, a neighbour whose radius ‖e − c‖ is too far
//! above or below it cannot be better than the best so far, and what is chosen stays the same.

use rayon::prelude::*;

use crate::synthesis::exemplar_level::ExemplarLevel;
use crate::synthesis::metric::Euclidean;

/// Texels a thread takes at a time.
const BATCH: usize = 64;
/// Share of the lengths compared by which they may be off, for the rounding of single precision.
const SLACK: f32 = 1e-4;

/// The radii of a level, one a listed neighbour.
#[derive(Clone, Debug, PartialEq)]
pub struct Radii {
    of_neighbors: Vec<f32>,
    listed: usize,
}

impl Radii {
    /// Measures the neighbours of every texel, itself left out.
    pub fn new<M: Euclidean>(metric: &M, exemplar: &ExemplarLevel<'_>) -> Self {
        let listed = exemplar.nearest(0).len() - 1;
        let mut of_neighbors = vec![0.0; listed * exemplar.grid.len()];
        let batches = of_neighbors
            .par_chunks_mut((BATCH * listed).max(1))
            .enumerate();
        batches.for_each_init(M::Pattern::default, |pattern, (batch, radii)| {
            let texels = (batch * BATCH) as u32..;
            for (texel, radii) in texels.zip(radii.chunks_exact_mut(listed)) {
                metric.pattern_of_texel(texel, pattern);
                for (radius, &near) in radii.iter_mut().zip(&exemplar.nearest(texel)[1..]) {
                    *radius = metric.distance(pattern, near, f64::INFINITY).sqrt() as f32;
                }
            }
        });
        Self {
            of_neighbors,
            listed,
        }
    }

    /// The radii of a texel's neighbours, in their order.
    #[inline(always)]
    pub fn of_texel(&self, texel: u32) -> &[f32] {
        &self.of_neighbors[texel as usize * self.listed..][..self.listed]
    }
}

/// Whether a neighbour at `radius` from a texel may lie within `reach` of a pattern that lies `away` from
/// the texel.
#[inline(always)]
pub fn may_reach(radius: f32, away: f32, reach: f32) -> bool {
    (radius - away).abs() <= reach + SLACK * (radius + away + reach)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthesis::embedded::{EmbeddedMetric, EmbeddedPattern};
    use crate::synthesis::embedding::Embedding;
    use crate::synthesis::fixtures;
    use crate::synthesis::metric::Metric;

    #[test]
    fn too_far_on_either_side_is_out_of_reach() {
        assert!(may_reach(3.0, 2.0, 1.0) && may_reach(1.0, 2.0, 1.0));
        assert!(!may_reach(3.1, 2.0, 1.0) && !may_reach(0.9, 2.0, 1.0));
        assert!(may_reach(1.0, 1.0, 0.0));
    }

    #[test]
    fn whatever_is_within_reach_is_not_ruled_out() {
        let (space, table) = fixtures::random_exemplar(4, 12, 2, false);
        let exemplar = ExemplarLevel::new(&space, &table, 0, 4, true);
        let [fine, coarse] = [0, 1].map(|level| Embedding::new(&space.levels[level], 0.9));
        let metric = EmbeddedMetric::new(&exemplar, &fine, Some(&coarse));
        let radii = Radii::new(&metric, &exemplar);
        let mut pattern = EmbeddedPattern::default();
        let mut ruled_out = 0;
        for own in 0..exemplar.grid.len() as u32 {
            metric.pattern_of_texel(own, &mut pattern);
            let distance = |texel: u32| metric.distance(&pattern, texel, f64::INFINITY).sqrt();
            for texel in (0..exemplar.grid.len() as u32).step_by(5) {
                let near = &exemplar.nearest(texel)[1..];
                for (&near, &radius) in near.iter().zip(radii.of_texel(texel)) {
                    let (away, reach) = (distance(texel) as f32, distance(near) as f32);
                    assert!(may_reach(radius, away, reach));
                    ruled_out += usize::from(!may_reach(radius, away, 0.5 * reach));
                }
            }
        }
        assert!(ruled_out > 0);
    }
}
