//! The table against a slow oracle in `f64`.

use ndarray::Array3;
use rand::Rng;

use super::*;
use crate::exemplar::channels::Channels;
use crate::exemplar::space::{Features, SpaceLevel};
use crate::random::stream;

fn random_space(width: u32, height: u32, tileable: bool, levels: usize, plain: bool) -> Space {
    let mut random = stream(3, "space", width, u64::from(height));
    let mut grid = TexelGrid {
        width,
        height,
        tileable,
    };
    let mut made = Vec::new();
    for _ in 0..levels {
        let features = if plain {
            let sides = (grid.height as usize, grid.width as usize, 3);
            Features::Plain(Array3::from_shape_fn(sides, |_| random.gen_range(0.0..1.0)))
        } else {
            let points = Array2::from_shape_fn((7, 4), |_| random.gen_range(-1.0_f32..1.0));
            Features::Textons {
                labels: (0..grid.len()).map(|_| random.gen_range(0..6)).collect(),
                gram: points.dot(&points.t()),
            }
        };
        made.push(SpaceLevel { grid, features });
        grid = grid.coarser();
    }
    Space {
        levels: made,
        channels: Channels::default(),
        controls: Vec::new(),
        id: ContentId::of_bytes(b"x"),
        texel_mm: None,
        sample: ContentId::of_bytes(b"s"),
    }
}

/// d² of what stands at two places, `None` being the default.
fn feature_distance(level: &SpaceLevel, a: Option<TexelIndex>, b: Option<TexelIndex>) -> f64 {
    match &level.features {
        Features::Textons { labels, gram } => {
            let label =
                |t: Option<TexelIndex>| t.map_or(gram.nrows() - 1, |t| labels[t.index()] as usize);
            let (a, b) = (label(a), label(b));
            let at = |i, j| f64::from(gram[[i, j]]);
            (at(a, a) + at(b, b) - 2.0 * at(a, b)).max(0.0)
        }
        Features::Plain(features) => {
            let vector = |t: Option<TexelIndex>| match t {
                Some(t) => {
                    let (row, col) = level.grid.row_col(t);
                    (0..3)
                        .map(|d| features[[row as usize, col as usize, d]])
                        .collect()
                }
                None => level.default_feature(),
            };
            let pairs = vector(a).into_iter().zip(vector(b));
            pairs.map(|(a, b)| f64::from(a - b).powi(2)).sum()
        }
    }
}

fn window_distance(
    space: &Space,
    at: usize,
    n: &Neighborhood,
    p: TexelIndex,
    q: TexelIndex,
) -> f64 {
    let sum = |level: &SpaceLevel, p, q, offsets: &[[i32; 2]]| -> f64 {
        let one = |&[drow, dcol]: &[i32; 2]| {
            let (a, b) = (
                level.grid.offset(p, drow, dcol),
                level.grid.offset(q, drow, dcol),
            );
            feature_distance(level, a, b)
        };
        offsets.iter().map(one).sum()
    };
    let level = &space.levels[at];
    let fine = sum(level, p, q, &n.offsets);
    if n.coarse_offsets.is_empty() {
        return fine;
    }
    let (p, q) = (level.grid.parent(p), level.grid.parent(q));
    fine + sum(&space.levels[at + 1], p, q, &n.coarse_offsets)
}

fn separated(grid: TexelGrid, a: TexelIndex, b: TexelIndex, least: u32) -> bool {
    let ((ra, ca), (rb, cb)) = (grid.row_col(a), grid.row_col(b));
    let along = |a: u32, b: u32, side: u32| {
        let d = a.abs_diff(b);
        if grid.tileable { d.min(side - d) } else { d }
    };
    along(ra, rb, grid.height).max(along(ca, cb, grid.width)) >= least
}

/// Checks every row: greedy by (distance, index) to f32 rounding.
fn check(space: &Space, options: &KnnOptions) {
    let table = build(space, options, Progress::silent()).unwrap();
    for (at, level) in table.levels.iter().enumerate() {
        let grid = space.levels[at].grid;
        let n = &level.neighborhood;
        let whole = table.whole_texels(at, grid);
        for p in (0..grid.len() as u32).map(TexelIndex) {
            let row = level.neighbors.row(p.index());
            assert_eq!(row[0], p.0);
            let mut open: Vec<(f64, TexelIndex)> = (0..grid.len() as u32)
                .map(TexelIndex)
                .filter(|q| whole[q.index()] && *q != p)
                .map(|q| (window_distance(space, at, n, p, q), q))
                .collect();
            let mut taken = p;
            for column in 1..row.len() {
                open.retain(|(_, q)| separated(grid, taken, *q, level.min_separation));
                let least = open.iter().map(|(d, _)| *d).fold(f64::INFINITY, f64::min);
                taken = TexelIndex(row[column]);
                let found = open.iter().find(|(_, q)| *q == taken).map(|(d, _)| *d);
                let found = found.expect("a whole texel, separated from all taken");
                assert!(
                    found <= least * (1.0 + 1e-5) + 1e-9,
                    "{found} against {least}"
                );
                let listed = f64::from(level.distances[[p.index(), column]]);
                assert!((listed - found).abs() <= 1e-5 * found + 1e-9);
            }
        }
    }
}

#[test]
fn tables_are_brute_force_for_textons_and_vectors_at_both_borders() {
    for (width, height, tileable) in [(16, 12, true), (17, 13, false)] {
        for plain in [false, true] {
            let space = random_space(width, height, tileable, 2, plain);
            let options = KnnOptions {
                k: 5,
                neighborhood: 5,
                ..KnnOptions::default()
            };
            check(&space, &options);
            check(
                &space,
                &KnnOptions {
                    min_separation: Some(3),
                    k: 3,
                    margin: Margin::Full,
                    ..options
                },
            );
        }
    }
}

#[test]
fn a_window_wider_than_the_level_wraps_or_falls_off() {
    check(
        &random_space(8, 4, true, 1, false),
        &KnnOptions {
            k: 3,
            ..KnnOptions::default()
        },
    );
    // No texel is whole under a 7×7 window here, so every one counts as whole.
    check(
        &random_space(6, 6, false, 1, false),
        &KnnOptions {
            k: 3,
            margin: Margin::Full,
            ..KnnOptions::default()
        },
    );
}

#[test]
fn windows_of_every_width_are_brute_force() {
    for (neighborhood, tileable) in [(1, true), (3, false), (9, true), (9, false)] {
        let options = KnnOptions {
            k: 3,
            neighborhood,
            ..KnnOptions::default()
        };
        check(&random_space(12, 10, tileable, 1, true), &options);
    }
}

#[test]
fn whole_texels_have_all_samples_on_both_grids() {
    let grid = TexelGrid {
        width: 20,
        height: 17,
        tileable: false,
    };
    let n = Neighborhood::square(7, 3);
    let full = |grid, k| Margin::Full.whole_texels(grid, k, |texel| n.fits(grid, texel));
    let whole = full(grid, 11);
    // Rows 3 to 13 for the fine window; the parent's rows 1 to 7 of 9, so rows 2 to 15.
    for (texel, &whole) in whole.iter().enumerate() {
        let (row, col) = (texel / 20, texel % 20);
        assert_eq!(whole, (3..14).contains(&row) && (3..17).contains(&col));
    }
    assert!(
        full(
            TexelGrid {
                tileable: true,
                ..grid
            },
            11
        )
        .iter()
        .all(|&w| w)
    );
    assert!(full(grid, 155).iter().all(|&w| w));
}

#[test]
fn margins_are_kept_and_tables_without_one_have_whole_windows() {
    let space = random_space(12, 9, false, 1, false);
    let table = build(&space, &KnnOptions::default(), Progress::silent()).unwrap();
    let whole = table.whole_texels(0, space.levels[0].grid);
    for (texel, &whole) in whole.iter().enumerate() {
        let (row, col) = (texel / 12, texel % 12);
        assert_eq!(whole, (1..8).contains(&row) && (1..11).contains(&col));
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.knn.npz");
    let mut written = table;
    written.write(&path, &KnnOptions::default()).unwrap();
    let mut file = npz::Reader::open(&path).unwrap();
    let mut meta: Value = file.meta().unwrap();
    assert_eq!(meta["margin"], 1);
    meta.as_object_mut().unwrap().remove("margin");
    let earlier: Meta = serde_json::from_value(meta).unwrap();
    assert_eq!(earlier.margin, Margin::Full);
    let too_wide = KnnOptions {
        margin: Margin::Texels(5),
        ..KnnOptions::default()
    };
    let error = build(&space, &too_wide, Progress::silent()).unwrap_err();
    assert!(error.to_string().contains("margin"), "{error}");
}

#[test]
fn too_few_neighbours_name_the_level() {
    let space = random_space(8, 8, true, 2, false);
    let options = KnnOptions {
        k: 17,
        ..KnnOptions::default()
    };
    let error = build(&space, &options, Progress::silent())
        .unwrap_err()
        .to_string();
    assert!(error.contains("level 1") && error.contains("16"), "{error}");
}

#[test]
fn tables_round_trip() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.knn.npz");
    let space = random_space(8, 6, true, 2, false);
    let options = KnnOptions {
        k: 3,
        ..KnnOptions::default()
    };
    let mut table = build(&space, &options, Progress::silent()).unwrap();
    table.write(&path, &options).unwrap();
    let back = NeighborTable::read(&path).unwrap();
    assert_eq!(back, table);
    back.check_belongs_to(&space, false).unwrap();
    let other = random_space(8, 8, true, 2, false);
    assert!(back.check_belongs_to(&other, true).is_err());
    let mut renamed = space.clone();
    renamed.id = ContentId::of_bytes(b"other");
    assert!(back.check_belongs_to(&renamed, false).is_err());
    back.check_belongs_to(&renamed, true).unwrap();
}

#[test]
fn threads_do_not_change_a_bit() {
    let space = random_space(16, 16, false, 3, false);
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        let options = KnnOptions {
            k: 4,
            ..KnnOptions::default()
        };
        pool.install(|| build(&space, &options, Progress::silent()).unwrap())
    };
    assert_eq!(with(1), with(8));
}

#[test]
fn two_level_search_is_exact_when_every_parent_is_a_candidate() {
    for tileable in [true, false] {
        let space = random_space(16, 14 + 2 * u32::from(tileable), tileable, 2, false);
        let exact = KnnOptions {
            k: 5,
            neighborhood: 3,
            ..KnnOptions::default()
        };
        let all = KnnOptions {
            search: NeighborSearch::TwoLevel,
            candidates: 64,
            ..exact.clone()
        };
        let (table, searches) = build_and_measure(&space, &all, Progress::silent()).unwrap();
        assert_eq!(
            searches[0],
            LevelSearch {
                search: NeighborSearch::TwoLevel,
                recall: 1.0
            }
        );
        assert_eq!(searches[1].search, NeighborSearch::Exact);
        let expected = build(&space, &exact, Progress::silent()).unwrap();
        assert_eq!(table.levels[0].neighbors, expected.levels[0].neighbors);
        let few = KnnOptions {
            candidates: 3,
            ..all
        };
        let (_, searches) = build_and_measure(&space, &few, Progress::silent()).unwrap();
        assert!(searches[0].recall < 1.0);
    }
}
