//! Windows of texels resampled at any positions: round, rotated, scaled. Computed once per exemplar (Chen 2008 §5.3).
//!
//! In: a vector per texel of a level and a template, which every texel may turn by its own angle (Zhang 2003
//! §5). Out: for every texel the numbers of its samples one after the other, so that the first rings of a
//! neighbourhood are a prefix.

use glam::Vec2;
use rayon::prelude::*;

use crate::exemplar::embedding::Embedding;
use crate::exemplar::level::{default_row, feature_rows};
use crate::exemplar::margin::Margin;
use crate::exemplar::space::SpaceLevel;
use crate::grid::TexelGrid;
use crate::index::TexelIndex;
use crate::neighborhood::Template;

/// Texels resampled by one task.
const CHUNK: usize = 256;

/// The resampled windows of a level.
#[derive(Clone, Debug)]
pub struct DenseWindows {
    /// Numbers per sample.
    pub dimensions: usize,
    /// Numbers per window.
    stride: usize,
    numbers: Vec<f32>,
}

/// Texels that a sample blends, as offsets from its window's texel, and their weights.
struct Bilinear {
    offsets: [[i64; 2]; 4],
    weights: [f32; 4],
}

impl Bilinear {
    /// At (x, y) texels along s and t from a texel's centre; rows run against t.
    fn at(x: f32, y: f32) -> Self {
        let (right, down) = (x, -y);
        let (col, row) = (right.floor(), down.floor());
        let (u, v) = (right - col, down - row);
        let (col, row) = (col as i64, row as i64);
        Self {
            offsets: [
                [row, col],
                [row, col + 1],
                [row + 1, col],
                [row + 1, col + 1],
            ],
            weights: [(1.0 - u) * (1.0 - v), u * (1.0 - v), (1.0 - u) * v, u * v],
        }
    }

    /// The offsets and weights that count.
    fn counting(&self) -> impl Iterator<Item = ([i64; 2], f32)> + '_ {
        let pairs = self.offsets.iter().zip(self.weights);
        pairs
            .filter(|(_, weight)| *weight > 0.0)
            .map(|(&offset, weight)| (offset, weight))
    }
}

/// What windows are read from: the vectors of a level's texels.
#[derive(Clone, Copy, Debug)]
pub struct DenseFeatures<'a> {
    /// The texels.
    pub grid: TexelGrid,
    /// The vector of each, by number.
    pub rows: &'a [u32],
    /// The vector off the grid.
    pub default: u32,
    /// All vectors, one after the other.
    pub vectors: &'a [f32],
    /// Numbers per vector.
    pub dimensions: usize,
}

impl DenseFeatures<'_> {
    #[inline(always)]
    fn vector(&self, texel: Option<TexelIndex>) -> &[f32] {
        let row = texel.map_or(self.default, |texel| self.rows[texel.index()]);
        &self.vectors[row as usize * self.dimensions..][..self.dimensions]
    }
}

impl DenseWindows {
    /// Resamples the windows of all texels of a level, whose features are `embedding`; off the grid lies the
    /// default.
    pub fn new(level: &SpaceLevel, embedding: &Embedding, template: &Template) -> Self {
        let features = DenseFeatures {
            grid: level.grid,
            rows: &feature_rows(level),
            default: default_row(level),
            vectors: &flat_vectors(embedding),
            dimensions: embedding.dimensions,
        };
        Self::of_features(features, template, None)
    }

    /// Resamples the windows of all texels. `turns` says by texel where the template's x axis
    /// points, as a unit vector (s, t).
    pub fn of_features(
        features: DenseFeatures<'_>,
        template: &Template,
        turns: Option<&[Vec2]>,
    ) -> Self {
        let (dimensions, grid) = (features.dimensions, features.grid);
        // Turn the template once where all texels share a direction.
        let upright = samples(template, Vec2::X);
        let stride = dimensions * template.positions.len();
        let mut numbers = vec![0.0; stride * grid.len()];
        // Resample window by window, in parallel.
        let tasks = numbers.par_chunks_mut(stride.max(1) * CHUNK).enumerate();
        tasks.for_each(|(task, windows)| {
            for (at, window) in windows.chunks_exact_mut(stride).enumerate() {
                let texel = task * CHUNK + at;
                let (row, col) = place(grid, texel);
                let turned = turns.map(|turns| samples(template, turns[texel]));
                let samples = turned.as_ref().unwrap_or(&upright);
                for (sample, numbers) in samples.iter().zip(window.chunks_exact_mut(dimensions)) {
                    for ([drow, dcol], weight) in sample.counting() {
                        let vector = features.vector(grid.texel_at(row + drow, col + dcol));
                        for (number, value) in numbers.iter_mut().zip(vector) {
                            *number += weight * value;
                        }
                    }
                }
            }
        });
        Self {
            dimensions,
            stride,
            numbers,
        }
    }

    /// The numbers of a texel's window, sample after sample.
    #[inline(always)]
    pub fn window(&self, texel: u32) -> &[f32] {
        &self.numbers[texel as usize * self.stride..][..self.stride]
    }
}

/// Which texels are whole: those that the margin of a neighbour table of `k` neighbours leaves. Where it is of whole
/// windows, every texel that the samples blend is on the grid. `turns` as in [`DenseWindows::of_features`].
pub fn whole_texels(
    (grid, k): (TexelGrid, usize),
    margin: Margin,
    template: &Template,
    turns: Option<&[Vec2]>,
) -> Vec<bool> {
    let upright = samples(template, Vec2::X);
    margin.whole_texels(grid, k, |texel| {
        let (row, col) = place(grid, texel.index());
        let turned = turns.map(|turns| samples(template, turns[texel.index()]));
        let samples = turned.as_ref().unwrap_or(&upright).iter();
        let mut counting = samples.flat_map(Bilinear::counting);
        counting.all(|([drow, dcol], _)| grid.texel_at(row + drow, col + dcol).is_some())
    })
}

/// The samples of a template whose x axis points along a unit vector (s, t).
fn samples(template: &Template, along: Vec2) -> Vec<Bilinear> {
    let positions = template.positions.iter();
    let turned = positions.map(|&at| along.rotate(at));
    turned.map(|at| Bilinear::at(at.x, at.y)).collect()
}

/// The vectors of all feature rows, one after the other, without padding.
pub fn flat_vectors(embedding: &Embedding) -> Vec<f32> {
    let vector = |row: usize| {
        let blocks = (0..embedding.blocks).flat_map(move |block| embedding.plane(block)[row]);
        blocks.take(embedding.dimensions)
    };
    (0..embedding.rows).flat_map(vector).collect()
}

fn place(grid: TexelGrid, texel: usize) -> (i64, i64) {
    let width = grid.width as usize;
    ((texel / width) as i64, (texel % width) as i64)
}

#[cfg(test)]
mod tests {
    use ndarray::Array3;

    use super::*;
    use crate::exemplar::space::Features;

    /// Features whose one number is a linear function of the place.
    fn ramp(tileable: bool) -> (SpaceLevel, Embedding) {
        let grid = TexelGrid {
            width: 9,
            height: 7,
            tileable,
        };
        let numbers = |(row, col, _): (usize, usize, usize)| 2.0 * col as f32 - 3.0 * row as f32;
        let level = SpaceLevel {
            grid,
            features: Features::Plain(Array3::from_shape_fn((7, 9, 1), numbers)),
        };
        let embedding = Embedding::new(&level, 1.0);
        (level, embedding)
    }

    #[test]
    fn samples_are_blends_of_the_texels_round_them() {
        let (level, embedding) = ramp(false);
        let template = Template {
            positions: vec![Vec2::ZERO, Vec2::new(0.25, 0.5), Vec2::new(-1.5, -1.0)],
            ..Template::default()
        };
        let windows = DenseWindows::new(&level, &embedding, &template);
        let texel = level.grid.texel(3, 4);
        let mean = 2.0 * 4.0 - 3.0 * 3.0;
        // Up is a smaller row.
        let expected =
            [0.0, 2.0 * 0.25 + 3.0 * 0.5, -2.0 * 1.5 - 3.0].map(|d| d + 8.0 - 9.0 - mean);
        for (found, expected) in windows.window(texel.0).iter().zip(expected) {
            assert!((found - expected).abs() < 1e-5, "{found} {expected}");
        }
    }

    #[test]
    fn wholeness_counts_the_texels_that_weigh() {
        let (level, _) = ramp(false);
        let template = Template {
            positions: vec![Vec2::new(1.0, 0.0), Vec2::new(0.0, 1.5)],
            ..Template::default()
        };
        let full = |grid, turns| whole_texels((grid, 1), Margin::Full, &template, turns);
        let whole = full(level.grid, None);
        for (texel, whole) in whole.into_iter().enumerate() {
            let (row, col) = (texel / 9, texel % 9);
            assert_eq!(whole, row >= 2 && col <= 7, "{row} {col}");
        }
        let tile = ramp(true).0;
        assert!(full(tile.grid, None).iter().all(|&whole| whole));
    }

    #[test]
    fn turned_windows_see_the_picture_turned_back() {
        let (level, embedding) = ramp(true);
        let template = Template::square(3);
        let rows = feature_rows(&level);
        let vectors = flat_vectors(&embedding);
        let features = DenseFeatures {
            grid: level.grid,
            rows: &rows,
            default: default_row(&level),
            vectors: &vectors,
            dimensions: 1,
        };
        let texel = level.grid.texel(3, 4);
        let upright = DenseWindows::new(&level, &embedding, &template);
        // The template's x axis points along t: what lay right of the texel is what lies above it.
        let turns = vec![Vec2::Y; level.grid.len()];
        let turned = DenseWindows::of_features(features, &template, Some(&turns));
        let at =
            |windows: &DenseWindows, row: usize, col: usize| windows.window(texel.0)[3 * row + col];
        for row in 0..3 {
            for col in 0..3 {
                let (found, expected) = (at(&turned, row, col), at(&upright, 2 - col, row));
                assert!(
                    (found - expected).abs() < 1e-4,
                    "{row} {col}: {found} {expected}"
                );
            }
        }
        let open = ramp(false).0;
        let diagonal = vec![Vec2::new(0.6, 0.8); open.grid.len()];
        let whole = whole_texels((open.grid, 1), Margin::Full, &template, Some(&diagonal));
        // The corners of the window lie 1.4 away.
        assert!(whole[2 * 9 + 2] && !whole[9 + 1] && !whole[9 + 4]);
    }
}
