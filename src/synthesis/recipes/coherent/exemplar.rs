//! The exemplar as a function of the plane: bilinear between texel centres.
//!
//! A tileable exemplar is periodic. Any other is defined where its texels lie; in the half texel outside the
//! outermost centres it is constant across the border.

use macro_rules_attribute::apply;

use crate::exemplar::dense_windows::flat_vectors;
use crate::exemplar::embedding::Embedding;
use crate::exemplar::level::feature_rows;
use crate::exemplar::space::SpaceLevel;
use crate::grid::{TexCoord, TexelGrid};
use crate::index::TexelIndex;
use crate::lanes::vectorized;
use crate::sites::level::Neighbor;

/// Numbers that are blended and compared at once; values are filled up to as many with zeros.
const STEP: usize = 4;

type Step = [f32; STEP];

/// The values of a level at any place.
#[derive(Clone, Debug)]
pub struct ContinuousExemplar {
    grid: TexelGrid,
    /// Steps per value.
    steps: usize,
    /// The values at texel centres, of one texel more on every side.
    values: Vec<Step>,
    /// Steps per row of them.
    stride: usize,
}

/// Where a place lies among texel centres.
#[derive(Clone, Copy, Debug)]
struct Cell {
    /// Where the value of the centre up left of it begins.
    first: usize,
    /// How far right and down of that centre it lies.
    right: f32,
    down: f32,
}

impl ContinuousExemplar {
    /// A level whose features are `embedding`.
    pub fn new(level: &SpaceLevel, embedding: &Embedding) -> Self {
        let steps = embedding.dimensions.div_ceil(STEP).max(1);
        let vectors = flat_vectors(embedding);
        let value = |row: u32| -> Vec<Step> {
            let vector = &vectors[row as usize * embedding.dimensions..][..embedding.dimensions];
            let mut filled_up = vector.to_vec();
            filled_up.resize(steps * STEP, 0.0);
            filled_up.as_chunks().0.to_vec()
        };
        let (grid, rows) = (level.grid, feature_rows(level));
        let mut values = Vec::new();
        for row in -1..=i64::from(grid.height) {
            for col in -1..=i64::from(grid.width) {
                let texel = grid
                    .texel_at(row, col)
                    .unwrap_or_else(|| nearest(grid, row, col));
                values.extend(value(rows[texel.index()]));
            }
        }
        Self {
            grid,
            steps,
            values,
            stride: (grid.width as usize + 2) * steps,
        }
    }

    /// Its texels.
    pub fn grid(&self) -> TexelGrid {
        self.grid
    }

    /// Numbers per value.
    pub fn numbers(&self) -> usize {
        self.steps * STEP
    }

    /// A coordinate on the exemplar, 0 ≤ s < width and 0 < t ≤ height: wrapped if tileable, else `None` off it.
    #[inline(always)]
    pub fn place(&self, at: TexCoord) -> Option<TexCoord> {
        let (width, height) = (self.grid.width as f32, self.grid.height as f32);
        let on_grid = |at: TexCoord| at.s >= 0.0 && at.s < width && at.t > 0.0 && at.t <= height;
        if on_grid(at) {
            return Some(at);
        }
        if !self.grid.tileable {
            return None;
        }
        let s = at.s - width * (at.s / width).floor();
        let t = at.t - height * ((at.t / height).ceil() - 1.0);
        // Of tiny numbers beyond a border the sum rounds to the other.
        let at = TexCoord {
            s: if s < width { s } else { 0.0 },
            t: if t > 0.0 { t } else { height },
        };
        on_grid(at).then_some(at)
    }

    /// The value at a coordinate on the exemplar.
    pub fn read(&self, at: TexCoord, value: &mut [f32]) {
        let cell = self.cell(at);
        for (step, value) in value.as_chunks_mut::<STEP>().0.iter_mut().enumerate() {
            *value = self.blended(&cell, step);
        }
    }

    /// The candidate round which the exemplar is most like what neighbours hold; of equals the first. `values` are
    /// those of all sites.
    pub fn most_alike(
        &self,
        candidates: &[TexCoord],
        near: &[Neighbor],
        values: &[f32],
    ) -> TexCoord {
        most_alike(self, candidates, near, values)
    }

    /// The mean squared distance round a candidate over the neighbours for which the exemplar is defined, or
    /// infinity once it is known to be `limit` or more.
    #[inline(always)]
    fn distance(&self, at: TexCoord, near: &[Neighbor], values: &[f32], limit: f32) -> f32 {
        let (mut sum, mut count) = ([0.0; STEP], 0.0);
        let enough = limit * near.len() as f32;
        for neighbor in near {
            let there = TexCoord {
                s: at.s + neighbor.x,
                t: at.t + neighbor.y,
            };
            let Some(there) = self.place(there) else {
                continue;
            };
            let cell = self.cell(there);
            let numbers = self.numbers();
            let held = &values[neighbor.site as usize * numbers..][..numbers];
            for (step, held) in held.as_chunks::<STEP>().0.iter().enumerate() {
                let read = self.blended(&cell, step);
                for lane in 0..STEP {
                    let apart = read[lane] - held[lane];
                    sum[lane] += apart * apart;
                }
            }
            count += 1.0;
            // At most all neighbours are counted.
            if total(sum) >= enough {
                return f32::INFINITY;
            }
        }
        match count > 0.0 {
            true => total(sum) / count,
            false => f32::INFINITY,
        }
    }

    /// The cell of a coordinate on the exemplar.
    #[inline(always)]
    fn cell(&self, at: TexCoord) -> Cell {
        // Counted from the first centre of the texels more on the left and above.
        let (across, below) = (at.s + 0.5, self.grid.height as f32 - at.t + 0.5);
        let (col, row) = (across as i32, below as i32);
        Cell {
            first: row as usize * self.stride + col as usize * self.steps,
            right: across - col as f32,
            down: below - row as f32,
        }
    }

    #[inline(always)]
    fn blended(&self, cell: &Cell, step: usize) -> Step {
        let above = &self.values[cell.first + step..][..=self.steps];
        let below = &self.values[cell.first + self.stride + step..][..=self.steps];
        let (a, b) = (&above[0], &above[self.steps]);
        let (c, d) = (&below[0], &below[self.steps]);
        let mut blend = [0.0; STEP];
        for lane in 0..STEP {
            let above = a[lane] + cell.right * (b[lane] - a[lane]);
            let below = c[lane] + cell.right * (d[lane] - c[lane]);
            blend[lane] = above + cell.down * (below - above);
        }
        blend
    }
}

/// The texel of the border that is nearest to a place one texel off the grid.
fn nearest(grid: TexelGrid, row: i64, col: i64) -> TexelIndex {
    let clamped = |at: i64, side: u32| at.clamp(0, i64::from(side) - 1) as u32;
    grid.texel(clamped(row, grid.height), clamped(col, grid.width))
}

#[inline(always)]
fn total(sum: Step) -> f32 {
    (sum[0] + sum[1]) + (sum[2] + sum[3])
}

#[apply(vectorized!)]
fn most_alike(
    exemplar: &ContinuousExemplar,
    candidates: &[TexCoord],
    near: &[Neighbor],
    values: &[f32],
) -> TexCoord {
    let (mut best, mut least) = (candidates[0], f32::INFINITY);
    for &candidate in candidates {
        let distance = exemplar.distance(candidate, near, values, least);
        if distance < least {
            (best, least) = (candidate, distance);
        }
        // Nothing is nearer.
        if least == 0.0 {
            break;
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use ndarray::Array3;

    use super::*;
    use crate::exemplar::space::Features;

    const HEIGHT: usize = 5;
    const WIDTH: usize = 7;

    fn value(row: usize, col: usize, number: usize) -> f32 {
        ((row * 37 + col * 11 + number * 5) % 13) as f32
    }

    fn exemplar(tileable: bool) -> ContinuousExemplar {
        let level = SpaceLevel {
            grid: TexelGrid {
                width: WIDTH as u32,
                height: HEIGHT as u32,
                tileable,
            },
            features: Features::Plain(Array3::from_shape_fn(
                (HEIGHT, WIDTH, 5),
                |(row, col, number)| value(row, col, number),
            )),
        };
        ContinuousExemplar::new(&level, &Embedding::new(&level, 1.0))
    }

    fn read(exemplar: &ContinuousExemplar, s: f32, t: f32) -> Vec<f32> {
        let mut value = vec![0.0; exemplar.numbers()];
        exemplar.read(TexCoord { s, t }, &mut value);
        value
    }

    /// Between two values of a texel line, told as differences, as the mean is left out.
    fn check(found: &[f32], from: &[f32], expected: impl Fn(usize) -> f32) {
        for number in 0..5 {
            let apart = found[number] - from[number];
            assert!((apart - expected(number)).abs() < 1e-4, "{number}: {apart}");
        }
        assert!(found[5..].iter().all(|&number| number == 0.0));
    }

    #[test]
    fn between_centres_the_exemplar_is_bilinear() {
        for tileable in [false, true] {
            let exemplar = exemplar(tileable);
            // Row 1, column 2; a quarter right and half down of it.
            let from = read(&exemplar, 2.5, 3.5);
            let found = read(&exemplar, 2.75, 3.0);
            check(&found, &from, |n| {
                let above = 0.75 * value(1, 2, n) + 0.25 * value(1, 3, n);
                let below = 0.75 * value(2, 2, n) + 0.25 * value(2, 3, n);
                0.5 * above + 0.5 * below - value(1, 2, n)
            });
        }
    }

    #[test]
    fn at_the_border_it_goes_on_across_or_stays_as_it_is() {
        let (open, tile) = (exemplar(false), exemplar(true));
        // The left border in row 4, a quarter before the first centre; the lower border too.
        let corner = read(&open, 0.5, 0.5);
        check(&read(&open, 0.25, 0.25), &corner, |_| 0.0);
        check(&read(&tile, 0.25, 0.5), &corner, |n| {
            0.25 * (value(4, 6, n) - value(4, 0, n))
        });
        check(&read(&tile, 0.5, 0.25), &corner, |n| {
            0.25 * (value(0, 0, n) - value(4, 0, n))
        });
        let right = read(&open, 6.5, 4.5);
        check(&read(&open, 6.9, 5.0), &right, |_| 0.0);
        check(&read(&tile, 6.75, 4.5), &right, |n| {
            0.25 * (value(0, 0, n) - value(0, 6, n))
        });
    }

    #[test]
    fn coordinates_off_it_wrap_or_are_none() {
        let (open, tile) = (exemplar(false), exemplar(true));
        let at = |s, t| TexCoord { s, t };
        assert_eq!(open.place(at(0.0, 5.0)), Some(at(0.0, 5.0)));
        for off in [at(-0.1, 2.0), at(7.0, 2.0), at(2.0, 0.0), at(2.0, 5.1)] {
            assert_eq!(open.place(off), None);
        }
        assert_eq!(tile.place(at(-0.5, 2.0)), Some(at(6.5, 2.0)));
        assert_eq!(tile.place(at(7.0, 0.0)), Some(at(0.0, 5.0)));
        assert_eq!(tile.place(at(16.5, -7.5)), Some(at(2.5, 2.5)));
        assert_eq!(tile.place(at(-1e-9, 5.0 + 1e-7)), Some(at(0.0, 5.0)));
        for step in 0..2000 {
            let off = at(-20.0 + 0.0201 * step as f32, 19.0 - 0.0199 * step as f32);
            let placed = tile.place(off).unwrap();
            assert!(placed.s >= 0.0 && placed.s < 7.0 && placed.t > 0.0 && placed.t <= 5.0);
        }
    }
}
