//! Synthesis alone, on a flat torus of sites: how its cost grows with sites (10k to 1M) and with the
//! side of the sample (32 to 256), 4 levels and k 11 throughout. Run with
//! `cargo bench --bench synthesis`.
#![allow(
    clippy::unwrap_used,
    reason = "a benchmark that cannot be set up must stop"
)]

use divan::Bencher;
use mesotex::exemplar::neighbor_table::NeighborTable;
use mesotex::exemplar::{
    ChannelImage, ChannelKind, Controls, KnnOptions, Space, neighbor_table, space_of_images,
};
use mesotex::format::ContentId;
use mesotex::format::image::{Encoding, FloatImage, Precision};
use mesotex::progress::Progress;
use mesotex::sites::SiteGrid;
use mesotex::synthesis::{
    CandidateSearch, Inputs, KCoherenceOptions, SynthesisOptions, synthesize,
};

fn main() {
    divan::main();
}

/// A tileable picture of bent stripes with spots, and its table.
fn exemplar(side: u32) -> (Space, NeighborTable) {
    let turn = std::f32::consts::TAU / side as f32;
    let number = |index: u32| {
        let (texel, channel) = (index / 3, index % 3);
        let (x, y) = ((texel % side) as f32 * turn, (texel / side) as f32 * turn);
        let stripes = (5.0 * x + 2.0 * y.sin()).sin() + (3.0 * y + x.cos()).cos();
        let grain = (texel.wrapping_mul(2_654_435_761) >> 24) as f32 / 255.0;
        (0.5 + 0.2 * stripes + 0.1 * grain) / (1.0 + channel as f32)
    };
    let image = FloatImage {
        width: side,
        height: side,
        channels: 3,
        data: (0..side * side * 3).map(number).collect(),
        encoding: Encoding::Srgb,
        precision: Precision::Float,
    };
    let color = ChannelImage {
        name: "color".into(),
        kind: ChannelKind::Color,
        weight: 1.0,
        image,
    };
    let levels = if side < 64 { 3 } else { 4 };
    let id = ContentId::of_bytes(b"bench");
    let space = space_of_images(&[color], Controls::default(), levels, true, &id).unwrap();
    let table = neighbor_table::build(&space, &KnnOptions::default(), Progress::silent()).unwrap();
    (space, table)
}

fn run(bencher: Bencher<'_, '_>, side: u32, sites: u32, search: CandidateSearch) {
    let (space, table) = exemplar(side);
    let target = SiteGrid {
        width: sites,
        height: sites,
        toroidal: true,
    };
    let neighborhoods: Vec<_> = table
        .levels
        .iter()
        .map(|l| l.neighborhood.clone())
        .collect();
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
            ..KCoherenceOptions::default()
        },
        ..SynthesisOptions::default()
    };
    bencher
        .bench(|| synthesize(inputs, &options, None, &mut |_| Ok(()), Progress::silent()).unwrap());
}

/// Sites: 10k, 65k, 250k, 1M; sample 64×64.
#[divan::bench(args = [104, 256, 504, 1000], sample_count = 3)]
fn sites(bencher: Bencher<'_, '_>, side_of_target: u32) {
    run(bencher, 64, side_of_target, CandidateSearch::KCoherence);
}

/// Sides of the sample; 65k sites.
#[divan::bench(args = [32, 64, 128, 256], sample_count = 3)]
fn sample(bencher: Bencher<'_, '_>, side: u32) {
    run(bencher, side, 256, CandidateSearch::KCoherence);
}

/// Full search, exact; 25k sites.
#[divan::bench(args = [64, 128], sample_count = 3)]
fn full_search(bencher: Bencher<'_, '_>, side: u32) {
    run(bencher, side, 160, CandidateSearch::Full);
}
