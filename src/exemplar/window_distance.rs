//! Distances of all texels' windows, exactly, by box sums.
//!
//! In: a level of a space. Out: for a block of texels the squared window distances to all texels. A
//! window distance is the sum of texel distances along a diagonal: Σ_o d²(p + o, q + o). So texel
//! distances of two rows are summed along x as they are found, and the sums of as many pairs of rows
//! as a window has are added: about 12 additions a pair for 7 × 7 instead of 49 look-ups.
//!
//! Lanes hold *turns*: lane c beside column x stands for column x + c, so that a window moves along a
//! diagonal within its lane. Columns are counted round, the border's too, and turned back at the end.
//!
//! Off the grid a sample holds the default texton (of a plain image, the mean); a tileable level
//! continues on the other side.

use std::iter::Take;
use std::slice::ChunksMut;

use multiversion::multiversion;
use ndarray::Array2;

use crate::exemplar::space::{Features, SpaceLevel};
use crate::exemplar::texel_block::TexelBlock;
use crate::grid::TexelGrid;
use crate::index::TexelIndex;

/// Numbers added at once.
const LANES: usize = 16;
type Lanes = [f32; LANES];

/// What stands at every place of the level and of a border around it: once as the bordered grid is,
/// row by row; and once each row as often round as turns are read.
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
    /// The period, rounded up for whole lanes.
    turns: usize,
    places: Places,
}

/// Working memory of one thread.
#[derive(Clone, Debug, Default)]
pub struct WindowBuffers {
    /// Distances of the places of two rows, summed along x: of as many pairs of rows as a block and its
    /// border have.
    sums: Vec<Lanes>,
    /// Window distances of the texels of one row to those of another, by turns.
    turned: Vec<f32>,
}

/// The part of two rows that is summed along x.
#[derive(Clone, Copy)]
struct Along {
    /// The first column.
    first: usize,
    /// The window's width.
    window: usize,
    /// Whole lanes of turns.
    blocks: usize,
}

impl WindowDistances {
    /// Windows of odd `width` on a level.
    pub fn new(level: &SpaceLevel, width: u32) -> Self {
        let (grid, radius) = (level.grid, width as usize / 2);
        let side = grid.width as usize + 2 * radius;
        let period = match grid.tileable {
            true => grid.width as usize,
            false => side,
        };
        let turns = period.next_multiple_of(LANES);
        let once = places(grid, radius, 0..side);
        let round = places(grid, radius, (0..side + turns).map(|col| col % period));
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
            Features::Vectors(features) => {
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
                    round: round.chunks(side + turns).flat_map(of_row).collect(),
                    depth,
                }
            }
        };
        Self {
            grid,
            radius,
            period,
            turns,
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
        let WindowBuffers { sums, turned } = buffers;
        let size = block.cols.len() * self.turns / LANES;
        sums.resize((count + 2 * self.radius) * size, [0.0; LANES]);
        turned.resize((size + 2) * LANES, 0.0);
        // In the bordered grid the window's rows begin at the texel's own number.
        for (at, sums) in sums.chunks_exact_mut(size).enumerate() {
            self.row_sums(block.rows.start + own + at, other + at, block, sums);
        }
        let (width, texels) = (self.grid.width as usize, self.grid.len());
        for at in 0..count {
            let own_lanes = &mut turned.as_chunks_mut().0[1..=size];
            add_rows(&sums[at * size..][..self.window() * size], own_lanes);
            let begin = (own + at) * block.cols.len() * texels + (other + at) * width;
            let rows = out[begin..].chunks_mut(texels).take(block.cols.len());
            turn_back(
                turned,
                block.cols.start,
                (self.period, self.turns),
                rows,
                width,
            );
        }
    }

    /// Squared distances of the places of one row of the bordered grid, from a block's columns on, to
    /// those of another, summed along x.
    fn row_sums(&self, from: usize, to: usize, block: &TexelBlock, sums: &mut [Lanes]) {
        let (side, round_side) = (self.side(), self.side() + self.turns);
        let along = Along {
            first: block.cols.start,
            window: self.window(),
            blocks: self.turns / LANES,
        };
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

/// Sums along x of the distances of labelled places.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx2", "x86_64+avx2", "aarch64+neon"))]
fn label_sums(along: Along, table: &Array2<f32>, from: &[u32], to: &[u32], sums: &mut [Lanes]) {
    let (features, table) = (table.ncols(), table.as_slice().unwrap_or_default());
    let pair = LabelRows {
        features,
        table,
        from,
        to,
    };
    along.add(pair, sums);
}

/// Sums along x of the squared distances of vectors.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx2", "x86_64+avx2", "aarch64+neon"))]
fn vector_sums(along: Along, depth: usize, from: &[f32], to: &[f32], sums: &mut [Lanes]) {
    let pair = VectorRows {
        depth,
        from,
        side: to.len() / depth,
        to,
    };
    along.add(pair, sums);
}

/// Two rows of the bordered grid.
trait RowPair {
    /// Distances of a place of one row to those of the other that lie some turns behind, lane by lane.
    fn distances(&self, place: usize, turn: usize) -> Lanes;
}

struct LabelRows<'a> {
    features: usize,
    table: &'a [f32],
    from: &'a [u32],
    to: &'a [u32],
}

impl RowPair for LabelRows<'_> {
    #[inline(always)]
    fn distances(&self, place: usize, turn: usize) -> Lanes {
        let row = &self.table[self.from[place] as usize * self.features..][..self.features];
        let others = &self.to[place + turn..][..LANES];
        let mut distances = [0.0; LANES];
        for lane in 0..LANES {
            distances[lane] = row[others[lane] as usize];
        }
        distances
    }
}

struct VectorRows<'a> {
    depth: usize,
    from: &'a [f32],
    /// Numbers that follow each other in `to` before those of the next dimension.
    side: usize,
    to: &'a [f32],
}

impl RowPair for VectorRows<'_> {
    #[inline(always)]
    fn distances(&self, place: usize, turn: usize) -> Lanes {
        let own = &self.from[place * self.depth..][..self.depth];
        let mut distances = [0.0; LANES];
        let mut begin = place + turn;
        for own in own {
            let others = &self.to[begin..][..LANES];
            for lane in 0..LANES {
                let apart = own - others[lane];
                distances[lane] += apart * apart;
            }
            begin += self.side;
        }
        distances
    }
}

impl Along {
    /// Σ_o d(x + o, c), o below the window's width, for all columns x and turns c: column after column.
    #[inline(always)]
    fn add(self, rows: impl RowPair, sums: &mut [Lanes]) {
        match self.window {
            3 => self.add_at_hand::<3>(rows, sums),
            5 => self.add_at_hand::<5>(rows, sums),
            7 => self.add_at_hand::<7>(rows, sums),
            _ => self.add_any(rows, sums),
        }
    }

    /// The window's distances stay in registers.
    #[inline(always)]
    fn add_at_hand<const WINDOW: usize>(self, rows: impl RowPair, sums: &mut [Lanes]) {
        let columns = sums.len() / self.blocks;
        for block in 0..self.blocks {
            let mut latest = [[0.0; LANES]; WINDOW];
            for at in 0..columns + WINDOW - 1 {
                for newer in 1..WINDOW {
                    latest[newer - 1] = latest[newer];
                }
                latest[WINDOW - 1] = rows.distances(self.first + at, block * LANES);
                if at + 1 >= WINDOW {
                    let mut sum = latest[0];
                    for term in &latest[1..] {
                        add_lanes(&mut sum, term);
                    }
                    sums[(at + 1 - WINDOW) * self.blocks + block] = sum;
                }
            }
        }
    }

    #[inline(always)]
    fn add_any(self, rows: impl RowPair, sums: &mut [Lanes]) {
        let columns = sums.len() / self.blocks;
        let mut found = vec![[0.0; LANES]; columns + self.window - 1];
        for block in 0..self.blocks {
            for (at, found) in found.iter_mut().enumerate() {
                *found = rows.distances(self.first + at, block * LANES);
            }
            for (column, window) in found.windows(self.window).enumerate() {
                let mut sum = [0.0; LANES];
                window.iter().for_each(|term| add_lanes(&mut sum, term));
                sums[column * self.blocks + block] = sum;
            }
        }
    }
}

#[inline(always)]
fn add_lanes(sum: &mut Lanes, term: &Lanes) {
    for lane in 0..LANES {
        sum[lane] += term[lane];
    }
}

/// The sums of rows that follow each other.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx2", "x86_64+avx2", "aarch64+neon"))]
fn add_rows(rows: &[Lanes], sums: &mut [Lanes]) {
    let step = sums.len();
    for (at, sum) in sums.iter_mut().enumerate() {
        let mut total = [0.0; LANES];
        for row in rows[at..].chunks(step) {
            for lane in 0..LANES {
                total[lane] += row[0][lane];
            }
        }
        *sum = total;
    }
}

/// Distances of some columns, from `first` on, to all columns, which come by turns; a block of lanes
/// stands before and behind them. A target each column begins with the distances to `width` columns.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx2", "x86_64+avx2", "aarch64+neon"))]
fn turn_back(
    turned: &[f32],
    first: usize,
    (period, turns): (usize, usize),
    targets: Take<ChunksMut<'_, f32>>,
    width: usize,
) {
    for (index, target) in targets.enumerate() {
        let turned = &turned[index * turns..][..turns + 2 * LANES];
        let mut before = first + index;
        for target in target[..width].chunks_mut(LANES) {
            let lanes = turned_back(turned, before, period);
            match <&mut Lanes>::try_from(&mut *target) {
                Ok(whole) => *whole = lanes,
                Err(_) => target.copy_from_slice(&lanes[..target.len()]),
            }
            before = before.wrapping_sub(LANES);
        }
    }
}

/// A block of lanes that begins some columns `before` the one that turns are counted from; behind it
/// where that is negative. Columns before it are a period less a few turns away.
#[inline(always)]
fn turned_back(turned: &[f32], before: usize, period: usize) -> Lanes {
    let lanes = |begin: usize| -> Lanes {
        let mut lanes = [0.0; LANES];
        lanes.copy_from_slice(&turned[begin..][..LANES]);
        lanes
    };
    let behind = (before as isize) <= 0;
    if behind {
        return lanes(LANES.wrapping_sub(before));
    }
    let far = lanes(LANES + period - before);
    if before >= LANES {
        return far;
    }
    let mut near = lanes(LANES - before);
    for lane in 0..LANES {
        if (lane as u32) < before as u32 {
            near[lane] = far[lane];
        }
    }
    near
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
