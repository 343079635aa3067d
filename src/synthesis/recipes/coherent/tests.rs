//! Coherent synthesis against a slow replay, and a texture whose continuation is known.

use ndarray::Array3;

use super::*;
use crate::exemplar::channels::Channels;
use crate::exemplar::space::{Features, Space, SpaceLevel};
use crate::format::id::ContentId;
use crate::grid::TexelGrid;
use crate::mesh::compressed_rows::Rows;
use crate::neighborhood::Neighborhood;
use crate::sites::grid::window::SiteGrid;
use crate::sites::level::SiteHierarchy;
use crate::sites::vertices::VertexSites;
use crate::synthesis::all_levels::synthesize;
use crate::synthesis::options::Method;
use crate::synthesis::tests::fixtures;

/// A plain image of some numbers per texel.
fn picture(grid: TexelGrid, numbers: usize, value: impl Fn(u32, u32, usize) -> f32) -> Space {
    let size = (grid.height as usize, grid.width as usize, numbers);
    let features = Array3::from_shape_fn(size, |(row, col, number)| {
        value(row as u32, col as u32, number)
    });
    Space {
        levels: vec![SpaceLevel {
            grid,
            features: Features::Plain(features),
        }],
        channels: Channels::default(),
        controls: Vec::new(),
        id: ContentId::of_bytes(b"space"),
        texel_mm: None,
        sample: ContentId::of_bytes(b"sample"),
    }
}

fn grid(width: u32, height: u32, tileable: bool) -> TexelGrid {
    TexelGrid {
        width,
        height,
        tileable,
    }
}

fn run<const N: usize, S: Sites<N>>(
    space: &Space,
    sites: &SiteHierarchy<S>,
    seed: u64,
) -> Vec<TexCoord> {
    // Its lists are not read.
    let (_, table) = fixtures::random_exemplar(1, 8, 1, true);
    let inputs = Inputs {
        space,
        table: &table,
        sites,
        controls: None,
    };
    let options = SynthesisOptions {
        method: Method::Coherent,
        spectrum: 1.0,
        seed,
        ..SynthesisOptions::default()
    };
    let progress = Progress::silent();
    let map = synthesize(inputs, &options, None, &mut |_| Ok(()), progress);
    map.unwrap().coords
}

fn flat(width: u32, height: u32, toroidal: bool) -> SiteHierarchy<crate::sites::grid::GridSites> {
    let target = SiteGrid {
        width,
        height,
        toroidal,
    };
    target.hierarchy(&[Neighborhood::square(5, 0)]).unwrap()
}

#[test]
fn a_checkerboard_is_continued_without_error() {
    let exemplar = grid(8, 4, true);
    let space = picture(exemplar, 1, |row, col, _| ((row / 2 + col / 2) % 2) as f32);
    for seed in 0..4 {
        let coords = run(&space, &flat(32, 20, seed % 2 == 0), seed);
        let color = |at: TexCoord| {
            let (row, col) = exemplar.row_col(exemplar.texel_nearest(at));
            (row / 2 + col / 2) % 2
        };
        let (row, col) = exemplar.row_col(exemplar.texel_nearest(coords[0]));
        for (site, &at) in coords.iter().enumerate() {
            let (row, col) = (row + site as u32 / 32, col + site as u32 % 32);
            assert_eq!(color(at), (row / 2 + col / 2) % 2, "{site}");
            assert_eq!(at, exemplar.centre(exemplar.texel_nearest(at)));
        }
    }
}

/// The exemplar's value at a coordinate, from the definition of bilinear interpolation; `None` off it.
fn value_at(space: &Space, at: [f64; 2]) -> Option<Vec<f64>> {
    let (grid, Features::Plain(vectors)) = (space.levels[0].grid, &space.levels[0].features) else {
        panic!("vectors expected");
    };
    let (width, height) = (f64::from(grid.width), f64::from(grid.height));
    let [s, t] = at;
    let is_on = (0.0..width).contains(&s) && t > 0.0 && t <= height;
    if !is_on && !grid.tileable {
        return None;
    }
    let mut value = vec![0.0; vectors.dim().2];
    for row in -6..i64::from(grid.height) + 6 {
        for col in -6..i64::from(grid.width) + 6 {
            let [right, down] = [s - 0.5 - col as f64, height - t - 0.5 - row as f64];
            let weight = (1.0 - right.abs()).max(0.0) * (1.0 - down.abs()).max(0.0);
            let place = |at: i64, side: u32| match grid.tileable {
                true => at.rem_euclid(i64::from(side)) as usize,
                false => at.clamp(0, i64::from(side) - 1) as usize,
            };
            let (row, col) = (place(row, grid.height), place(col, grid.width));
            for (number, sum) in value.iter_mut().enumerate() {
                *sum += weight * f64::from(vectors[(row, col, number)]);
            }
        }
    }
    Some(value)
}

/// Replays a finished map in its order: every site holds the best candidate, or a texel where there is none.
fn check<const N: usize, S: Sites<N>>(space: &Space, sites: &S, coords: &[TexCoord], seed: u64) {
    let mut stream = random::stream(seed, "growth start", 0, 0);
    let order = one_pass_order(
        sites,
        stream.gen_range(0..sites.count()),
        Progress::silent(),
    )
    .unwrap();
    let exemplar = space.levels[0].grid;
    let mut done = vec![false; sites.count()];
    let (mut compared, mut begun) = (0, 0);
    for site in order {
        let near: Vec<Neighbor> = sites
            .neighbors(site as usize)
            .filter(|near| done[near.site as usize])
            .collect();
        let place = |near: &Neighbor| {
            let at = coords[near.site as usize];
            [
                f64::from(at.s) - f64::from(near.x),
                f64::from(at.t) - f64::from(near.y),
            ]
        };
        let distance = |at: [f64; 2]| {
            let (mut sum, mut count) = (0.0, 0.0);
            for neighbor in &near {
                let there = [at[0] + f64::from(neighbor.x), at[1] + f64::from(neighbor.y)];
                let held = coords[neighbor.site as usize];
                let held = value_at(space, [held.s, held.t].map(f64::from)).unwrap();
                if let Some(read) = value_at(space, there) {
                    count += 1.0;
                    sum += read
                        .iter()
                        .zip(held)
                        .map(|(a, b)| (a - b).powi(2))
                        .sum::<f64>();
                }
            }
            sum / count
        };
        let candidates: Vec<[f64; 2]> = near
            .iter()
            .map(place)
            .filter(|&at| value_at(space, at).is_some())
            .collect();
        let held = coords[site as usize];
        if candidates.is_empty() {
            begun += 1;
            assert_eq!(held, exemplar.centre(exemplar.texel_nearest(held)));
        } else {
            compared += usize::from(candidates.len() > 1);
            let least = candidates.iter().map(|&at| distance(at));
            let least = least.fold(f64::INFINITY, f64::min);
            let found = distance([held.s, held.t].map(f64::from));
            assert!(found <= least + 1e-4, "{site}: {found} {least}");
            let is_candidate = candidates.iter().any(|&[s, t]| {
                let at = TexCoord {
                    s: s as f32,
                    t: t as f32,
                };
                let (ds, dt) = exemplar.difference(held, at);
                ds.abs().max(dt.abs()) < 1e-4
            });
            assert!(is_candidate, "{site}: {held:?} {candidates:?}");
        }
        done[site as usize] = true;
    }
    assert!(
        begun > 0 && compared > sites.count() / 3,
        "{begun} {compared}"
    );
}

/// Sites that have the four before and after them as neighbours, at any places, as on a surface.
fn sites_in_a_ring(seed: u64, count: u32) -> VertexSites {
    let mut stream = random::stream(seed, "ring", 0, 0);
    let mut neighbors = Rows::<Neighbor>::default();
    neighbors.starts.push(0);
    for site in 0..count {
        for step in [1, 2, 3, 4, count - 4, count - 3, count - 2, count - 1] {
            neighbors.entries.push(Neighbor {
                site: (site + step) % count,
                x: stream.gen_range(-2.0..2.0),
                y: stream.gen_range(-2.0..2.0),
            });
        }
        neighbors.starts.push(neighbors.entries.len() as u32);
    }
    VertexSites {
        neighbors,
        areas: vec![1.0; count as usize],
        ..VertexSites::default()
    }
}

#[test]
fn every_site_takes_the_best_continuation() {
    for (seed, tileable) in [(1, false), (2, true), (3, false)] {
        let mut stream = random::stream(seed, "picture", 0, 0);
        let numbers: Vec<f32> = (0..6 * 7 * 3).map(|_| stream.gen_range(0.0..1.0)).collect();
        let space = picture(grid(7, 6, tileable), 3, |row, col, number| {
            numbers[(7 * row as usize + col as usize) * 3 + number]
        });
        let sites = SiteHierarchy {
            levels: vec![sites_in_a_ring(seed, 144)],
        };
        check(&space, &sites.levels[0], &run(&space, &sites, seed), seed);
        // Of a tile that is continued everywhere a grid has one candidate per site.
        if !tileable {
            let sites = flat(12, 12, true);
            check(&space, &sites.levels[0], &run(&space, &sites, seed), seed);
        }
    }
}

#[test]
fn textons_are_compared_by_their_vectors() {
    let (space, _) = fixtures::random_exemplar(5, 12, 1, false);
    let sites = flat(24, 24, false);
    let coords = run(&space, &sites, 4);
    let exemplar = space.levels[0].grid;
    assert!(
        coords
            .iter()
            .all(|&at| exemplar.texel_holding(at).is_some())
    );
    // Patches: most sites continue from the one on their left.
    let goes_on = |site: &usize| {
        let (ds, dt) = exemplar.difference(coords[site - 1], coords[*site]);
        (ds - 1.0).abs() < 1e-3 && dt.abs() < 1e-3
    };
    let going_on = (0..576)
        .filter(|site| site % 24 > 0)
        .filter(goes_on)
        .count();
    assert!(going_on > 420, "{going_on}");
    assert_eq!(coords, run(&space, &sites, 4));
    assert_ne!(coords, run(&space, &sites, 5));
}
