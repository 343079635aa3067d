//! Choosing neighbours greedily by (distance, flat index), each a least separation from all taken.
//!
//! In: distances of a texel to all texels. Out: its neighbours, nearest first, itself in column 0.

use std::ops::Range;

use multiversion::multiversion;

use crate::exemplar::table_rows::{Near, Row};
use crate::grid::TexelGrid;
use crate::index::TexelIndex;

/// Texels whose least distance is kept together.
const BLOCK: usize = 64;
/// Numbers compared at once.
const LANES: usize = 16;

/// The texels a level's neighbours are chosen from.
#[derive(Clone, Debug)]
pub struct Choice {
    grid: TexelGrid,
    /// The least separation, less one.
    reach: i64,
    /// Neighbours a texel, itself included.
    pub k: usize,
    /// 0, or infinity for texels that may not be listed.
    barred: Vec<f32>,
}

impl Choice {
    /// Chooses `k` neighbours a texel, itself included, among `whole` texels.
    pub fn new(grid: TexelGrid, whole: &[bool], separation: u32, k: usize) -> Self {
        let bar = |&whole: &bool| if whole { 0.0 } else { f32::INFINITY };
        Self {
            grid,
            reach: i64::from(separation.max(1)) - 1,
            k,
            barred: whole.iter().map(bar).collect(),
        }
    }

    /// Chooses the neighbours of a texel, whose distances to all are `distances` (destroyed). Fails
    /// with the number found when there are too few.
    pub fn choose(&self, texel: TexelIndex, distances: &mut [f32]) -> Row {
        let mut chosen = Vec::with_capacity(self.k);
        chosen.push((distances[texel.index()], texel.0));
        let mut field = Field::new(self, distances);
        field.bar_around(texel);
        while chosen.len() < self.k {
            let nearest = field.nearest().ok_or(chosen.len())?;
            chosen.push(nearest);
            field.bar_around(TexelIndex(nearest.1));
        }
        Ok(chosen)
    }
}

/// The distances from one texel, with those out of the question at infinity.
struct Field<'a> {
    choice: &'a Choice,
    distances: &'a mut [f32],
    /// The least distance of each block.
    minima: Vec<f32>,
    /// Blocks whose least distance is to be found anew.
    stale: Vec<usize>,
}

impl<'a> Field<'a> {
    fn new(choice: &'a Choice, distances: &'a mut [f32]) -> Self {
        let mut minima = vec![f32::INFINITY; distances.len().div_ceil(BLOCK)];
        bar_and_find_least(distances, &choice.barred, &mut minima);
        Self {
            choice,
            distances,
            minima,
            stale: Vec::new(),
        }
    }

    /// The nearest texel still in question; of equals the smaller index.
    fn nearest(&self) -> Option<Near> {
        let distance = least(&self.minima);
        if distance == f32::INFINITY {
            return None;
        }
        let block = self.minima.iter().position(|&d| d == distance)?;
        let texels = self.block(block);
        let place = self.distances[texels.clone()]
            .iter()
            .position(|&d| d == distance)?;
        Some((distance, (texels.start + place) as u32))
    }

    /// The texels of a block.
    fn block(&self, block: usize) -> Range<usize> {
        block * BLOCK..((block + 1) * BLOCK).min(self.distances.len())
    }

    /// Puts everything closer than the separation out of the question.
    fn bar_around(&mut self, texel: TexelIndex) {
        let (grid, reach) = (self.choice.grid, self.choice.reach);
        let (row, col) = grid.row_col(texel);
        let (row, col) = (i64::from(row), i64::from(col));
        for row in row - reach..=row + reach {
            for col in col - reach..=col + reach {
                if let Some(near) = grid.texel_at(row, col) {
                    let (block, distance) =
                        (near.index() / BLOCK, &mut self.distances[near.index()]);
                    if *distance == self.minima[block] {
                        self.stale.push(block);
                    }
                    *distance = f32::INFINITY;
                }
            }
        }
        while let Some(block) = self.stale.pop() {
            self.minima[block] = least(&self.distances[self.block(block)]);
        }
    }
}

/// Bars texels, and finds the least distance of each block.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx2", "x86_64+avx2", "aarch64+neon"))]
fn bar_and_find_least(distances: &mut [f32], barred: &[f32], minima: &mut [f32]) {
    let blocks = distances.chunks_mut(BLOCK).zip(barred.chunks(BLOCK));
    for ((distances, barred), minimum) in blocks.zip(minima) {
        for (distance, bar) in distances.iter_mut().zip(barred) {
            *distance += bar;
        }
        *minimum = least_of(distances);
    }
}

#[multiversion(targets("x86_64+avx512f+avx512vl+avx2", "x86_64+avx2", "aarch64+neon"))]
fn least(values: &[f32]) -> f32 {
    least_of(values)
}

/// The least of some numbers, none of them NaN; infinity of none.
#[inline(always)]
fn least_of(values: &[f32]) -> f32 {
    let smaller = |a: f32, b: f32| if b < a { b } else { a };
    let (whole, rest) = values.as_chunks::<LANES>();
    let mut lanes = [f32::INFINITY; LANES];
    for values in whole {
        for lane in 0..LANES {
            lanes[lane] = smaller(lanes[lane], values[lane]);
        }
    }
    let mut half = LANES / 2;
    while half > 0 {
        for lane in 0..half {
            lanes[lane] = smaller(lanes[lane], lanes[lane + half]);
        }
        half /= 2;
    }
    rest.iter().copied().fold(lanes[0], smaller)
}
