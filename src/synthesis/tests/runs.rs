//! The engine against what it promises: copies, determinism, resumed and interrupted runs, inputs that do not
//! fit.

use rand::Rng;

use super::fixtures;
use crate::error::{Error, Result};
use crate::exemplar::embedding::Embedding;
use crate::exemplar::level::ExemplarLevel;
use crate::exemplar::neighbor_table::NeighborTable;
use crate::exemplar::space::{Features, Space, SpaceLevel};
use crate::grid::TexelGrid;
use crate::index::TexelIndex;
use crate::progress::Progress;
use crate::random;
use crate::sites::coloring::color_classes;
use crate::sites::grid::GridSites;
use crate::sites::grid::window::SiteGrid;
use crate::sites::level::{Parent, SiteHierarchy, Sites};
use crate::sites::order::Order;
use crate::synthesis::all_levels::synthesize;
use crate::synthesis::candidates::forward::CandidateList;
use crate::synthesis::drive::class_by_class;
use crate::synthesis::inputs::{Inputs, LevelMap};
use crate::synthesis::keep::Preference;
use crate::synthesis::map::textons;
use crate::synthesis::metric::embedded::EmbeddedMetric;
use crate::synthesis::options::{CandidateSearch, KCoherenceOptions, MetricKind, SynthesisOptions};
use crate::synthesis::quality;
use crate::synthesis::quality::energy;
use crate::synthesis::recipes::k_coherence::KCoherence;
use crate::synthesis::recipes::seam_repair::{measure, repair_seams};
use crate::synthesis::state::Texels;

fn preference() -> Preference {
    let KCoherenceOptions { coherence, .. } = KCoherenceOptions::default();
    Preference {
        coherence,
        floor: 0.0,
    }
}

fn grid(side: u32) -> SiteGrid {
    SiteGrid {
        width: side,
        height: side,
        toroidal: true,
    }
}

fn sites_for(table: &NeighborTable, side: u32, levels: usize) -> SiteHierarchy<GridSites> {
    let neighborhoods: Vec<_> = table.levels[..levels]
        .iter()
        .map(|level| level.neighborhood.clone())
        .collect();
    grid(side).hierarchy(&neighborhoods).unwrap()
}

fn run(inputs: Inputs<'_, GridSites>, options: &SynthesisOptions) -> LevelMap {
    synthesize(inputs, options, None, &mut |_| Ok(()), Progress::silent()).unwrap()
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
        channels: crate::exemplar::channels::Channels::default(),
        controls: Vec::new(),
        id: crate::format::id::ContentId::of_bytes(b"unique"),
        texel_mm: None,
        sample: crate::format::id::ContentId::of_bytes(b"sample"),
    };
    let table = fixtures::exact_table(&space, 4);
    (space, table)
}

#[test]
fn one_texel_grows_into_a_copy() {
    let (space, table) = unique_exemplar(12);
    for (search, order) in [
        (CandidateSearch::Full, Order::Constrained),
        (CandidateSearch::KCoherence, Order::Constrained),
        (CandidateSearch::Full, Order::Field),
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
            controls: None,
        };
        let options = SynthesisOptions {
            k_coherence: KCoherenceOptions {
                search,
                order,
                ..KCoherenceOptions::default()
            },
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
        assert!(
            found.energies.unwrap().energy < 0.1
                && found.energies.unwrap().energy_ratio_full >= 1.0
        );
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
        controls: None,
    };
    for search in [CandidateSearch::KCoherence, CandidateSearch::Full] {
        for metric in [MetricKind::Gram, MetricKind::Embedded] {
            let options = SynthesisOptions {
                k_coherence: KCoherenceOptions {
                    search,
                    ..KCoherenceOptions::default()
                },
                metric,
                spectrum: 1.0,
                ..SynthesisOptions::default()
            };
            let map = run(inputs, &options);
            let edges = grid(32).edges();
            let found = quality::measure(inputs, &map.coords, &edges, 1, Progress::silent());
            let found = found.unwrap();
            assert!(
                found.energies.unwrap().energy < 0.6,
                "{search:?} {metric:?} {found:?}"
            );
            assert!(
                found.energies.unwrap().energy_ratio_full < 1.3,
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
    let coarser = ExemplarLevel::new(&space, &table, 1, 4, false);
    let coarser = Texels::of_texels(&coarser, (0..256).map(|site| site % 64));
    let rule = KCoherence {
        exemplar: &exemplar,
        sites: &sites.levels[0],
        coarser: Some(&coarser),
        metric: &metric,
        search: CandidateSearch::KCoherence,
        preference: preference(),
    };
    let start = Texels::of_parents(&exemplar, sites.levels[0].parents(), &coarser);
    let classes = color_classes(&sites.levels[0], Progress::silent()).unwrap();
    let refined = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        let mut state = start.clone();
        let visits = (&classes[..], 2);
        pool.install(|| class_by_class(&rule, rule.sites, &mut state, visits, Progress::silent()))
            .unwrap();
        state
    };
    let parallel = refined(8);
    assert_eq!(parallel, refined(1));
    // One class per site: strictly sequential.
    let one_by_one: Vec<Vec<u32>> = classes.iter().flatten().map(|&site| vec![site]).collect();
    let mut sequential = start.clone();
    for _ in 0..2 {
        // One pass at a time, in which no site is spared its choice.
        class_by_class(
            &rule,
            rule.sites,
            &mut sequential,
            (&one_by_one, 1),
            Progress::silent(),
        )
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
        controls: None,
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
        controls: None,
    };
    let options = SynthesisOptions::default();
    let mut levels = Vec::new();
    let mut keep = |map: &LevelMap| -> Result<()> {
        levels.push(map.clone());
        Ok(())
    };
    let whole = synthesize(inputs, &options, None, &mut keep, Progress::silent()).unwrap();
    assert_eq!(levels.len(), 3);
    let mut short = levels[1].clone();
    short.coords.pop();
    let resumed = synthesize(
        inputs,
        &options,
        Some(short),
        &mut |_| Ok(()),
        Progress::silent(),
    );
    let error = resumed.unwrap_err().to_string();
    assert!(error.contains("finished level 1"), "{error}");
    for map in levels {
        let resumed = synthesize(
            inputs,
            &options,
            Some(map),
            &mut |_| Ok(()),
            Progress::silent(),
        );
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
        controls: None,
    };
    let flag = std::sync::atomic::AtomicBool::new(true);
    let progress = Progress::new(&|_| {}, Some(&flag));
    let stopped = synthesize(
        inputs,
        &SynthesisOptions::default(),
        None,
        &mut |_| Ok(()),
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
        controls: None,
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
    let rule = KCoherence {
        exemplar: &exemplar,
        sites: &sites,
        coarser: None,
        metric: &metric,
        search: CandidateSearch::KCoherence,
        preference: preference(),
    };
    let mut state = Texels::of_texels(&exemplar, (0..40).map(|_| 0));
    let classes = color_classes(&sites, Progress::silent()).unwrap();
    class_by_class(&rule, &sites, &mut state, (&classes, 1), Progress::silent()).unwrap();
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
fn seam_repair_mends_a_copy_and_lowers_what_k_coherence_leaves() {
    let (space, table) = fixtures::random_exemplar(9, 16, 1, true);
    let sites = sites_for(&table, 64, 1);
    let exemplar = ExemplarLevel::new(&space, &table, 0, 4, false);
    let fine = Embedding::new(&space.levels[0], 1.0);
    let metric = EmbeddedMetric::new(&exemplar, &fine, None).with_projected_windows(5, 0);
    let rule = KCoherence {
        exemplar: &exemplar,
        sites: &sites.levels[0],
        coarser: None,
        metric: &metric,
        search: CandidateSearch::KCoherence,
        preference: preference(),
    };
    let repaired = |mut state: Texels, rounds: u32| {
        let classes = color_classes(&sites.levels[0], Progress::silent()).unwrap();
        repair_seams(&rule, &mut state, (&classes, rounds), Progress::silent()).unwrap();
        state
    };
    let copied = |site: u32| (site / 64 % 16) * 16 + site % 16;
    let copy = Texels::of_texels(&exemplar, (0..4096).map(copied));
    let broken = (0..4096).map(|site| if site == 500 { 3 } else { copied(site) });
    assert_eq!(repaired(Texels::of_texels(&exemplar, broken), 0), copy);
    // A part of the copy not lined up: what k-coherence alone leaves at its seam is not the best there is.
    let apart = |site: u32| (20..30).contains(&(site / 64)) && (20..30).contains(&(site % 64));
    let split = |site: u32| copied(site + if apart(site) { 5 * 64 + 3 } else { 0 });
    let left = |rounds: u32| -> f64 {
        let split = Texels::of_texels(&exemplar, (0..4096).map(split));
        let mut found = vec![0.0; sites.levels[0].count()];
        let all = vec![true; found.len()];
        measure(
            &rule,
            &repaired(split, rounds),
            &all,
            &mut found,
            Progress::silent(),
        )
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
                   sites: &SiteHierarchy<GridSites>,
                   change: &dyn Fn(&mut SynthesisOptions)| {
        let mut options = SynthesisOptions::default();
        change(&mut options);
        let inputs = Inputs {
            space,
            table,
            sites,
            controls: None,
        };
        synthesize(inputs, &options, None, &mut |_| Ok(()), Progress::silent())
            .unwrap_err()
            .to_string()
    };
    let found = message(&space, &table, &sites, &|o| o.k_coherence.k = Some(5));
    assert!(
        found.contains("the table lists 4") && found.contains("knn --k 5"),
        "{found}"
    );
    let found = message(&space, &table, &sites, &|o| o.levels = Some(3));
    assert!(found.contains("the sample has 2"), "{found}");
    let found = message(&space, &table, &sites, &|o| o.neighborhood = Some(7));
    assert!(found.contains("the table's is 5"), "{found}");
    let (small, of_small) = fixtures::random_exemplar(8, 8, 2, true);
    let found = message(&small, &of_small, &sites, &|o| o.levels = Some(2));
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
    assert!(message(&space, &table, &wild, &|_| ()).contains("a parent per site"));
}
