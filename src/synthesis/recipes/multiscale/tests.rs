//! Every pass against a search that compares every texel sample by sample.

use std::collections::BTreeSet;

use super::*;
use crate::exemplar::neighbor_table::NeighborTable;
use crate::exemplar::space::Space;
use crate::sites::grid::GridSites;
use crate::sites::grid::window::SiteGrid;
use crate::sites::level::SiteHierarchy;
use crate::sites::vertices::VertexSites;
use crate::synthesis::all_levels::synthesize;
use crate::synthesis::options::{Method, MetricKind};
use crate::synthesis::recipes::multiscale::options::MultiscaleOptions;
use crate::synthesis::tests::fixtures;
use crate::synthesis::tests::oracles::sample_distance;

/// Rounding of single precision, as a share of a distance.
const ROUNDING: f64 = 1e-4;

fn options(seed: u64) -> SynthesisOptions {
    SynthesisOptions {
        method: Method::Multiscale,
        spectrum: 1.0,
        multiscale: MultiscaleOptions {
            window: 5,
            parent_window: 3,
            ..MultiscaleOptions::default()
        },
        seed,
        ..SynthesisOptions::default()
    }
}

fn target(side: u32, levels: usize) -> SiteHierarchy<GridSites> {
    let target = SiteGrid {
        width: side,
        height: side,
        toroidal: true,
    };
    let neighborhoods = options(0).multiscale.neighborhoods(levels);
    target.hierarchy(&neighborhoods).unwrap()
}

/// An exemplar, sites, and what a pass compares on one of their levels.
struct Case<'a, const N: usize, S> {
    inputs: Inputs<'a, S>,
    level: usize,
    kind: Kind,
    windows: &'a Neighborhood,
    coarser: Option<&'a Texels>,
}

impl<const N: usize, S: Sites<N>> Case<'_, N, S> {
    fn run(&self, options: &SynthesisOptions, start: Option<Texels>) -> Texels {
        let pass = Pass::<N, S> {
            inputs: self.inputs,
            options,
            level: self.level,
            kind: self.kind,
            coarser: self.coarser,
            start,
            progress: Progress::silent(),
        };
        pass.run(self.windows).unwrap()
    }

    /// The distance of a site's samples to a texel's.
    fn distance(&self, state: &Texels, site: usize, texel: u32) -> f64 {
        let neighborhood = SiteNeighborhood {
            site,
            sites: &self.inputs.sites.levels[self.level],
            rows: &state.rows,
            done: state.done.as_deref(),
            unfinished: Unfinished::Nearest,
            coarser: self.coarser.map(|coarser| &coarser.rows[..]),
        };
        let levels = &self.inputs.space.levels;
        let (level, windows) = (&levels[self.level], self.windows);
        let own = neighborhood.own();
        let own = own.take_while(|&(place, _)| place < windows.offsets.len());
        let own = own.map(|(place, value)| {
            let weight = f64::from(windows.weights[place]);
            weight * sample_distance(level, value, TexelIndex(texel), windows.offsets[place])
        });
        let parent = level.grid.parent(TexelIndex(texel));
        let above = neighborhood.parent().zip(&windows.coarse_offsets);
        let above =
            above.map(|(value, &at)| sample_distance(&levels[self.level + 1], value, parent, at));
        own.sum::<f64>() + above.sum::<f64>()
    }

    /// Distances and texels among which one may be drawn, with a share of the distances to spare.
    fn matches(&self, state: &Texels, site: usize, most: usize, spare: f64) -> Vec<u32> {
        let grid = self.inputs.space.levels[self.level].grid;
        let texels = (0..grid.len() as u32).filter(|&texel| {
            let (row, col) = grid.row_col(TexelIndex(texel));
            self.kind != Kind::First || (row % 2, col % 2) == (0, 0)
        });
        let mut all: Vec<(f64, u32)> = texels
            .map(|texel| (self.distance(state, site, texel), texel))
            .collect();
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        let last = all[most.min(all.len()) - 1].0;
        let limit = last.min(1.21 * all[0].0) * (1.0 + spare) + spare;
        let within = all.into_iter().filter(|&(distance, _)| distance <= limit);
        within.map(|(_, texel)| texel).collect()
    }
}

fn held(case: &Case<'_, 1, GridSites>, state: &Texels, site: usize) -> u32 {
    let grid = case.inputs.space.levels[case.level].grid;
    grid.texel_nearest(state.coords[site]).0
}

/// A coarser level of 6×6 sites that holds texels anyhow.
fn coarser(space: &Space) -> Texels {
    let grid = space.levels[1].grid;
    let texel = |site: u32| TexelIndex((7 * site + site / 5) % grid.len() as u32);
    let coords = (0..36).map(|site| grid.centre(texel(site))).collect();
    Texels::on(&space.levels[1], coords)
}

#[test]
fn the_first_pass_draws_among_the_nearest_coarser_windows_and_exhausts_them() {
    let (space, table) = fixtures::random_exemplar(3, 12, 2, true);
    let (sites, above) = (target(12, 2), coarser(&space));
    let windows = Neighborhood::square(0, 3);
    let case = Case {
        inputs: Inputs {
            space: &space,
            table: &table,
            sites: &sites,
            controls: None,
        },
        level: 0,
        kind: Kind::First,
        windows: &windows,
        coarser: Some(&above),
    };
    let nothing = Texels {
        rows: vec![0; 144],
        ..Texels::default()
    };
    let mut drawn = vec![BTreeSet::new(); 144];
    for seed in 0..60 {
        let state = case.run(&options(seed), None);
        for (site, drawn) in drawn.iter_mut().enumerate() {
            let texel = TexelIndex(held(&case, &state, site));
            let (row, col) = space.levels[0].grid.row_col(texel);
            // The quarter that the site has in its parent, as parents hold centres.
            assert_eq!([row % 2, col % 2], [site as u32 / 12 % 2, site as u32 % 2]);
            drawn.insert(12 * (row & !1) + (col & !1));
        }
    }
    let mut several = 0;
    for (site, drawn) in drawn.iter().enumerate() {
        let surely = case.matches(&nothing, site, 8, -ROUNDING);
        let perhaps = case.matches(&nothing, site, 8, ROUNDING);
        assert!(drawn.iter().all(|texel| perhaps.contains(texel)), "{site}");
        if surely.len() <= 4 {
            several += usize::from(surely.len() > 1);
            assert!(surely.iter().all(|texel| drawn.contains(texel)), "{site}");
        }
    }
    assert!(several > 10, "{several}");
}

#[test]
fn the_second_pass_draws_among_the_nearest_of_both_windows() {
    let (space, table) = fixtures::random_exemplar(4, 12, 2, true);
    let (sites, above) = (target(12, 2), coarser(&space));
    let windows = Neighborhood::square(5, 3);
    let case = Case {
        inputs: Inputs {
            space: &space,
            table: &table,
            sites: &sites,
            controls: None,
        },
        level: 0,
        kind: Kind::Second,
        windows: &windows,
        coarser: Some(&above),
    };
    let grid = space.levels[0].grid;
    let first: Vec<TexCoord> = (0..144)
        .map(|site| grid.centre(TexelIndex((5 * site) % 144)))
        .collect();
    let start = Texels::on(&space.levels[0], first);
    for metric in [MetricKind::Embedded, MetricKind::Gram] {
        let options = SynthesisOptions {
            metric,
            ..options(9)
        };
        let end = case.run(&options, Some(start.clone()));
        let mut state = start.clone();
        for class in color_classes(&sites.levels[0], Progress::silent()).unwrap() {
            for &site in &class {
                let site = site as usize;
                let perhaps = case.matches(&state, site, 8, ROUNDING);
                assert!(perhaps.contains(&held(&case, &end, site)), "{site}");
            }
            for site in class {
                state.coords[site as usize] = end.coords[site as usize];
                state.rows[site as usize] = end.rows[site as usize];
            }
        }
    }
}

#[test]
fn the_coarsest_level_takes_the_nearest_of_what_is_synthesized() {
    let (space, table) = fixtures::random_exemplar(5, 12, 1, true);
    let windows = options(0).multiscale.neighborhoods(1).remove(0);
    // Samples between three sites, of which some are not synthesized.
    let sites = SiteHierarchy {
        levels: vec![fixtures::random_sites(6, 50, 6)],
    };
    let case = Case::<3, VertexSites> {
        inputs: Inputs {
            space: &space,
            table: &table,
            sites: &sites,
            controls: None,
        },
        level: 0,
        kind: Kind::Coarsest,
        windows: &windows,
        coarser: None,
    };
    let end = case.run(&options(2), None);
    let mut stream = random::stream(2, "growth start", 0, 0);
    let start = stream.gen_range(0..50);
    let order = scan_order(&sites.levels[0], start, Progress::silent()).unwrap();
    let mut state = Texels {
        done: Some(vec![false; 50]),
        ..end.clone()
    };
    let grid = space.levels[0].grid;
    let mut searched = 0;
    for site in order {
        let site = site as usize;
        let done = state.done.as_deref().unwrap();
        let mut samples = sites.levels[0].samples(site);
        if samples.any(|sample| sample.sites().iter().any(|&near| done[near as usize])) {
            searched += 1;
            let nearest = case.matches(&state, site, 1, ROUNDING);
            let texel = grid.texel_nearest(end.coords[site]).0;
            assert!(nearest.contains(&texel), "{site}: {texel} {nearest:?}");
        }
        state.done.as_mut().unwrap()[site] = true;
    }
    assert!(searched > 40, "{searched}");
}

fn whole_run(
    (space, table): &(Space, NeighborTable),
    sites: &SiteHierarchy<GridSites>,
    options: &SynthesisOptions,
) -> Vec<TexCoord> {
    let inputs = Inputs {
        space,
        table,
        sites,
        controls: None,
    };
    let progress = Progress::silent();
    let map = synthesize(inputs, options, None, &mut |_| Ok(()), progress);
    map.unwrap().coords
}

#[test]
fn threads_change_nothing_and_seeds_do() {
    let exemplar = fixtures::random_exemplar(7, 12, 2, true);
    let sites = target(24, 2);
    let with_threads = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        let pool = pool.build().unwrap();
        pool.install(|| whole_run(&exemplar, &sites, &options(1)))
    };
    let one = with_threads(1);
    assert_eq!(one, with_threads(2));
    assert_eq!(one, with_threads(8));
    assert_ne!(one, whole_run(&exemplar, &sites, &options(2)));
}

#[test]
fn windows_that_fit_neither_the_sample_nor_the_target_are_refused() {
    let (space, table) = fixtures::random_exemplar(7, 16, 3, true);
    let sites = target(24, 2);
    let inputs = Inputs {
        space: &space,
        table: &table,
        sites: &sites,
        controls: None,
    };
    let refused = |change: fn(&mut SynthesisOptions)| {
        let mut options = options(0);
        change(&mut options);
        let progress = Progress::silent();
        let map = synthesize(inputs, &options, None, &mut |_| Ok(()), progress);
        map.unwrap_err().to_string()
    };
    // Level 2 has 4×4 texels: two levels fit windows of 5.
    let found = refused(|o| o.levels = Some(3));
    assert!(
        found.contains("--window: 5 texels wide on the sample's level 2 of 4×4"),
        "{found}"
    );
    let found = refused(|o| o.multiscale.window = 17);
    assert!(
        found.contains("--window: 17") && found.contains("at most 16"),
        "{found}"
    );
    let found = refused(|o| {
        o.multiscale.parent_window = 9;
        o.levels = Some(2);
    });
    assert!(found.contains("--parent-window: 9 texels"), "{found}");
    let found = refused(|o| o.multiscale.window = 7);
    assert!(
        found.contains("25 samples per site; expected 49"),
        "{found}"
    );
    let found = refused(|o| o.levels = Some(4));
    assert!(found.contains("4, but the sample has 3"), "{found}");
}
