//! Distances of all texels' windows, exactly, by box sums.
//!
//! In: a level of a space. Out: for a block of texels the squared window distances to all texels. A
//! window distance is the sum of texel distances along a diagonal: Σ_o d²(p + o, q + o). So texel
//! distances of two rows are summed along x as they are found, and the sums of as many pairs of rows
//! as a window has are added: about 12 additions per pair for 7 × 7 instead of 49 look-ups.
//!
//! Off the grid a sample holds the default texton (of a plain image, the mean); a tileable level
//! continues on the other side.

use ndarray::Array2;

use crate::exemplar::aligned_buffer::AlignedNumbers;
use crate::exemplar::diagonal_sums::{WindowRow, add_rows, label_sums, vector_sums};
use crate::exemplar::space::{Features, SpaceLevel};
use crate::exemplar::texel_block::TexelBlock;
use crate::grid::TexelGrid;
use crate::index::TexelIndex;
use crate::lanes::LANES;

/// What stands at every place of the level and of a border around it: once as the bordered grid is,
/// row by row; and once each row as often round as shifts are read.
enum Places {
    /// Indices into a table of squared distances [features, features].
    Labels {
        once: Vec<u32>,
        round: Vec<u32>,
        table: Array2<f32>,
    },
    /// Vectors of `depth` numbers: side by side; and of each row all first numbers, then all second
    /// ones, and so on.
    Vectors {
        once: Vec<f32>,
        round: Vec<f32>,
        depth: usize,
    },
}

/// The windows of one level.
pub struct WindowDistances {
    grid: TexelGrid,
    /// Half the window's width, and the border's.
    radius: usize,
    /// Columns after which a row begins again.
    period: usize,
    places: Places,
}

/// Working memory of one thread.
#[derive(Clone, Debug, Default)]
pub struct WindowBuffers {
    /// Distances of the places of two rows, summed along x: of as many pairs of rows as a block and its
    /// border have.
    sums: AlignedNumbers,
}

impl WindowDistances {
    /// Windows of odd `width` on a level.
    pub fn new(level: &SpaceLevel, width: u32) -> Self {
        // Lay the rows out with a border that wraps or holds the default texel.
        let (grid, radius) = (level.grid, width as usize / 2);
        let side = grid.width as usize + 2 * radius;
        let period = match grid.tileable {
            true => grid.width as usize,
            false => side,
        };
        let shifts = period.next_multiple_of(LANES);
        let once = places(grid, radius, 0..side);
        let round = places(grid, radius, (0..side + shifts).map(|col| col % period));
        // Put labels or vectors at these places.
        let places = match &level.features {
            Features::Textons { labels, gram } => {
                let default = gram.nrows() as u32 - 1;
                let label =
                    |place: &Option<usize>| place.map_or(default, |texel| u32::from(labels[texel]));
                Places::Labels {
                    once: once.iter().map(label).collect(),
                    round: round.iter().map(label).collect(),
                    table: squared_distances(gram),
                }
            }
            Features::Plain(features) => {
                let (depth, default) = (features.dim().2, level.default_feature());
                let all: Vec<f32> = features.iter().copied().collect();
                let vector = |place: &Option<usize>| match *place {
                    Some(texel) => &all[texel * depth..][..depth],
                    None => &default[..],
                };
                let of_row = |row: &[Option<usize>]| -> Vec<f32> {
                    let numbers = (0..depth).flat_map(|at| row.iter().map(move |p| vector(p)[at]));
                    numbers.collect()
                };
                Places::Vectors {
                    once: once.iter().flat_map(vector).copied().collect(),
                    round: round.chunks(side + shifts).flat_map(of_row).collect(),
                    depth,
                }
            }
        };
        Self {
            grid,
            radius,
            period,
            places,
        }
    }

    /// Squared window distances of a block's texels to all texels, [texels of the block, texels]; the
    /// same numbers, to the bit, as those of [`between`](Self::between).
    pub fn of_block<'o>(
        &self,
        block: &TexelBlock,
        buffers: &mut WindowBuffers,
        out: &'o mut AlignedNumbers,
    ) -> &'o mut [f32] {
        let out = out.of_length(block.len() * self.grid.len());
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
        out
    }

    /// Squared window distance of two texels.
    pub fn between(&self, a: TexelIndex, b: TexelIndex) -> f32 {
        let corner = |texel| {
            let (row, col) = self.grid.row_col(texel);
            (row as usize, col as usize)
        };
        let (a, b) = (corner(a), corner(b));
        let mut sum = 0.0;
        for row in 0..self.window() {
            let mut row_sum = 0.0;
            for at in 0..self.window() {
                row_sum += self.place_distance((a.0 + row, a.1 + at), (b.0 + row, b.1 + at));
            }
            sum += row_sum;
        }
        sum
    }

    /// The window's width.
    fn window(&self) -> usize {
        2 * self.radius + 1
    }

    /// Columns of the bordered grid.
    fn side(&self) -> usize {
        self.grid.width as usize + 2 * self.radius
    }

    /// Squared distance of what stands at two places (row, column) of the bordered grid.
    fn place_distance(&self, a: (usize, usize), b: (usize, usize)) -> f32 {
        let place = |(row, col)| row * self.side() + col;
        match &self.places {
            Places::Labels { once, table, .. } => {
                table[[once[place(a)] as usize, once[place(b)] as usize]]
            }
            Places::Vectors { once, depth, .. } => {
                let vector = |at| &once[place(at) * depth..][..*depth];
                let apart = vector(a).iter().zip(vector(b)).map(|(a, b)| a - b);
                apart.fold(0.0, |sum, apart| sum + apart * apart)
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
        let along = WindowRow {
            first: block.cols.start,
            columns: block.cols.len(),
            window: self.window(),
            period: self.period,
        };
        let size = along.size();
        let sums = buffers.sums.of_length((count + 2 * self.radius) * size);
        // In the bordered grid the window's rows begin at the texel's own number.
        for (at, sums) in sums.chunks_exact_mut(size).enumerate() {
            self.row_sums(block.rows.start + own + at, other + at, along, sums);
        }
        let (width, texels) = (self.grid.width as usize, self.grid.len());
        for at in 0..count {
            let sums = &sums[at * size..][..along.window * size];
            let begin = (own + at) * along.columns * texels + (other + at) * width;
            let targets = out[begin..].chunks_mut(texels).take(along.columns);
            add_rows(along, sums, targets, width);
        }
    }

    /// Squared distances of the places of one row of the bordered grid to those of another, summed
    /// along x.
    fn row_sums(&self, from: usize, to: usize, along: WindowRow, sums: &mut [f32]) {
        let (side, round_side) = (self.side(), self.side() + along.shifts());
        match &self.places {
            Places::Labels { once, round, table } => {
                let (from, to) = (&once[from * side..][..side], &round[to * round_side..]);
                label_sums(along, table, from, &to[..round_side], sums);
            }
            Places::Vectors { once, round, depth } => {
                let from = &once[from * side * depth..][..side * depth];
                let to = &round[to * round_side * depth..][..round_side * depth];
                vector_sums(along, *depth, from, to, sums);
            }
        }
    }
}

/// The texel at every place of a grid with a border, row by row, at some columns; `None` off the grid.
fn places(
    grid: TexelGrid,
    radius: usize,
    cols: impl Iterator<Item = usize> + Clone,
) -> Vec<Option<usize>> {
    let radius = radius as i64;
    let rows = -radius..i64::from(grid.height) + radius;
    rows.flat_map(|row| {
        let texel = move |col| grid.texel_at(row, col as i64 - radius);
        cols.clone()
            .map(move |col| texel(col).map(TexelIndex::index))
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
