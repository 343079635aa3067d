//! The coordinates that a site and its neighbours propose, and the texels that hold them: as lists of
//! numbers, so that all are placed in a few vector instructions.

use crate::grid::{TexCoord, TexelGrid};

/// Proposed coordinates in the order they came.
#[derive(Clone, Debug, Default)]
pub struct Proposals {
    coords: Vec<TexCoord>,
    /// The texel that holds each, or [`NOWHERE`](Self::NOWHERE).
    pub texels: Vec<u32>,
    /// How far right and down in its texel each lies.
    pub right: Vec<f32>,
    /// As `right`, downwards.
    pub down: Vec<f32>,
}

impl Proposals {
    /// The texel of a coordinate off the grid.
    pub const NOWHERE: u32 = u32::MAX;

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
        self.texels.resize(count, 0);
        self.right.resize(count, 0.0);
        self.down.resize(count, 0.0);
        let (width, height) = (grid.width as i32, grid.height as i32);
        let insides = self.right.iter_mut().zip(&mut self.down);
        let mut off = false;
        for ((at, texel), (right, down)) in self.coords.iter().zip(&mut self.texels).zip(insides) {
            let below = grid.height as f32 - at.t;
            let (row, col) = (floor(below), floor(at.s));
            (*right, *down) = (at.s - col as f32, below - row as f32);
            let (row, col) = match grid.tileable {
                true => (once_round(row, height), once_round(col, width)),
                false => (row, col),
            };
            let on_grid = (row >= 0) & (row < height) & (col >= 0) & (col < width);
            *texel = if on_grid {
                (row * width + col) as u32
            } else {
                Self::NOWHERE
            };
            off |= !on_grid;
        }
        // Windows wider than the grid itself reach further than once round it.
        if off && grid.tileable {
            for (at, texel) in self.coords.iter().zip(&mut self.texels) {
                *texel = grid
                    .texel_holding(*at)
                    .map_or(Self::NOWHERE, |texel| texel.0);
            }
        }
    }
}

/// ⌊value⌋ of what fits.
#[inline(always)]
fn floor(value: f32) -> i32 {
    let whole = value as i32;
    whole - i32::from(whole as f32 > value)
}

/// A place at most once round a circle away, on the circle.
#[inline(always)]
fn once_round(place: i32, side: i32) -> i32 {
    let up = if place < 0 { side } else { 0 };
    let down = if place >= side { side } else { 0 };
    place + up - down
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
            (0..400).for_each(|step| proposals.push(coord(step)));
            proposals.place(grid);
            for step in 0..400 {
                let (at, found) = (coord(step), proposals.texels[step as usize]);
                let expected = grid.texel_holding(at);
                assert_eq!(found, expected.map_or(Proposals::NOWHERE, |texel| texel.0));
                if let Some(texel) = expected {
                    let corner = grid.centre(texel);
                    let [right, down] =
                        [&proposals.right, &proposals.down].map(|d| d[step as usize]);
                    let back = TexCoord {
                        s: corner.s - 0.5 + right,
                        t: corner.t + 0.5 - down,
                    };
                    let (ds, dt) = grid.difference(at, back);
                    assert!(ds.abs() < 1e-5 && dt.abs() < 1e-5, "{at:?} {back:?}");
                }
            }
            proposals.clear();
            proposals.push(coord(0));
            proposals.place(grid);
            assert_eq!(proposals.texels.len(), 1);
        }
    }
}
