//! Polishing against closed forms: seams that must go, costs that must not rise, the same bytes at any threads.

use super::*;
use crate::exemplar::neighbor_table::NeighborTable;
use crate::exemplar::space::Space;
use crate::sites::grid::GridSites;
use crate::sites::grid::window::SiteGrid;
use crate::sites::level::SiteHierarchy;
use crate::synthesis::polish::region::{Places, Region};
use crate::synthesis::polish::repeats::repeated;
use crate::synthesis::state::Texels;
use crate::synthesis::tests::fixtures;

const SIDE: u32 = 16;

/// A flat grid of this many sites per side with windows 5 texels wide.
fn flat(side: u32) -> SiteHierarchy<GridSites> {
    let grid = SiteGrid {
        width: side,
        height: side,
        toroidal: false,
    };
    let window = fixtures::square_neighborhood(5, None);
    grid.hierarchy(&[window]).unwrap()
}

fn polished(
    (space, table): &(Space, NeighborTable),
    sites: &SiteHierarchy<GridSites>,
    coords: &[TexCoord],
    effort: Effort,
) -> (Vec<TexCoord>, Vec<f64>) {
    let exemplar = ExemplarLevel::new(space, table, 0, table.k, false);
    let embedding = Embedding::new(&space.levels[0], 1.0);
    let (mut coords, quiet) = (coords.to_vec(), Progress::silent());
    let inputs = (&exemplar, &embedding);
    let cost = polish(inputs, &sites.levels[0], &mut coords, (effort, 7), quiet).unwrap();
    (coords, cost)
}

/// A random map of a grid.
fn random_map((space, table): &(Space, NeighborTable), side: u32) -> Vec<TexCoord> {
    let exemplar = ExemplarLevel::new(space, table, 0, table.k, false);
    Texels::random(&exemplar, (side * side) as usize, (5, 0)).coords
}

#[test]
fn a_planted_seam_is_removed() {
    const SIDE: u32 = 12;
    let exemplar = fixtures::random_exemplar(3, SIDE, 1, true);
    let grid = exemplar.0.levels[0].grid;
    // The left half is a copy of the sample, the right half another, five texels on and three down.
    let coords: Vec<TexCoord> = (0..SIDE * SIDE)
        .map(|site| {
            let (row, col) = (site / SIDE, site % SIDE);
            let (right, down) = if col < SIDE / 2 { (0, 0) } else { (5, 3) };
            grid.coordinate((col + right) as f32 + 0.5, (row + down) as f32 + 0.5)
        })
        .collect();
    let (coords, costs) = polished(&exemplar, &flat(SIDE), &coords, Effort::Rounds(3));
    assert!(costs[0] > 0.1 && costs[3].abs() < 1e-6, "{costs:?}");
    for site in 0..SIDE * SIDE {
        let (right, below) = (site + 1, site + SIDE);
        let has_right = right % SIDE > 0;
        for (other, step) in [(right, [1.0, 0.0]), (below, [0.0, -1.0])] {
            if other >= SIDE * SIDE || (other == right && !has_right) {
                continue;
            }
            let (ds, dt) = grid.difference(coords[site as usize], coords[other as usize]);
            let off = (ds - step[0]).abs().max((dt - step[1]).abs());
            assert!(off < 1e-3, "site {site}");
        }
    }
}

#[test]
fn costs_never_rise_and_texels_stay_whole() {
    for tileable in [true, false] {
        let exemplar = fixtures::random_exemplar(4, SIDE, 1, tileable);
        let level = ExemplarLevel::new(&exemplar.0, &exemplar.1, 0, exemplar.1.k, false);
        let sites = flat(20);
        let coords = random_map(&exemplar, 20);
        let (next, costs) = polished(&exemplar, &sites, &coords, Effort::Rounds(3));
        assert!(
            costs.is_sorted_by(|before, after| before >= after),
            "{costs:?}"
        );
        assert!(costs[3] < 0.7 * costs[0], "{costs:?}");
        let is_whole = |&at: &TexCoord| level.whole[level.grid.texel_nearest(at).index()];
        assert!(next.iter().all(is_whole));
    }
}

#[test]
fn auto_changes_what_is_repeated_in_a_sample_that_does_not_tile() {
    const WIDE: u32 = 48;
    for tileable in [true, false] {
        let exemplar = fixtures::random_exemplar(7, WIDE, 1, tileable);
        let (sites, grid) = (flat(WIDE), exemplar.0.levels[0].grid);
        // A copy of the sample, but on the right four of its rows over and over.
        let coords: Vec<TexCoord> = (0..WIDE * WIDE)
            .map(|site| {
                let (row, col) = (site / WIDE, site % WIDE);
                let row = if col < WIDE / 2 { row } else { 20 + row % 4 };
                grid.coordinate(col as f32 + 0.5, row as f32 + 0.5)
            })
            .collect();
        let (next, costs) = polished(&exemplar, &sites, &coords, Effort::Auto);
        if tileable {
            assert_eq!((&next, costs.len()), (&coords, 1));
            continue;
        }
        assert!(costs[1] < 0.9 * costs[0], "{costs:?}");
        // A region reaches 12 texels from its centre, which has a fifth of it on the right.
        let kept = |site: &usize| site % (WIDE as usize) < 4;
        let changed = (0..coords.len()).filter(|&site| next[site] != coords[site]);
        assert_eq!(changed.clone().filter(kept).count(), 0);
        assert!(changed.count() > 200);
    }
}

#[test]
fn a_texel_shows_twice_where_it_is_farther_off_than_it_is_wide() {
    let links = Links::new(&flat(40).levels[0], Progress::silent()).unwrap();
    let region = Region::round(&links, 20 * 40 + 20, 8.0, &mut Places::default());
    let grid = fixtures::random_exemplar(8, 40, 1, false).0.levels[0].grid;
    // Every texel shown by this many rows side by side, and again so many rows on.
    let share = |rows: u32, period: u32| {
        let held = |site: u32| {
            let row = site / 40 / rows % period;
            grid.coordinate((site % 40) as f32 + 0.5, row as f32 + 0.5)
        };
        let coords: Vec<TexCoord> = (0..40 * 40).map(held).collect();
        repeated(grid, &region, &coords)
    };
    assert_eq!(share(1, 40), 0.0);
    assert_eq!(share(2, 40), 0.0);
    assert!(share(1, 3) > 0.9);
}

#[test]
fn any_number_of_threads_gives_the_same_map() {
    let exemplar = fixtures::random_exemplar(5, SIDE, 1, true);
    let (sites, coords) = (flat(24), random_map(&exemplar, 24));
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| polished(&exemplar, &sites, &coords, Effort::Rounds(1)).0)
    };
    let one = with(1);
    assert_ne!(one, coords);
    assert_eq!(one, with(3));
}

#[test]
fn a_flat_region_lies_as_the_grid_does() {
    let sites = flat(40);
    let links = Links::new(&sites.levels[0], Progress::silent()).unwrap();
    let centre = 20 * 40 + 20;
    let mut places = Places::default();
    let region = Region::round(&links, centre, 6.05, &mut places);
    // As many points of the grid as lie in a circle of radius 6 (A000328).
    assert_eq!(region.sites.len(), 113);
    for (&site, place) in region.sites.iter().zip(&region.places) {
        let (row, col) = ((site / 40) as f32, (site % 40) as f32);
        let off = (place[0] - (col - 20.0)).hypot(place[1] - (20.0 - row));
        assert!(off < 1e-4, "{site}");
    }
    assert_eq!(region, Region::round(&links, centre, 6.05, &mut places));
}

#[test]
fn changes_of_usage_cost_what_the_totals_say() {
    let exemplar = fixtures::random_exemplar(6, SIDE, 1, true);
    let level = ExemplarLevel::new(&exemplar.0, &exemplar.1, 0, exemplar.1.k, false);
    let coords = random_map(&exemplar, 24);
    let mut reuse = ReuseCost::of(&level, &coords);
    let (before, at) = (reuse.total(), reuse.cell_at(coords[0]));
    let changes = [(at, 12.0), (at + 1, -5.0)].into_iter().collect();
    let cost = reuse.cost_of(&changes);
    reuse.change(&changes);
    assert!((reuse.total() - before - cost).abs() < 1e-9);
    // As many sites as texels, each used once, cost nothing.
    let texels = (0..SIDE * SIDE).map(|texel| level.grid.centre(crate::index::TexelIndex(texel)));
    assert_eq!(
        ReuseCost::of(&level, &texels.collect::<Vec<_>>()).total(),
        0.0
    );
}
