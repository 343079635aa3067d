//! Tests that hold the fast paths against slow exact ones, and the engine against what it promises.

use rand::Rng;

use super::candidates::{Candidate, CandidateList};
use super::choice::Preference;
use super::coloring::color_classes;
use super::embedded::{EmbeddedMetric, EmbeddedPattern};
use super::embedding::Embedding;
use super::engine::{Inputs, LevelMap, synthesize, textons};
use super::exemplar_level::ExemplarLevel;
use super::fixtures;
use super::gram::{GramMetric, GramPattern};
use super::grid_target::GridTarget;
use super::metric::Metric;
use super::options::{MetricKind, Order, Search, SynthesisOptions};
use super::passes::{LevelPass, LevelState};
use super::quality;
use super::quality::energy;
use super::site_samples::{Held, SampledSites, SiteNeighborhood};
use crate::error::{Error, Result};
use crate::exemplar::neighbor_table::NeighborTable;
use crate::exemplar::space::{Features, Space, SpaceLevel};
use crate::grid::TexelGrid;
use crate::index::TexelIndex;
use crate::mesh::hierarchy::{Parent, SiteHierarchy, SiteLevel};
use crate::progress::Progress;
use crate::random;

/// A two-level exemplar, random sites on both levels, and random states.
struct Case {
    space: Space,
    table: NeighborTable,
    fine: SiteLevel,
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

    fn neighborhood<'a>(&'a self, site: usize, done: Option<&'a [bool]>) -> SiteNeighborhood<'a> {
        let coarse = self.fine.coarse.as_ref().unwrap();
        SiteNeighborhood {
            site,
            fine: SampledSites {
                done,
                ..SampledSites::all(&self.fine.fine, &self.states[0])
            },
            coarse: Some(SampledSites::all(coarse, &self.states[1])),
        }
    }

    /// Σ wₚ ‖s(p) − t(p)‖² through Φ, sample by sample.
    fn distance(&self, site: &SiteNeighborhood<'_>, texel: u32) -> f64 {
        let neighborhood = &self.table.levels[0].neighborhood;
        let [level, coarser] = [0, 1].map(|index| &self.space.levels[index]);
        let parent = level.grid.parent(TexelIndex(texel));
        let part = |sites: &SampledSites<'_>, level, texel, offsets: &[[i32; 2]]| {
            let samples = sites.of_site(site.site);
            samples
                .map(|(place, held)| sample_distance(level, held, texel, offsets[place]))
                .sum::<f64>()
        };
        let offsets = (&neighborhood.offsets, &neighborhood.coarse_offsets);
        part(&site.fine, level, TexelIndex(texel), offsets.0)
            + part(&site.coarse.unwrap(), coarser, parent, offsets.1)
    }
}

fn sample_distance(level: &SpaceLevel, held: Held, texel: TexelIndex, offset: [i32; 2]) -> f64 {
    let Features::Textons { labels, gram } = &level.features else {
        panic!("textons expected");
    };
    let default = gram.nrows() - 1;
    let there = level.grid.offset(texel, offset[0], offset[1]);
    let label = there.map_or(default, |t| usize::from(labels[t.index()]));
    let mut shares = vec![0.0; gram.nrows()];
    shares[label] -= 1.0;
    match held {
        Held::Default => shares[default] += 1.0,
        Held::One(row) => shares[row as usize] += 1.0,
        Held::Blend(rows, weights) => {
            for (row, weight) in rows.into_iter().zip(weights) {
                shares[row as usize] += f64::from(weight);
            }
        }
    }
    let phi = |i: usize, j: usize| f64::from(gram[(i, j)]);
    let pairs = (0..shares.len()).flat_map(|i| (0..shares.len()).map(move |j| (i, j)));
    pairs.map(|(i, j)| shares[i] * shares[j] * phi(i, j)).sum()
}

#[test]
fn both_metrics_are_the_weighted_sum_of_squared_distances() {
    for (seed, tileable) in [(1, true), (2, false)] {
        let case = Case::new(seed, tileable);
        let exemplar = ExemplarLevel::new(&case.space, &case.table, 0, 4, true);
        let [fine, coarse] = [0, 1].map(|l| Embedding::new(&case.space.levels[l], 1.0));
        let embedded = EmbeddedMetric::new(&exemplar, &fine, Some(&coarse));
        let grams = [0, 1].map(|l| super::check::gram(&case.space.levels[l]).unwrap());
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
            noise: 0.2,
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
    let grams = [0, 1].map(|l| super::check::gram(&case.space.levels[l]).unwrap());
    let gram = GramMetric::new(&exemplar, grams[0], Some(grams[1]));
    let mut pattern = GramPattern::default();
    for site in 0..60 {
        gram.read(&case.neighborhood(site, None), &mut pattern);
        let found = gram.distances_to_all(&mut pattern);
        for (&texel, distance) in exemplar.whole_texels.iter().zip(found) {
            assert_eq!(distance, gram.distance(&pattern, texel, f64::INFINITY));
        }
    }
}

fn grid(side: u32) -> GridTarget {
    GridTarget {
        width: side,
        height: side,
        toroidal: true,
    }
}

fn sites_for(table: &NeighborTable, side: u32, levels: usize) -> SiteHierarchy {
    let neighborhoods: Vec<_> = table.levels[..levels]
        .iter()
        .map(|level| level.neighborhood.clone())
        .collect();
    grid(side).hierarchy(&neighborhoods).unwrap()
}

fn run(inputs: Inputs<'_>, options: &SynthesisOptions) -> LevelMap {
    synthesize(inputs, options, None, |_| Ok(()), Progress::silent()).unwrap()
}

/// An exemplar in which every texel is its own texton, so that nothing repeats.
fn unique_exemplar(side: u32) -> (Space, NeighborTable) {
    let grid = TexelGrid {
        width: side,
        height: side,
        tileable: true,
    };
    let texels = grid.len();
    let space = Space {
        levels: vec![SpaceLevel {
            grid,
            features: Features::Textons {
                labels: (0..texels as u16).collect(),
                gram: fixtures::random_gram(4, texels, 12),
            },
        }],
        id: crate::format::id::ContentId::of_bytes(b"unique"),
        sample: crate::format::id::ContentId::of_bytes(b"sample"),
    };
    let table = fixtures::exact_table(&space, 4);
    (space, table)
}

#[test]
fn one_texel_grows_into_a_copy() {
    let (space, table) = unique_exemplar(12);
    for (search, order) in [
        (Search::Full, Order::Constrained),
        (Search::KCoherence, Order::Constrained),
        (Search::Full, Order::Field),
    ] {
        let mut target = grid(24);
        // Samples off an open border hold the default texton, which no window of a tile does: a front
        // that reaches the border with little behind it would be misled.
        target.toroidal = order == Order::Field;
        let neighborhoods = [table.levels[0].neighborhood.clone()];
        let sites = target.hierarchy(&neighborhoods).unwrap();
        let inputs = Inputs {
            space: &space,
            table: &table,
            sites: &sites,
        };
        let options = SynthesisOptions {
            search,
            order,
            metric: MetricKind::Gram,
            seed: 3,
            ..SynthesisOptions::default()
        };
        let map = run(inputs, &options);
        let found = quality::measure(inputs, &map.coords, &target.edges(), 1, Progress::silent());
        let found = found.unwrap();
        assert!(
            found.coherence_half > 0.99,
            "{search:?} {order:?} {found:?}"
        );
        assert!((found.drift[0][0] - 1.0).abs() < 0.01 && found.drift[0][1].abs() < 0.01);
        assert!((found.drift[1][1] - 1.0).abs() < 0.01 && found.drift[1][0].abs() < 0.01);
        assert!(found.energy < 0.1 && found.energy_ratio_full >= 1.0);
    }
}

#[test]
fn every_way_of_synthesis_beats_chance_and_fills_the_map() {
    let (space, table) = fixtures::random_exemplar(8, 16, 2, true);
    let sites = sites_for(&table, 32, 2);
    let inputs = Inputs {
        space: &space,
        table: &table,
        sites: &sites,
    };
    for search in [Search::KCoherence, Search::Full] {
        for metric in [MetricKind::Gram, MetricKind::Embedded] {
            let options = SynthesisOptions {
                search,
                metric,
                energy: 1.0,
                ..SynthesisOptions::default()
            };
            let map = run(inputs, &options);
            let edges = grid(32).edges();
            let found = quality::measure(inputs, &map.coords, &edges, 1, Progress::silent());
            let found = found.unwrap();
            assert!(found.energy < 0.6, "{search:?} {metric:?} {found:?}");
            assert!(
                found.energy_ratio_full < 1.3,
                "{search:?} {metric:?} {found:?}"
            );
            let level = &space.levels[0];
            for (&at, texton) in map.coords.iter().zip(textons(&space, &map.coords)) {
                let texel = level.grid.texel_holding(at).unwrap();
                assert_eq!(at, level.grid.centre(texel));
                let Features::Textons { labels, .. } = &level.features else {
                    panic!("textons expected");
                };
                assert_eq!(labels[texel.index()], texton.0);
            }
        }
    }
}

#[test]
fn refinement_never_worsens_a_grid_and_equals_the_sequential_order() {
    let (space, table) = fixtures::random_exemplar(9, 16, 2, true);
    let sites = sites_for(&table, 32, 2);
    let exemplar = ExemplarLevel::new(&space, &table, 0, 4, true);
    let [fine, coarse] = [0, 1].map(|l| Embedding::new(&space.levels[l], 1.0));
    let metric = EmbeddedMetric::new(&exemplar, &fine, Some(&coarse));
    let options = SynthesisOptions::default();
    let coarser = ExemplarLevel::new(&space, &table, 1, 4, false);
    let coarser = LevelState::of_texels(&coarser, (0..256).map(|site| site % 64));
    let pass = LevelPass {
        level: 0,
        exemplar: &exemplar,
        sites: &sites.levels[0],
        coarser: Some(&coarser),
        metric: &metric,
        options: &options,
        noise: 0.0,
    };
    let start = pass.from_coarser(&coarser);
    let classes = color_classes(&sites.levels[0], Progress::silent()).unwrap();
    let refined = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        let mut state = start.clone();
        pool.install(|| pass.refine(&mut state, &classes, 2, Progress::silent()))
            .unwrap();
        state
    };
    let parallel = refined(8);
    assert_eq!(parallel, refined(1));
    // One class a site: strictly sequential.
    let one_by_one: Vec<Vec<u32>> = classes.iter().flatten().map(|&site| vec![site]).collect();
    let mut sequential = start.clone();
    for _ in 0..2 {
        // One pass at a time, in which no site is spared its choice.
        pass.refine(&mut sequential, &one_by_one, 1, Progress::silent())
            .unwrap();
    }
    assert_eq!(parallel, sequential);
    assert_ne!(parallel, start);
}

#[test]
fn seeds_differ_and_runs_do_not() {
    let (space, table) = fixtures::random_exemplar(8, 16, 2, true);
    let sites = sites_for(&table, 32, 2);
    let inputs = Inputs {
        space: &space,
        table: &table,
        sites: &sites,
    };
    let with_seed = |seed| {
        run(
            inputs,
            &SynthesisOptions {
                seed,
                ..SynthesisOptions::default()
            },
        )
    };
    assert_eq!(with_seed(1), with_seed(1));
    assert_ne!(with_seed(1), with_seed(2));
}

#[test]
fn a_resumed_run_ends_like_an_uninterrupted_one() {
    let (space, table) = fixtures::random_exemplar(8, 20, 3, true);
    let sites = sites_for(&table, 40, 3);
    let inputs = Inputs {
        space: &space,
        table: &table,
        sites: &sites,
    };
    let options = SynthesisOptions::default();
    let mut levels = Vec::new();
    let keep = |map: &LevelMap| -> Result<()> {
        levels.push(map.clone());
        Ok(())
    };
    let whole = synthesize(inputs, &options, None, keep, Progress::silent()).unwrap();
    assert_eq!(levels.len(), 3);
    for map in levels {
        let resumed = synthesize(inputs, &options, Some(map), |_| Ok(()), Progress::silent());
        assert_eq!(resumed.unwrap(), whole);
    }
}

#[test]
fn an_interrupted_run_stops() {
    let (space, table) = fixtures::random_exemplar(8, 16, 2, true);
    let sites = sites_for(&table, 32, 2);
    let inputs = Inputs {
        space: &space,
        table: &table,
        sites: &sites,
    };
    let flag = std::sync::atomic::AtomicBool::new(true);
    let progress = Progress::new(&|_| {}, Some(&flag));
    let stopped = synthesize(
        inputs,
        &SynthesisOptions::default(),
        None,
        |_| Ok(()),
        progress,
    );
    assert!(matches!(stopped, Err(Error::Interrupted)));
}

#[test]
fn the_energy_of_a_copy_is_nothing_and_of_chance_is_one() {
    let (space, table) = fixtures::random_exemplar(8, 16, 1, true);
    let sites = sites_for(&table, 32, 1);
    let inputs = Inputs {
        space: &space,
        table: &table,
        sites: &sites,
    };
    let texels = space.levels[0].grid;
    let copy = |site: u32| texels.texel((site / 32) % 16, site % 16);
    let coords: Vec<_> = (0..1024).map(|site| texels.centre(copy(site))).collect();
    let energies = energy::measure(inputs, &coords, 5, Progress::silent()).unwrap();
    assert_eq!(energies.sites.len(), 1000);
    assert_eq!((energies.over_random(), energies.over_best()), (0.0, 1.0));
    let all = energy::of_every_site(inputs, &coords, Progress::silent()).unwrap();
    assert!(all.iter().all(|&distance| distance < 1e-9));
    let mut stream = random::stream(77, "other", 0, 0);
    let chance = (0..1024).map(|_| texels.centre(TexelIndex(stream.gen_range(0..256))));
    let energies =
        energy::measure(inputs, &chance.collect::<Vec<_>>(), 5, Progress::silent()).unwrap();
    assert!((energies.over_random() - 1.0).abs() < 0.1);
    assert!(energies.over_best() > 1.2);
}

#[test]
fn a_site_without_whole_candidates_is_searched_in_full() {
    let (space, table) = fixtures::random_exemplar(8, 16, 1, false);
    let exemplar = ExemplarLevel::new(&space, &table, 0, 1, false);
    let mut list = CandidateList::default();
    let corner = exemplar.grid.centre(TexelIndex(0));
    let nobody = std::iter::empty();
    list.collect_coherent(&exemplar, Some(corner), nobody, &[], |_| true);
    list.add_nearest(&exemplar, 1.0);
    assert!(list.candidates().is_empty());
    let sites = fixtures::random_sites(3, 40, 0);
    let fine = Embedding::new(&space.levels[0], 1.0);
    let metric = EmbeddedMetric::new(&exemplar, &fine, None);
    let options = SynthesisOptions::default();
    let pass = LevelPass {
        level: 0,
        exemplar: &exemplar,
        sites: &sites,
        coarser: None,
        metric: &metric,
        options: &options,
        noise: 0.0,
    };
    let mut state = LevelState::of_texels(&exemplar, (0..40).map(|_| 0));
    pass.refine(
        &mut state,
        &color_classes(&sites, Progress::silent()).unwrap(),
        1,
        Progress::silent(),
    )
    .unwrap();
    let picked = state
        .coords
        .iter()
        .map(|&at| exemplar.grid.texel_nearest(at));
    assert!(
        picked
            .into_iter()
            .all(|texel| exemplar.whole[texel.index()])
    );
}

#[test]
fn mending_repairs_a_copy_and_lowers_what_k_coherence_leaves() {
    let (space, table) = fixtures::random_exemplar(9, 16, 1, true);
    let sites = sites_for(&table, 64, 1);
    let exemplar = ExemplarLevel::new(&space, &table, 0, 4, false);
    let fine = Embedding::new(&space.levels[0], 1.0);
    let metric = EmbeddedMetric::new(&exemplar, &fine, None).with_projected_windows(5, 0);
    let options = SynthesisOptions::default();
    let pass = LevelPass {
        level: 0,
        exemplar: &exemplar,
        sites: &sites.levels[0],
        coarser: None,
        metric: &metric,
        options: &options,
        noise: 0.0,
    };
    let mended = |mut state: LevelState, rounds: u32| {
        pass.mend(
            &mut state,
            &color_classes(&sites.levels[0], Progress::silent()).unwrap(),
            rounds,
            Progress::silent(),
        )
        .unwrap();
        state
    };
    let copied = |site: u32| (site / 64 % 16) * 16 + site % 16;
    let copy = LevelState::of_texels(&exemplar, (0..4096).map(copied));
    let broken = (0..4096).map(|site| if site == 500 { 3 } else { copied(site) });
    assert_eq!(mended(LevelState::of_texels(&exemplar, broken), 0), copy);
    // A part of the copy out of step: what k-coherence alone leaves at its seam is not the best there is.
    let apart = |site: u32| (20..30).contains(&(site / 64)) && (20..30).contains(&(site % 64));
    let split = |site: u32| copied(site + if apart(site) { 5 * 64 + 3 } else { 0 });
    let left = |rounds: u32| -> f64 {
        let split = LevelState::of_texels(&exemplar, (0..4096).map(split));
        let mut found = vec![0.0; pass.sites.site_count];
        let all = vec![true; found.len()];
        pass.measure(&mended(split, rounds), &all, &mut found, Progress::silent())
            .unwrap();
        found.iter().map(|&distance| f64::from(distance)).sum()
    };
    let (without, with) = (left(0), left(4));
    assert!(with < without, "{with} against {without}");
}

#[test]
fn inputs_that_do_not_fit_are_named() {
    let (space, table) = fixtures::random_exemplar(8, 16, 2, true);
    let sites = sites_for(&table, 32, 2);
    let message = |space: &Space,
                   table: &NeighborTable,
                   sites: &SiteHierarchy,
                   change: &dyn Fn(&mut SynthesisOptions)| {
        let mut options = SynthesisOptions::default();
        change(&mut options);
        let inputs = Inputs {
            space,
            table,
            sites,
        };
        synthesize(inputs, &options, None, |_| Ok(()), Progress::silent())
            .unwrap_err()
            .to_string()
    };
    let found = message(&space, &table, &sites, &|o| o.k = Some(5));
    assert!(
        found.contains("the table lists 4") && found.contains("knn --k 5"),
        "{found}"
    );
    let found = message(&space, &table, &sites, &|o| o.levels = Some(3));
    assert!(found.contains("the sample has 2"), "{found}");
    let found = message(&space, &table, &sites, &|o| o.neighborhood = Some(7));
    assert!(found.contains("the table's is 5"), "{found}");
    let (small, of_small) = fixtures::random_exemplar(8, 8, 2, true);
    let found = message(&small, &of_small, &sites, &|_| ());
    assert!(
        found.contains("level 1 of 4×4") && found.contains("at most 1"),
        "{found}"
    );
    let found = message(&space, &of_small, &sites, &|_| ());
    assert!(found.contains("different runs"), "{found}");
    let one = SiteHierarchy {
        levels: sites.levels[..1].to_vec(),
    };
    let found = message(&space, &table, &one, &|_| ());
    assert!(found.contains("the target has 1"), "{found}");
    let mut wild = sites.clone();
    wild.levels[0].parents[3] = Parent {
        site: 5000,
        x: 0.0,
        y: 0.0,
    };
    assert!(message(&space, &table, &wild, &|_| ()).contains("a parent a site"));
    assert!(super::check::same_run(&space, &of_small, false).is_ok());
    let mut other = of_small.clone();
    other.space = crate::format::id::ContentId::of_bytes(b"other");
    assert!(super::check::same_run(&space, &other, false).is_err());
    assert!(super::check::same_run(&space, &other, true).is_ok());
}
