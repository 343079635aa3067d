//! The neighbour table: two levels, 400 and 100 textons, k 11, windows 7×7 and 3×3.

use mesotex::exemplar::neighbor_table::build;
use mesotex::exemplar::{Features, KnnOptions, NeighborSearch, Space, SpaceLevel};
use mesotex::format::ContentId;
use mesotex::grid::TexelGrid;
use mesotex::progress::Progress;
use mesotex::random::stream;
use ndarray::Array2;
use rand::Rng;

fn main() {
    divan::main();
}

fn level(side: u32, textons: usize) -> SpaceLevel {
    let mut random = stream(1, "space", side, 0);
    let points = Array2::from_shape_fn((textons + 1, 16), |_| random.gen_range(-1.0_f32..1.0));
    SpaceLevel {
        grid: TexelGrid {
            width: side,
            height: side,
            tileable: true,
        },
        features: Features::Textons {
            labels: (0..side * side)
                .map(|_| random.gen_range(0..textons as u16))
                .collect(),
            gram: points.dot(&points.t()),
        },
    }
}

fn space(side: u32) -> Space {
    Space {
        levels: vec![level(side, 400), level(side / 2, 100)],
        channels: mesotex::exemplar::Channels::default(),
        controls: Vec::new(),
        id: ContentId::of_bytes(b"space"),
        texel_mm: None,
        sample: ContentId::of_bytes(b"sample"),
    }
}

fn bench(bencher: divan::Bencher<'_, '_>, side: u32, search: NeighborSearch) {
    let (space, options) = (
        space(side),
        KnnOptions {
            search,
            ..KnnOptions::default()
        },
    );
    bencher.bench(|| build(&space, &options, Progress::silent()).is_ok());
}

#[divan::bench(args = [64, 128], sample_count = 3)]
fn exact(bencher: divan::Bencher<'_, '_>, side: u32) {
    bench(bencher, side, NeighborSearch::Exact);
}

#[divan::bench(args = [64, 128], sample_count = 3)]
fn two_level(bencher: divan::Bencher<'_, '_>, side: u32) {
    bench(bencher, side, NeighborSearch::TwoLevel);
}
