//! Small exemplars and targets for tests: random, but with the structure real ones have.

use ndarray::Array2;
use rand::Rng;

use crate::exemplar::margin::Margin;
use crate::exemplar::neighbor_table::{NeighborTable, TableLevel};
use crate::exemplar::space::{Features, Space, SpaceLevel};
use crate::format::id::ContentId;
use crate::grid::TexelGrid;
use crate::index::TexelIndex;
use crate::mesh::compressed_rows::Rows;
use crate::neighborhood::Neighborhood;
use crate::random::{self, Stream};
use crate::sites::level::Neighbor;
use crate::sites::vertices::VertexSites;
use crate::sites::vertices::stencil::{PackedSample, PatchStencils};
use crate::synthesis::metric::site_values::{SiteNeighborhood, Unfinished};

/// The square window of width `fine`, and of width `coarse` on the parent level; weights 1.
pub fn square_neighborhood(fine: u32, coarse: Option<u32>) -> Neighborhood {
    Neighborhood::square(fine, coarse.unwrap_or(0))
}

/// What surrounds a site of two levels, whose sites hold `states`; `done` says which of them are finished.
pub fn neighborhood_of<'a>(
    (sites, site): (&'a VertexSites, usize),
    states: &'a [Vec<u32>; 2],
    done: Option<&'a [bool]>,
) -> SiteNeighborhood<'a, VertexSites> {
    SiteNeighborhood {
        site,
        sites,
        rows: &states[0],
        done,
        unfinished: Unfinished::LeftOut,
        coarser: Some(&states[1]),
    }
}

/// Φ of `textons` random vectors of `dimensions` numbers, and of their mean.
pub fn random_gram(seed: u64, textons: usize, dimensions: usize) -> Array2<f32> {
    let mut stream = random::stream(seed, "gram", 0, 0);
    let mut vectors = Array2::from_shape_fn((textons + 1, dimensions), |(_, dimension)| {
        // A decaying spectrum and a common mean, as textons have.
        (stream.gen_range(-1.0..1.0) + 0.3) / (1.0 + 0.2 * dimension as f64)
    });
    for dimension in 0..dimensions {
        vectors[(textons, dimension)] = 0.0;
        vectors[(textons, dimension)] = vectors.column(dimension).sum() / textons as f64;
    }
    vectors.dot(&vectors.t()).mapv(|dot| dot as f32)
}

/// A square exemplar of textons with smooth structure, window 5 and 3, and its exact neighbour
/// table with k 4.
pub fn random_exemplar(
    seed: u64,
    side: u32,
    levels: usize,
    tileable: bool,
) -> (Space, NeighborTable) {
    let mut space = Space {
        levels: Vec::new(),
        channels: crate::exemplar::channels::Channels::default(),
        controls: Vec::new(),
        id: ContentId::of_bytes(b"space"),
        texel_mm: None,
        sample: ContentId::of_bytes(b"sample"),
    };
    let mut grid = TexelGrid {
        width: side,
        height: side,
        tileable,
    };
    for level in 0..levels {
        let textons = (24 >> level).max(4);
        let mut stream = random::stream(seed, "labels", level as u32, 0);
        space.levels.push(SpaceLevel {
            grid,
            features: Features::Textons {
                labels: smooth_labels(grid, textons as u16, &mut stream),
                gram: random_gram(seed + level as u64, textons, 40),
            },
        });
        grid = grid.coarser();
    }
    let table = exact_table(&space, 4);
    (space, table)
}

/// Labels in soft stripes and spots.
fn smooth_labels(grid: TexelGrid, textons: u16, stream: &mut Stream) -> Vec<u16> {
    let phase: f64 = stream.gen_range(0.0..6.0);
    let texels = 0..grid.len() as u32;
    texels
        .map(|texel| {
            let (row, col) = grid.row_col(TexelIndex(texel));
            let turn = std::f64::consts::TAU / f64::from(grid.width);
            let (x, y) = (f64::from(col) * turn, f64::from(row) * turn);
            let wave = (x + phase).sin() + (2.0 * y - x).cos() + stream.gen_range(-0.5..0.5);
            (((wave + 2.5) / 5.0) * f64::from(textons)) as u16
        })
        .collect()
}

/// The neighbour table by brute force, without separation.
pub fn exact_table(space: &Space, k: usize) -> NeighborTable {
    let count = space.levels.len();
    let level = |index: usize| {
        let two_level = index + 1 < count;
        let neighborhood = square_neighborhood(5, two_level.then_some(3));
        table_level(space, index, neighborhood, k)
    };
    NeighborTable {
        levels: (0..count).map(level).collect(),
        k,
        tileable: space.levels[0].grid.tileable,
        margin: Margin::Full,
        transition_tolerance: None,
        id: ContentId::of_bytes(b"table"),
        space: space.id.clone(),
    }
}

fn table_level(space: &Space, index: usize, neighborhood: Neighborhood, k: usize) -> TableLevel {
    let grid = space.levels[index].grid;
    let fits = |texel| neighborhood.fits(grid, texel);
    let whole = Margin::Full.whole_texels(grid, k, fits);
    let (mut neighbors, mut distances) = (Vec::new(), Vec::new());
    for texel in 0..grid.len() as u32 {
        let mut list: Vec<(f64, u32)> = (0..grid.len() as u32)
            .filter(|&other| other != texel && whole[other as usize])
            .map(|other| {
                let at = |t| window_distance(space, index, &neighborhood, t);
                (at((texel, other)), other)
            })
            .collect();
        list.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        list.insert(0, (0.0, texel));
        neighbors.extend(list[..k].iter().map(|&(_, texel)| texel));
        distances.extend(list[..k].iter().map(|&(distance, _)| distance as f32));
    }
    TableLevel {
        neighbors: Array2::from_shape_vec((grid.len(), k), neighbors).unwrap(),
        distances: Array2::from_shape_vec((grid.len(), k), distances).unwrap(),
        neighborhood,
        min_separation: 1,
    }
}

/// The neighbourhood distance of two texels, literally.
pub fn window_distance(
    space: &Space,
    index: usize,
    neighborhood: &Neighborhood,
    (a, b): (u32, u32),
) -> f64 {
    let level = &space.levels[index];
    let fine = neighborhood.offsets.iter().zip(&neighborhood.weights);
    let mut sum: f64 = fine
        .map(|(&offset, &weight)| f64::from(weight) * label_distance(level, a, b, offset))
        .sum();
    if let Some(coarser) = space.levels.get(index + 1) {
        let parent = |texel| level.grid.parent(TexelIndex(texel)).0;
        let coarse = neighborhood.coarse_offsets.iter();
        let coarse = coarse.zip(&neighborhood.coarse_weights);
        sum += coarse
            .map(|(&offset, &weight)| {
                f64::from(weight) * label_distance(coarser, parent(a), parent(b), offset)
            })
            .sum::<f64>();
    }
    sum
}

fn label_distance(level: &SpaceLevel, a: u32, b: u32, [drow, dcol]: [i32; 2]) -> f64 {
    let Features::Textons { labels, gram } = &level.features else {
        panic!("textons expected");
    };
    let label = |texel| {
        let there = level.grid.offset(TexelIndex(texel), drow, dcol);
        there.map_or(gram.nrows() - 1, |t| usize::from(labels[t.index()]))
    };
    let (i, j) = (label(a), label(b));
    let phi = |i, j| f64::from(gram[(i, j)]);
    phi(i, i) - 2.0 * phi(i, j) + phi(j, j)
}

/// Random stencils of `per_site` samples at as many sites.
pub fn random_stencils(seed: u64, count: u32, per_site: u32) -> PatchStencils {
    let mut stream = random::stream(seed, "stencils", 0, 0);
    let cells: Vec<[u32; 3]> = (0..2 * count)
        .map(|_| [0; 3].map(|_| stream.gen_range(0..count)))
        .collect();
    let samples = (0..per_site * count).map(|_| match stream.gen_range(0..8) {
        0 => PackedSample::OUTSIDE,
        1 => PackedSample::new(stream.gen_range(0..2 * count), [1.0, 0.0, 0.0]),
        _ => PackedSample::new(
            stream.gen_range(0..2 * count),
            [0.0; 3].map(|_: f32| stream.gen_range(0.0..1.0)),
        ),
    });
    let samples = samples.collect();
    PatchStencils {
        samples_per_site: per_site as usize,
        cells,
        samples,
    }
}

/// Sites with random stencils of the 5×5 window and `near` random neighbours each.
pub fn random_sites(seed: u64, count: u32, near: u32) -> VertexSites {
    let mut stream = random::stream(seed, "sites", 0, 0);
    let mut lists = Rows::<Neighbor>::default();
    lists.starts.push(0);
    for site in 0..count {
        for step in 1..=near {
            lists.entries.push(Neighbor {
                site: (site + step) % count,
                x: stream.gen_range(-2.5..2.5),
                y: stream.gen_range(-2.5..2.5),
            });
        }
        lists.starts.push(lists.entries.len() as u32);
    }
    VertexSites {
        fine: random_stencils(seed, count, 25),
        coarse: None,
        neighbors: lists,
        parents: Vec::new(),
        areas: vec![1.0; count as usize],
    }
}
