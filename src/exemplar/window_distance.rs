//! Distances of all texels' windows, exactly, by box sums.
//!
//! In: a level of a space. Out: for a block of texels the squared window distances to all texels. A
//! window distance is the sum of texel distances along a diagonal: Σ_o d²(p + o, q + o). So texel
//! distances of two rows are found once and summed along x once, and the sums of as many pairs of rows
//! as a window has are added: about 12 additions a pair for 7 × 7 instead of 49 look-ups.
//!
//! Off the grid a sample holds the default texton (of a plain image, the mean); a tileable level
//! continues on the other side.

use multiversion::multiversion;
use ndarray::Array2;

use crate::exemplar::space::{Features, SpaceLevel};
use crate::exemplar::texel_block::TexelBlock;
use crate::grid::TexelGrid;
use crate::index::TexelIndex;

/// Numbers added at once.
const LANES: usize = 16;

/// What stands at every place of the level and of a border around it.
enum Places {
    /// Indices into a table of squared distances [features, features].
    Labels {
        labels: Vec<u32>,
        table: Array2<f32>,
    },
    /// Vectors of `depth` numbers: of each row all first numbers, then all second ones, and so on.
    Vectors { numbers: Vec<f32>, depth: usize },
}

/// The windows of one level.
pub struct WindowDistances {
    grid: TexelGrid,
    /// Half the window's width, and the border's.
    radius: usize,
    /// Columns of the bordered grid, rounded up for whole lanes.
    side: usize,
    places: Places,
}

/// Working memory of one thread.
#[derive(Clone, Debug, Default)]
pub struct WindowBuffers {
    /// Distances of the places of two rows.
    places: Vec<f32>,
    /// Their sums along x, of as many pairs of rows as a block and its border have.
    sums: Vec<f32>,
}

impl WindowDistances {
    /// Windows of odd `width` on a level.
    pub fn new(level: &SpaceLevel, width: u32) -> Self {
        let (grid, radius) = (level.grid, width as usize / 2);
        let side = padded(grid) + 2 * radius;
        let side = side.next_multiple_of(LANES);
        let at = places_with_border(grid, radius, side);
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
                let number = |place: &Option<usize>, at: usize| {
                    place.map_or(default[at], |texel| all[texel * depth + at])
                };
                let of_row = |row: &[Option<usize>]| -> Vec<f32> {
                    (0..depth)
                        .flat_map(|at| row.iter().map(move |place| number(place, at)))
                        .collect()
                };
                let numbers = at.chunks(side).flat_map(of_row).collect();
                Places::Vectors { numbers, depth }
            }
        };
        Self {
            grid,
            radius,
            side,
            places,
        }
    }

    /// Squared window distances of a block's texels to all texels, [texels of the block, texels]; the
    /// same numbers, to the bit, as those of [`between`](Self::between).
    pub fn of_block(&self, block: &TexelBlock, buffers: &mut WindowBuffers, out: &mut Vec<f32>) {
        out.resize(block.len() * self.grid.len(), 0.0);
        let (rows, height) = (block.rows.clone(), self.grid.height as usize);
        // Every pair of a row of the block and a row of the grid lies below one of the first of either.
        for other in 0..height {
            self.rows_below(
                block,
                (0, other),
                rows.len().min(height - other),
                buffers,
                out,
            );
        }
        for own in 1..rows.len() {
            self.rows_below(
                block,
                (own, 0),
                (rows.len() - own).min(height),
                buffers,
                out,
            );
        }
    }

    /// Squared window distance of two texels.
    pub fn between(&self, a: TexelIndex, b: TexelIndex) -> f32 {
        let corner = |texel| {
            let (row, col) = self.grid.row_col(texel);
            (row as usize, col as usize)
        };
        let (a, b) = (corner(a), corner(b));
        let width = 2 * self.radius + 1;
        let mut sum = 0.0;
        for row in 0..width {
            let mut row_sum = 0.0;
            for at in 0..width {
                row_sum += self.place_distance((a.0 + row, a.1 + at), (b.0 + row, b.1 + at));
            }
            sum += row_sum;
        }
        sum
    }

    /// Squared distance of what stands at two places (row, column) of the bordered grid.
    fn place_distance(&self, a: (usize, usize), b: (usize, usize)) -> f32 {
        match &self.places {
            Places::Labels { labels, table } => {
                let label = |(row, col)| labels[row * self.side + col] as usize;
                table[[label(a), label(b)]]
            }
            Places::Vectors { numbers, depth } => {
                let number = |(row, col), at| numbers[(row * depth + at) * self.side + col];
                let square = |at| {
                    let apart: f32 = number(a, at) - number(b, at);
                    apart * apart
                };
                (0..*depth)
                    .map(square)
                    .fold(0.0, |sum, square| sum + square)
            }
        }
    }

    /// Window distances of `count` rows, from a row of the block and a row of the grid downwards.
    fn rows_below(
        &self,
        block: &TexelBlock,
        (own, other): (usize, usize),
        count: usize,
        buffers: &mut WindowBuffers,
        out: &mut [f32],
    ) {
        let (padded, window) = (padded(self.grid), 2 * self.radius + 1);
        let size = block.cols.len() * padded;
        buffers.sums.resize((count + 2 * self.radius) * size, 0.0);
        // In the bordered grid the window's rows begin at the texel's own number.
        for (at, sums) in buffers.sums.chunks_exact_mut(size).enumerate() {
            let (from, to) = (block.rows.start + own + at, other + at);
            self.row_distances(from, block, to, &mut buffers.places);
            add_diagonals(&buffers.places, self.side, window, sums, padded);
        }
        let (width, texels) = (self.grid.width as usize, self.grid.len());
        for at in 0..count {
            let sums = &buffers.sums[at * size..][..window * size];
            let first = (own + at) * block.cols.len();
            let rows = out[first * texels..].chunks_exact_mut(texels);
            for (col, row) in (0..block.cols.len()).zip(rows) {
                let target = &mut row[(other + at) * width..][..width];
                add_rows(&sums[col * padded..], size, target);
            }
        }
    }

    /// Squared distances of the places over a block's columns, border included, in one row of the
    /// bordered grid, to all of another.
    fn row_distances(&self, from: usize, block: &TexelBlock, to: usize, out: &mut Vec<f32>) {
        let (side, cols) = (
            self.side,
            block.cols.start..block.cols.end + 2 * self.radius,
        );
        out.resize(cols.len() * side, 0.0);
        match &self.places {
            Places::Labels { labels, table } => {
                let (from, to) = (&labels[from * side..][..side], &labels[to * side..][..side]);
                for (out, &a) in out.chunks_exact_mut(side).zip(&from[cols]) {
                    let distances = table.row(a as usize);
                    for (out, &b) in out.iter_mut().zip(to) {
                        *out = distances[b as usize];
                    }
                }
            }
            Places::Vectors { numbers, depth } => {
                let row = |at: usize| &numbers[at * side * depth..][..side * depth];
                let places = out.chunks_exact_mut(side).zip(cols);
                places.for_each(|(out, col)| vector_distances(row(from), col, row(to), out));
            }
        }
    }
}

/// Columns of a grid, rounded up for whole lanes.
fn padded(grid: TexelGrid) -> usize {
    (grid.width as usize).next_multiple_of(LANES)
}

/// Squared distances of one place of a row to all of another, a plane of each row after another.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx2", "x86_64+avx2", "aarch64+neon"))]
fn vector_distances(from: &[f32], col: usize, to: &[f32], out: &mut [f32]) {
    let side = out.len();
    for (at, out) in out.as_chunks_mut::<LANES>().0.iter_mut().enumerate() {
        *out = [0.0; LANES];
        for (from, to) in from.chunks_exact(side).zip(to.chunks_exact(side)) {
            let (own, others) = (from[col], &to[at * LANES..][..LANES]);
            for lane in 0..LANES {
                let apart = own - others[lane];
                out[lane] += apart * apart;
            }
        }
    }
}

/// Σ_o d(x + o, x′ + o), o below `width`, for all x and x′.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx2", "x86_64+avx2", "aarch64+neon"))]
fn add_diagonals(distances: &[f32], side: usize, width: usize, sums: &mut [f32], padded: usize) {
    for (x, sums) in sums.chunks_exact_mut(padded).enumerate() {
        for (at, sums) in sums.as_chunks_mut::<LANES>().0.iter_mut().enumerate() {
            *sums = [0.0; LANES];
            for o in 0..width {
                let row = &distances[(x + o) * side + o + at * LANES..][..LANES];
                for lane in 0..LANES {
                    sums[lane] += row[lane];
                }
            }
        }
    }
}

/// The sum of rows that begin every `step` numbers.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx2", "x86_64+avx2", "aarch64+neon"))]
fn add_rows(rows: &[f32], step: usize, target: &mut [f32]) {
    for (at, target) in target.chunks_mut(LANES).enumerate() {
        let mut sums = [0.0; LANES];
        for row in rows[at * LANES..].chunks(step) {
            let row = &row[..LANES];
            for lane in 0..LANES {
                sums[lane] += row[lane];
            }
        }
        target.copy_from_slice(&sums[..target.len()]);
    }
}

/// The texel at every place of a grid with a border, row by row, rows filled up to `side`; `None` off
/// the grid.
fn places_with_border(grid: TexelGrid, radius: usize, side: usize) -> Vec<Option<usize>> {
    let (radius, side) = (radius as i64, side as i64);
    let rows = -radius..i64::from(grid.height) + radius;
    rows.flat_map(|row| {
        let cols = -radius..side - radius;
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
