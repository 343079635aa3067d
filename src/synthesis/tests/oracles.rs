//! The fast metrics and searches against slow exact ones.

use rand::Rng;

use super::fixtures;
use crate::exemplar::embedding::Embedding;
use crate::exemplar::level::ExemplarLevel;
use crate::exemplar::neighbor_table::NeighborTable;
use crate::exemplar::space::{Features, Space, SpaceLevel};
use crate::index::TexelIndex;
use crate::random;
use crate::sites::vertices::VertexSites;
use crate::synthesis::candidates::forward::Candidate;
use crate::synthesis::keep::Preference;
use crate::synthesis::metric::Metric;
use crate::synthesis::metric::embedded::{EmbeddedMetric, EmbeddedPattern};
use crate::synthesis::metric::gram::{GramMetric, GramPattern};
use crate::synthesis::metric::of_level::gram as gram_of;
use crate::synthesis::metric::site_values::{SampleValue, SiteNeighborhood};

/// A two-level exemplar, random sites on both levels, and random states.
struct Case {
    space: Space,
    table: NeighborTable,
    fine: VertexSites,
    states: [Vec<u32>; 2],
}

impl Case {
    fn new(seed: u64, tileable: bool) -> Self {
        let (space, table) = fixtures::random_exemplar(seed, 12, 2, tileable);
        let mut fine = fixtures::random_sites(seed, 60, 6);
        fine.coarse = Some(fixtures::random_stencils(seed + 1, 60, 9));
        let mut stream = random::stream(seed, "states", 0, 0);
        let mut state = |textons| (0..60).map(|_| stream.gen_range(0..textons)).collect();
        let states = [state(24), state(12)];
        Self {
            space,
            table,
            fine,
            states,
        }
    }

    fn neighborhood<'a>(
        &'a self,
        site: usize,
        done: Option<&'a [bool]>,
    ) -> SiteNeighborhood<'a, VertexSites> {
        fixtures::neighborhood_of((&self.fine, site), &self.states, done)
    }

    /// Σ wₚ ‖s(p) − t(p)‖² through Φ, sample by sample.
    fn distance(&self, site: &SiteNeighborhood<'_, VertexSites>, texel: u32) -> f64 {
        let neighborhood = &self.table.levels[0].neighborhood;
        let [level, coarser] = [0, 1].map(|index| &self.space.levels[index]);
        let (texel, parent) = (TexelIndex(texel), level.grid.parent(TexelIndex(texel)));
        let own = site.own();
        let own = own.map(|(place, value)| {
            sample_distance(level, value, texel, neighborhood.offsets[place])
        });
        let above = site.parent().zip(&neighborhood.coarse_offsets);
        let above = above.map(|(value, &offset)| sample_distance(coarser, value, parent, offset));
        own.sum::<f64>() + above.sum::<f64>()
    }
}

/// ‖s − t‖² through Φ, of what a sample holds and of a texel's texton at an offset.
pub fn sample_distance<const N: usize>(
    level: &SpaceLevel,
    value: SampleValue<N>,
    texel: TexelIndex,
    offset: [i32; 2],
) -> f64 {
    let Features::Textons { labels, gram } = &level.features else {
        panic!("textons expected");
    };
    let default = gram.nrows() - 1;
    let there = level.grid.offset(texel, offset[0], offset[1]);
    let label = there.map_or(default, |t| usize::from(labels[t.index()]));
    let mut shares = vec![0.0; gram.nrows()];
    shares[label] -= 1.0;
    match value {
        SampleValue::Default => shares[default] += 1.0,
        SampleValue::One(row) => shares[row as usize] += 1.0,
        SampleValue::Blend(rows, weights) => {
            for (row, weight) in rows.into_iter().zip(weights) {
                shares[row as usize] += f64::from(weight);
            }
        }
    }
    let phi = |i: usize, j: usize| f64::from(gram[(i, j)]);
    let held: Vec<usize> = (0..shares.len()).filter(|&i| shares[i] != 0.0).collect();
    let pairs = held.iter().flat_map(|&i| held.iter().map(move |&j| (i, j)));
    pairs.map(|(i, j)| shares[i] * shares[j] * phi(i, j)).sum()
}

#[test]
fn both_metrics_are_the_weighted_sum_of_squared_distances() {
    for (seed, tileable) in [(1, true), (2, false)] {
        let case = Case::new(seed, tileable);
        let exemplar = ExemplarLevel::new(&case.space, &case.table, 0, 4, true);
        let [fine, coarse] = [0, 1].map(|l| Embedding::new(&case.space.levels[l], 1.0));
        let embedded = EmbeddedMetric::new(&exemplar, &fine, Some(&coarse));
        let grams = [0, 1].map(|l| gram_of(&case.space.levels[l]).unwrap());
        let gram = GramMetric::new(&exemplar, grams[0], Some(grams[1]));
        let (mut in_rd, mut in_phi) = (EmbeddedPattern::default(), GramPattern::default());
        let done: Vec<bool> = (0..60).map(|site| site % 3 != 0).collect();
        for site in 0..60 {
            for done in [None, Some(&done[..])] {
                let neighborhood = case.neighborhood(site, done);
                embedded.read(&neighborhood, &mut in_rd);
                gram.read(&neighborhood, &mut in_phi);
                for texel in (0..144).step_by(5) {
                    let expected = case.distance(&neighborhood, texel);
                    let close = |found: f64| (found - expected).abs() < 1e-4 * (1.0 + expected);
                    assert!(close(gram.distance(&in_phi, texel, f64::INFINITY)));
                    assert!(close(embedded.distance(&in_rd, texel, f64::INFINITY)));
                }
            }
        }
    }
}

#[test]
fn full_search_with_bounds_is_the_scan_of_all() {
    let case = Case::new(5, true);
    let exemplar = ExemplarLevel::new(&case.space, &case.table, 0, 4, true);
    let [fine, coarse] = [0, 1].map(|l| Embedding::new(&case.space.levels[l], 1.0));
    let plain = EmbeddedMetric::new(&exemplar, &fine, Some(&coarse));
    let bounded = EmbeddedMetric::new(&exemplar, &fine, Some(&coarse)).with_projected_windows(9, 0);
    let all: Vec<Candidate> = (0..144)
        .map(|texel| Candidate { texel, factor: 1.0 })
        .collect();
    let coherent = [Candidate {
        texel: 77,
        factor: 1.0,
    }];
    let mut pattern = EmbeddedPattern::default();
    for site in 0..60 {
        plain.read(&case.neighborhood(site, None), &mut pattern);
        let expected = plain.best(&pattern, &all, None, 0.0);
        let none = Preference::NONE;
        assert_eq!(bounded.best_of_all(&mut pattern, &[], none), expected);
        assert_eq!(plain.best_of_all(&mut pattern, &[], none), expected);
        let some = Preference {
            coherence: 1.3,
            floor: 0.2,
        };
        let preferred = plain.best_of_all(&mut pattern, &coherent, some);
        let listed = bounded.best_of_all(&mut pattern, &coherent, some);
        assert_eq!(listed, preferred);
    }
    // A pattern that is itself a window of the exemplar is found, at distance nothing.
    for texel in [0, 50, 143] {
        plain.pattern_of_texel(texel, &mut pattern);
        let distance = plain.distance(&pattern, texel, f64::INFINITY);
        assert_eq!(distance, 0.0);
    }
}

#[test]
fn the_search_through_phi_agrees_with_its_scan() {
    let case = Case::new(6, false);
    let exemplar = ExemplarLevel::new(&case.space, &case.table, 0, 4, true);
    let grams = [0, 1].map(|l| gram_of(&case.space.levels[l]).unwrap());
    let gram = GramMetric::new(&exemplar, grams[0], Some(grams[1]));
    let mut pattern = GramPattern::default();
    for site in 0..60 {
        gram.read(&case.neighborhood(site, None), &mut pattern);
        let exact = |pattern: &GramPattern, texel| gram.distance(pattern, texel, f64::INFINITY);
        let texels = exemplar.whole_texels.iter();
        let distances: Vec<f64> = texels.map(|&texel| exact(&pattern, texel)).collect();
        let limit = distances[distances.len() / 2];
        let mut wanted = exemplar.whole_texels.iter().zip(&distances);
        gram.visit_all(&mut pattern, limit, |texel, found| {
            let (&next, &distance) = wanted.next().unwrap();
            assert_eq!(texel, next);
            assert!(found == distance || (found.is_infinite() && distance > limit));
            limit
        });
        assert!(wanted.next().is_none());
    }
}
