//! The coordinates that a site and its neighbours propose, and the texels that hold them: as lists of
//! numbers, so that all are placed in a few vector instructions.

use macro_rules_attribute::apply;

use crate::grid::{TexCoord, TexelGrid};
use crate::lanes::{LANES, vectorized};

/// Proposed coordinates in the order they came.
#[derive(Clone, Debug, Default)]
pub struct Proposals {
    coords: Vec<TexCoord>,
    /// The texel that holds each, or [`NOWHERE`].
    texels: Vec<u32>,
    /// How far right in its texel each lies.
    right: Vec<f32>,
    /// How far down.
    down: Vec<f32>,
}

/// The texel of a coordinate off the grid.
const NOWHERE: u32 = u32::MAX;

impl Proposals {
    /// Forgets all.
    pub fn clear(&mut self) {
        self.coords.clear();
    }

    /// Takes one more.
    #[inline(always)]
    pub fn push(&mut self, at: TexCoord) {
        self.coords.push(at);
    }

    /// Finds the texels that hold them, as [`TexelGrid::texel_holding`] does.
    pub fn place(&mut self, grid: TexelGrid) {
        let count = self.coords.len();
        self.texels.resize(count, NOWHERE);
        self.right.resize(count, 0.0);
        self.down.resize(count, 0.0);
        let (texels, right, down) = (&mut self.texels, &mut self.right, &mut self.down);
        let all_on_grid = place_near(grid, &self.coords, texels, right, down);
        // Windows wider than the grid itself reach further than once round it.
        if !all_on_grid && grid.tileable {
            for (at, texel) in self.coords.iter().zip(&mut self.texels) {
                *texel = grid.texel_holding(*at).map_or(NOWHERE, |texel| texel.0);
            }
        }
    }

    /// How many there are.
    #[inline(always)]
    pub fn len(&self) -> usize {
        self.coords.len()
    }

    /// The texel that holds one; `None` off the grid.
    #[inline(always)]
    pub fn texel(&self, proposal: usize) -> Option<u32> {
        Some(self.texels[proposal]).filter(|&texel| texel != NOWHERE)
    }

    /// How far right and down in a texel those lie that it holds, on average.
    pub fn mean_inside(&self, texel: u32) -> [f32; 2] {
        let [right, down, count] = sums_inside(&self.texels, &self.right, &self.down, texel);
        [right / count, down / count]
    }
}

/// Finds the texels of coordinates at most once round the grid away from it, and how far right and down
/// in them they lie; whether all are on it.
#[apply(vectorized!)]
fn place_near(
    grid: TexelGrid,
    coords: &[TexCoord],
    texels: &mut [u32],
    right: &mut [f32],
    down: &mut [f32],
) -> bool {
    let (width, height) = (grid.width as f32, grid.height as f32);
    let (round_width, round_height) = match grid.tileable {
        true => (width, height),
        false => (0.0, 0.0),
    };
    let mut off = 0;
    let places = texels.iter_mut().zip(right).zip(down);
    for (at, ((texel, right), down)) in coords.iter().zip(places) {
        let below = height - at.t;
        let (row, col) = (floor(below), floor(at.s));
        (*right, *down) = (at.s - col, below - row);
        let row = once_round(row, height, round_height);
        let col = once_round(col, width, round_width);
        let outside = (row < 0.0) | (row >= height) | (col < 0.0) | (col >= width);
        let outside = u32::from(outside).wrapping_neg();
        *texel = (whole_number(row) * grid.width + whole_number(col)) | outside;
        off |= outside;
    }
    off == 0
}

/// Sums of how far right and down in a texel those lie that it holds, and their number.
#[apply(vectorized!)]
fn sums_inside(texels: &[u32], right: &[f32], down: &[f32], texel: u32) -> [f32; 3] {
    let (texels, last) = texels.as_chunks::<LANES>();
    let (right, last_right) = right.as_chunks::<LANES>();
    let (down, last_down) = down.as_chunks::<LANES>();
    let mut sums = [[0.0; LANES]; 3];
    for ((texels, right), down) in texels.iter().zip(right).zip(down) {
        for lane in 0..LANES {
            let held = u32::from(texels[lane] == texel).wrapping_neg();
            let if_held = |number: f32| f32::from_bits(number.to_bits() & held);
            sums[0][lane] += if_held(right[lane]);
            sums[1][lane] += if_held(down[lane]);
            sums[2][lane] += if_held(1.0);
        }
    }
    for (lane, _) in last.iter().enumerate().filter(|(_, held)| **held == texel) {
        sums[0][lane] += last_right[lane];
        sums[1][lane] += last_down[lane];
        sums[2][lane] += 1.0;
    }
    sums.map(|lanes| lanes.iter().sum())
}

/// Added to a number it leaves no bits for a fraction: 1½ · 2²³.
const NO_FRACTION: f32 = 12_582_912.0;

/// ⌊value⌋ of what is smaller than 2²² in size; conversions to integers are not made side by side.
#[inline(always)]
fn floor(value: f32) -> f32 {
    let near = (value + NO_FRACTION) - NO_FRACTION;
    near - if near > value { 1.0 } else { 0.0 }
}

/// A whole number of at least 0 and less than 2²², from the bits of its sum with 2²³.
#[inline(always)]
fn whole_number(value: f32) -> u32 {
    (value + 8_388_608.0).to_bits() & 0x7f_ffff
}

/// A place off a side, `round` back or on.
#[inline(always)]
fn once_round(place: f32, side: f32, round: f32) -> f32 {
    let on = if place < 0.0 { round } else { 0.0 };
    let back = if place >= side { round } else { 0.0 };
    place + on - back
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_coordinate_is_placed_in_the_texel_that_holds_it() {
        for (width, height, tileable) in [(6, 4, true), (6, 4, false), (1, 2, true)] {
            let grid = TexelGrid {
                width,
                height,
                tileable,
            };
            let mut proposals = Proposals::default();
            let coord = |step: u32| TexCoord {
                s: -9.0 + 0.37 * (step % 80) as f32,
                t: -7.0 + 0.29 * (step / 5) as f32,
            };
            for steps in [0..400, 40..47] {
                proposals.clear();
                steps.clone().for_each(|step| proposals.push(coord(step)));
                proposals.place(grid);
                assert_eq!(proposals.len(), steps.len());
                for (proposal, step) in steps.enumerate() {
                    let expected = grid.texel_holding(coord(step)).map(|texel| texel.0);
                    assert_eq!(proposals.texel(proposal), expected);
                }
            }
        }
    }

    #[test]
    fn the_mean_place_is_that_of_the_proposals_a_texel_holds() {
        let grid = TexelGrid {
            width: 6,
            height: 4,
            tileable: true,
        };
        let mut proposals = Proposals::default();
        // Row 1, column 2, and that once round; another texel between.
        for (s, t) in [(2.25, 2.5), (1.75, 2.5), (8.75, 2.75), (2.5, -1.5)] {
            proposals.push(TexCoord { s, t });
        }
        proposals.place(grid);
        let texel = grid.texel(1, 2).0;
        assert_eq!(
            (0..4)
                .filter(|&p| proposals.texel(p) == Some(texel))
                .count(),
            3
        );
        let [right, down] = proposals.mean_inside(texel);
        assert!((right - 0.5).abs() < 1e-6 && (down - (0.5 + 0.25 + 0.5) / 3.0).abs() < 1e-6);
    }
}
