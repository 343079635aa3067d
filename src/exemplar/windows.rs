//! Where the samples of every texel's window lie: the exemplar's feature rows on a padded image,
//! so that a window sample is one addition away from its texel.

use crate::grid::TexelGrid;

/// The windows of all texels of one level, for one list of offsets.
#[derive(Clone, Debug)]
pub struct Windows {
    /// Feature rows of the padded image, `stride` a line.
    rows: Vec<u32>,
    stride: usize,
    width: usize,
    /// Per window sample, how far it lies behind the corner of its texel's padded window.
    deltas: Vec<u32>,
}

impl Windows {
    /// Pads `rows` (one per texel) by the reach of `offsets` ([drow, dcol]): wrapped when the grid is
    /// tileable, else with `default_row`.
    pub fn new(grid: TexelGrid, rows: &[u32], default_row: u32, offsets: &[[i32; 2]]) -> Self {
        let reach = offsets.iter().flatten().map(|o| o.unsigned_abs()).max();
        let pad = i64::from(reach.unwrap_or(0));
        let (height, width) = (i64::from(grid.height), i64::from(grid.width));
        let padded_row = |row: i64, col: i64| {
            let texel = grid.texel_at(row, col);
            texel.map_or(default_row, |texel| rows[texel.index()])
        };
        let lines = -pad..height + pad;
        let padded = lines.flat_map(|row| (-pad..width + pad).map(move |col| (row, col)));
        let stride = width + 2 * pad;
        let delta = |&[drow, dcol]: &[i32; 2]| {
            ((i64::from(drow) + pad) * stride + i64::from(dcol) + pad) as u32
        };
        Self {
            rows: padded.map(|(row, col)| padded_row(row, col)).collect(),
            stride: stride as usize,
            width: width as usize,
            deltas: offsets.iter().map(delta).collect(),
        }
    }

    /// How far each window sample lies behind the start of [`window`](Self::window).
    pub fn deltas(&self) -> &[u32] {
        &self.deltas
    }

    /// The feature rows from the corner of a texel's window on; index them by
    /// [`deltas`](Self::deltas).
    #[inline(always)]
    pub fn window(&self, texel: u32) -> &[u32] {
        &self.rows[self.corner(texel)..]
    }

    /// Where on the padded image a texel's window begins.
    #[inline(always)]
    pub fn corner(&self, texel: u32) -> usize {
        let (row, col) = (texel as usize / self.width, texel as usize % self.width);
        row * self.stride + col
    }

    /// The feature rows of the padded image, line by line.
    pub fn rows(&self) -> &[u32] {
        &self.rows
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::index::TexelIndex;

    const OFFSETS: [[i32; 2]; 4] = [[0, 0], [-2, 1], [1, -2], [2, 2]];

    fn check_against_the_grid(grid: TexelGrid) {
        let rows: Vec<u32> = (0..grid.len() as u32).map(|i| 10 + i).collect();
        let windows = Windows::new(grid, &rows, 7, &OFFSETS);
        for texel in 0..grid.len() as u32 {
            for (&[drow, dcol], &delta) in OFFSETS.iter().zip(windows.deltas()) {
                let there = grid.offset(TexelIndex(texel), drow, dcol);
                let expected = there.map_or(7, |t| 10 + t.0);
                assert_eq!(windows.window(texel)[delta as usize], expected);
            }
        }
    }

    #[test]
    fn windows_read_what_the_grid_holds() {
        for tileable in [false, true] {
            check_against_the_grid(TexelGrid {
                width: 5,
                height: 4,
                tileable,
            });
            check_against_the_grid(TexelGrid {
                width: 1,
                height: 2,
                tileable,
            });
        }
    }
}
