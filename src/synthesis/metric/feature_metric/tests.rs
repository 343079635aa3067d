//! The feature metric against a direct sum in double precision.

use ndarray::Array3;
use rand::Rng;

use super::*;
use crate::exemplar::knn_options::KnnOptions;
use crate::exemplar::neighbor_table::{NeighborTable, build};
use crate::exemplar::space::{Features, Space, SpaceLevel};
use crate::format::id::ContentId;
use crate::grid::TexelGrid;
use crate::index::TexelIndex;
use crate::progress::Progress;
use crate::random;
use crate::sites::vertices::VertexSites;
use crate::synthesis::candidates::forward::Candidate;
use crate::synthesis::keep::Preference;
use crate::synthesis::metric::Metric;
use crate::synthesis::tests::fixtures;

struct Case {
    space: Space,
    table: NeighborTable,
    fine: VertexSites,
    states: [Vec<u32>; 2],
}

impl Case {
    /// A random picture of `depth` numbers per texel, and sites that hold its texels.
    fn new(depth: usize, tileable: bool) -> Self {
        let mut stream = random::stream(4, "picture", depth as u32, 0);
        let mut grid = TexelGrid {
            width: 14,
            height: 12,
            tileable,
        };
        let mut levels = Vec::new();
        for _ in 0..2 {
            let sides = (grid.height as usize, grid.width as usize, depth);
            let features =
                Features::Plain(Array3::from_shape_fn(sides, |_| stream.gen_range(0.0..1.0)));
            levels.push(SpaceLevel { grid, features });
            grid = grid.coarser();
        }
        let space = Space {
            levels,
            channels: crate::exemplar::channels::Channels::default(),
            controls: Vec::new(),
            id: ContentId::of_bytes(b"space"),
            texel_mm: None,
            sample: ContentId::of_bytes(b"sample"),
        };
        let options = KnnOptions {
            k: 4,
            neighborhood: 5,
            ..KnnOptions::default()
        };
        let mut fine = fixtures::random_sites(7, 60, 6);
        fine.coarse = Some(fixtures::random_stencils(8, 60, 9));
        let mut state = |texels| (0..60).map(|_| stream.gen_range(0..texels)).collect();
        Self {
            table: build(&space, &options, Progress::silent()).unwrap(),
            states: [state(14 * 12), state(7 * 6)],
            space,
            fine,
        }
    }

    fn neighborhood<'a>(
        &'a self,
        site: usize,
        done: Option<&'a [bool]>,
    ) -> SiteNeighborhood<'a, VertexSites> {
        fixtures::neighborhood_of((&self.fine, site), &self.states, done)
    }

    /// Σ ‖s(p) − t(p)‖² over both windows, sample by sample.
    fn distance(&self, site: &SiteNeighborhood<'_, VertexSites>, texel: u32) -> f64 {
        let neighborhood = &self.table.levels[0].neighborhood;
        let [fine, coarse] = [0, 1].map(|level| &self.space.levels[level]);
        let (texel, parent) = (TexelIndex(texel), fine.grid.parent(TexelIndex(texel)));
        let own = site.own();
        let own = own.map(|(place, value)| apart(fine, value, texel, neighborhood.offsets[place]));
        let above = site.parent().zip(&neighborhood.coarse_offsets);
        let above = above.map(|(value, &offset)| apart(coarse, value, parent, offset));
        own.sum::<f64>() + above.sum::<f64>()
    }
}

fn apart(
    level: &SpaceLevel,
    value: SampleValue<3>,
    texel: TexelIndex,
    [drow, dcol]: [i32; 2],
) -> f64 {
    let there = vector(level, level.grid.offset(texel, drow, dcol));
    let here = match value {
        SampleValue::Default => vector(level, None),
        SampleValue::One(row) => vector(level, Some(TexelIndex(row))),
        SampleValue::Blend(rows, blend) => {
            let vectors = rows.map(|row| vector(level, Some(TexelIndex(row))));
            let number = |at: usize| -> f64 {
                let shares = vectors.iter().zip(blend);
                shares.map(|(v, share)| f64::from(share) * v[at]).sum()
            };
            (0..there.len()).map(number).collect()
        }
    };
    here.iter().zip(&there).map(|(a, b)| (a - b).powi(2)).sum()
}

/// What a texel holds; off the grid the mean.
fn vector(level: &SpaceLevel, texel: Option<TexelIndex>) -> Vec<f64> {
    let Features::Plain(vectors) = &level.features else {
        panic!("vectors expected");
    };
    match texel {
        Some(texel) => {
            let (row, col) = level.grid.row_col(texel);
            let vector = vectors.slice(ndarray::s![row as usize, col as usize, ..]);
            vector.iter().map(|&v| f64::from(v)).collect()
        }
        None => {
            let texels = (0..level.grid.len() as u32).map(|t| vector(level, Some(TexelIndex(t))));
            let sums = texels.reduce(|a, b| a.iter().zip(b).map(|(a, b)| a + b).collect());
            let count = level.grid.len() as f64;
            sums.unwrap().iter().map(|sum| sum / count).collect()
        }
    }
}

#[test]
fn distances_are_the_sums_of_squares_of_the_samples_that_count() {
    let done: Vec<bool> = (0..60).map(|site| site % 7 != 3).collect();
    // 13 and 20 numbers: lines of more blocks than one, vectors of more steps than one.
    for (depth, tileable) in [
        (1, true),
        (3, false),
        (3, true),
        (4, false),
        (13, true),
        (20, false),
    ] {
        let case = Case::new(depth, tileable);
        let exemplar = ExemplarLevel::new(&case.space, &case.table, 0, 4, true);
        let [fine, coarse] = [0, 1].map(|level| Embedding::new(&case.space.levels[level], 1.0));
        let metric = FeatureMetric::new(&exemplar, &fine, Some(&coarse));
        let mut pattern = FeaturePattern::default();
        for (site, texel) in (0..60).zip((0..168).step_by(2)) {
            for done in [None, Some(&done[..])] {
                let read = case.neighborhood(site, done);
                metric.read(&read, &mut pattern);
                let found = metric.distance(&pattern, texel, f64::INFINITY);
                let expected = case.distance(&read, texel);
                assert!(
                    (found - expected).abs() < 1e-5 * expected,
                    "{found} {expected}"
                );
                let above = metric.distance(&pattern, texel, 0.3 * expected);
                assert_eq!(above, f64::INFINITY);
                assert_eq!(metric.distance(&pattern, texel, 1.01 * expected), found);
            }
        }
    }
}

#[test]
fn the_best_of_all_is_the_smallest() {
    let case = Case::new(3, false);
    let exemplar = ExemplarLevel::new(&case.space, &case.table, 0, 4, true);
    let [fine, coarse] = [0, 1].map(|level| Embedding::new(&case.space.levels[level], 1.0));
    let metric = FeatureMetric::new(&exemplar, &fine, Some(&coarse));
    let bounded =
        FeatureMetric::new(&exemplar, &fine, Some(&coarse)).with_projected_windows((3, 0), true);
    let done: Vec<bool> = (0..60).map(|site| site % 7 != 3).collect();
    let mut pattern = FeaturePattern::default();
    let some = Preference {
        coherence: 1.3,
        floor: 0.2,
    };
    for (site, done) in (0..60).flat_map(|site| [(site, None), (site, Some(&done[..]))]) {
        metric.read(&case.neighborhood(site, done), &mut pattern);
        let coherent = [Candidate {
            texel: exemplar.whole_texels[site % exemplar.whole_texels.len()],
            factor: 1.0,
        }];
        let score = |texel: u32| {
            let factor = if texel == coherent[0].texel {
                1.0
            } else {
                some.coherence
            };
            factor * (metric.distance(&pattern, texel, f64::INFINITY) + some.floor)
        };
        let whole = exemplar.whole_texels.iter();
        let best = whole
            .map(|&texel| score(texel))
            .fold(f64::INFINITY, f64::min);
        for metric in [&metric, &bounded] {
            let pick = metric
                .best_of_all(&mut pattern.clone(), &coherent, some)
                .unwrap();
            assert_eq!((pick.score, score(pick.texel)), (best, best));
        }
    }
}
