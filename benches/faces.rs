//! Textures on the faces of a torus, and the search of one level: the counted tree against a look at every face of
//! the sample. Run with `cargo bench --bench faces`.
#![allow(
    clippy::unwrap_used,
    reason = "a benchmark that cannot be set up must stop"
)]

use divan::Bencher;
use mesotex::mesh::{ColoredMesh, Coloring, Topology, shapes, two_coloring};
use mesotex::progress::Progress;
use mesotex::sites::faces::{FacePyramid, FaceTemplate, SECTORS};
use mesotex::synthesis::recipes::choosy::{
    Choice, ChoosyOptions, ChoosyResult, CountedTree, SourceFaces, SquareImage, distance_ratio,
    synthesize_faces,
};

/// Texels per side of the sample.
const SIDE: u32 = 96;
/// Sites whose searches are measured.
const SITES: usize = 512;

fn main() {
    divan::main();
}

/// Bent stripes with grain.
fn sample() -> Vec<f32> {
    let number = |index: u32| {
        let (texel, channel) = (index / 3, index % 3);
        let turn = std::f32::consts::TAU / SIDE as f32;
        let (x, y) = ((texel % SIDE) as f32 * turn, (texel / SIDE) as f32 * turn);
        let stripes = (5.0 * x + 2.0 * y.sin()).sin() + (3.0 * y + x.cos()).cos();
        let grain = (texel.wrapping_mul(2_654_435_761) >> 24) as f32 / 255.0;
        (0.5 + 0.2 * stripes + 0.1 * grain) / (1.0 + channel as f32)
    };
    (0..SIDE * SIDE * 3).map(number).collect()
}

/// A torus of `around` × `across` squares cut in two, and its subdivisions.
fn torus(around: u32, across: u32, subdivisions: u32) -> FacePyramid {
    let mesh = shapes::torus(around, across, 1.0, 0.4);
    let base = ColoredMesh {
        white: two_coloring(&Topology::new(&mesh.triangles)).unwrap(),
        mesh,
        coloring: Coloring::Given,
    };
    FacePyramid::subdivided(&base, subdivisions, Progress::silent()).unwrap()
}

fn textured(surface: &FacePyramid) -> ChoosyResult {
    let numbers = sample();
    let image = SquareImage {
        side: SIDE,
        channels: 3,
        numbers: &numbers,
    };
    let options = ChoosyOptions::default();
    synthesize_faces(image, surface, &options, Progress::silent()).unwrap()
}

/// 131,072 faces of four levels.
#[divan::bench(sample_count = 1)]
fn faces_131072(bencher: Bencher<'_, '_>) {
    let surface = torus(32, 32, 3);
    bencher.bench(|| textured(&surface));
}

/// 960,512 faces of five levels.
#[divan::bench(sample_count = 1)]
fn faces_960512(bencher: Bencher<'_, '_>) {
    let surface = torus(67, 28, 4);
    bencher.bench(|| textured(&surface));
}

/// Searches of a level that is done, with the uses that it ended with.
struct Searches {
    tree: CountedTree,
    /// A query for each of three phases, site after site.
    queries: Vec<Vec<f32>>,
}

fn searches() -> Searches {
    let surface = torus(32, 32, 3);
    let result = textured(&surface);
    let (level, values) = (&surface.levels[3], &result.pyramid.gaussian[3]);
    let template = FaceTemplate::new();
    let ratio = distance_ratio(level);
    let faces = SourceFaces::new((&result.sample, 3), &template, ratio, 20).unwrap();
    let mut tree = faces.tree();
    for &source in &result.sources {
        tree.count_use(faces.item(source));
    }
    let mut pattern = vec![0.0; faces.length()];
    let mut queries = Vec::with_capacity(SECTORS * SITES);
    for site in (0..level.count()).step_by(level.count() / SITES) {
        let around = template.around(&level.topology, site as u32);
        faces.pattern(values, &around, &mut pattern);
        for _ in 0..SECTORS {
            let mut query = vec![0.0; faces.components().kept()];
            faces.components().project(&pattern, &mut query);
            queries.push(query);
            let part = pattern.len() / SECTORS;
            pattern.rotate_right(part);
        }
    }
    Searches { tree, queries }
}

fn search_with(
    bencher: Bencher<'_, '_>,
    search: impl Fn(&CountedTree, &[f32], u8, &mut Choice) + Sync,
) {
    let Searches { tree, queries } = searches();
    bencher.bench(|| {
        let chosen = queries.chunks(SECTORS).map(|phases| {
            let mut best = Choice::NONE;
            for (phase, query) in phases.iter().enumerate() {
                search(&tree, query, phase as u8, &mut best);
            }
            best.item
        });
        chosen.fold(0, u32::wrapping_add)
    });
}

/// 512 of 131,072 faces, by the tree alone, without a guess to start from.
#[divan::bench(sample_count = 5)]
fn by_tree(bencher: Bencher<'_, '_>) {
    search_with(bencher, CountedTree::search);
}

/// The same 512, by looking at all faces of the sample.
#[divan::bench(sample_count = 5)]
fn by_linear_search(bencher: Bencher<'_, '_>) {
    search_with(bencher, CountedTree::search_all);
}
