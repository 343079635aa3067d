//! Distances of all texels' windows, exactly, by box sums.
//!
//! In: a level of a space. Out: for a strip of rows the squared window distances of its texels to
//! all texels. A window distance is the sum of texel distances along a diagonal: Σ_o d²(p + o,
//! q + o). So rows of texel distances are summed along x once, and added to the window rows they
//! belong to: about 16 additions a pair instead of 49 look-ups.
//!
//! Off the grid a sample holds the default texton (of a plain image, the mean); a tileable level
//! continues on the other side.

use std::ops::Range;

use ndarray::{Array2, Axis, s};
use rayon::prelude::*;

use crate::exemplar::space::{Features, SpaceLevel};
use crate::grid::TexelGrid;
use crate::index::TexelIndex;

/// What stands at every place of the level and of a border around it.
enum Places {
    /// Indices into a table of squared distances [features, features].
    Labels {
        labels: Vec<u32>,
        table: Array2<f32>,
    },
    /// Vectors of `depth` numbers.
    Vectors { numbers: Vec<f32>, depth: usize },
}

/// The windows of one level.
pub struct WindowDistances {
    grid: TexelGrid,
    /// Half the window's width, and the border's.
    radius: usize,
    places: Places,
}

impl WindowDistances {
    /// Windows of odd `width` on a level.
    pub fn new(level: &SpaceLevel, width: u32) -> Self {
        let (grid, radius) = (level.grid, width as usize / 2);
        let at = places_with_border(grid, radius);
        let places = match &level.features {
            Features::Textons { labels, gram } => {
                let default = gram.nrows() as u32 - 1;
                let label =
                    |place: &Option<usize>| place.map_or(default, |texel| u32::from(labels[texel]));
                Places::Labels {
                    labels: at.iter().map(label).collect(),
                    table: squared_distances(gram),
                }
            }
            Features::Vectors(features) => {
                let (depth, default) = (features.dim().2, level.default_feature());
                let all: Vec<f32> = features.iter().copied().collect();
                let numbers = at
                    .iter()
                    .flat_map(|place| match place {
                        Some(texel) => &all[texel * depth..(texel + 1) * depth],
                        None => &default,
                    })
                    .copied()
                    .collect();
                Places::Vectors { numbers, depth }
            }
        };
        Self {
            grid,
            radius,
            places,
        }
    }

    /// Squared window distances of all texels in `rows` to all texels, [texels of rows, texels].
    pub fn strip(&self, rows: Range<usize>) -> Array2<f32> {
        let (height, width) = (self.grid.height as usize, self.grid.width as usize);
        // One block of [texels of rows, texels of a row] for each row of the second texel.
        let blocks: Vec<Array2<f32>> = (0..height)
            .into_par_iter()
            .map(|to| self.block(&rows, to))
            .collect();
        let mut strip = Array2::zeros((rows.len() * width, height * width));
        strip
            .axis_iter_mut(Axis(0))
            .into_par_iter()
            .enumerate()
            .for_each(|(texel, mut row)| {
                for (to, block) in blocks.iter().enumerate() {
                    row.slice_mut(s![to * width..(to + 1) * width])
                        .assign(&block.row(texel));
                }
            });
        strip
    }

    /// Squared window distance of two texels.
    pub fn between(&self, a: TexelIndex, b: TexelIndex) -> f32 {
        let side = self.grid.width as usize + 2 * self.radius;
        let corner = |texel| {
            let (row, col) = self.grid.row_col(texel);
            row as usize * side + col as usize
        };
        let (a, b) = (corner(a), corner(b));
        let width = 2 * self.radius + 1;
        let mut sum = 0.0;
        for row in 0..width {
            let (a, b) = (a + row * side, b + row * side);
            let mut row_sum = 0.0;
            for at in 0..width {
                row_sum += self.place_distance(a + at, b + at);
            }
            sum += row_sum;
        }
        sum
    }

    /// Squared distance of what stands at two places of the bordered grid.
    fn place_distance(&self, a: usize, b: usize) -> f32 {
        match &self.places {
            Places::Labels { labels, table } => table[[labels[a] as usize, labels[b] as usize]],
            Places::Vectors { numbers, depth } => {
                let at = |place: usize| &numbers[place * depth..(place + 1) * depth];
                at(a)
                    .iter()
                    .zip(at(b))
                    .map(|(a, b)| (a - b) * (a - b))
                    .sum()
            }
        }
    }

    /// Distances of the texels in `rows` to the texels of row `to`.
    fn block(&self, rows: &Range<usize>, to: usize) -> Array2<f32> {
        let width = self.grid.width as usize;
        let mut block = Array2::zeros((rows.len() * width, width));
        let mut texel_distances = vec![0.0; (width + 2 * self.radius).pow(2)];
        for (at, row) in rows.clone().enumerate() {
            let mut target = block.slice_mut(s![at * width..(at + 1) * width, ..]);
            // Both rows in the bordered grid: the window's rows begin at the row's own number.
            for window_row in 0..=2 * self.radius {
                self.row_distances(row + window_row, to + window_row, &mut texel_distances);
                self.add_diagonal_sums(&texel_distances, &mut target);
            }
        }
        block
    }

    /// Squared distances of all places of one bordered row to all of another.
    fn row_distances(&self, from: usize, to: usize, out: &mut [f32]) {
        let side = self.grid.width as usize + 2 * self.radius;
        match &self.places {
            Places::Labels { labels, table } => {
                let (from, to) = (&labels[from * side..][..side], &labels[to * side..][..side]);
                for (out, &a) in out.chunks_mut(side).zip(from) {
                    let distances = table.row(a as usize);
                    for (out, &b) in out.iter_mut().zip(to) {
                        *out = distances[b as usize];
                    }
                }
            }
            Places::Vectors { numbers, depth } => {
                let row = |at: usize| numbers[at * side * depth..][..side * depth].chunks(*depth);
                for (out, a) in out.chunks_mut(side).zip(row(from)) {
                    for (out, b) in out.iter_mut().zip(row(to)) {
                        *out = a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum();
                    }
                }
            }
        }
    }

    /// Adds Σ_o d(x + o, x′ + o) for all x and x′ of two rows.
    fn add_diagonal_sums(&self, distances: &[f32], target: &mut ndarray::ArrayViewMut2<'_, f32>) {
        let width = self.grid.width as usize;
        let side = width + 2 * self.radius;
        for (x, mut target) in target.outer_iter_mut().enumerate() {
            let Some(target) = target.as_slice_mut() else {
                continue;
            };
            for o in 0..=2 * self.radius {
                let row = &distances[(x + o) * side + o..][..width];
                target.iter_mut().zip(row).for_each(|(t, d)| *t += d);
            }
        }
    }
}

/// The texel at every place of a grid with a border, row by row; `None` off the grid.
fn places_with_border(grid: TexelGrid, radius: usize) -> Vec<Option<usize>> {
    let radius = radius as i64;
    let rows = -radius..i64::from(grid.height) + radius;
    rows.flat_map(|row| {
        let cols = -radius..i64::from(grid.width) + radius;
        cols.map(move |col| grid.texel_at(row, col).map(|texel| texel.index()))
    })
    .collect()
}

/// Φ_aa + Φ_bb − 2 Φ_ab of all pairs, not below 0.
pub fn squared_distances(gram: &Array2<f32>) -> Array2<f32> {
    Array2::from_shape_fn(gram.raw_dim(), |(a, b)| {
        let [aa, bb, ab] = [gram[[a, a]], gram[[b, b]], gram[[a, b]]].map(f64::from);
        (aa + bb - 2.0 * ab).max(0.0) as f32
    })
}
