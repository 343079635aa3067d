//! Where a pixel's samples lie, in 1/256 pixel from its upper left corner.
//!
//! Colour and coverage are the mean over the pattern's samples. One more sample stands in the
//! pixel's centre for the other layers (depth, normals, labels), so that they hold what a ray
//! through the centre meets.

use serde::Serialize;

/// Fixed-point steps in a pixel.
pub const SUBPIXEL: i32 = 256;

/// Samples per pixel for antialiasing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, clap::ValueEnum)]
pub enum Samples {
    /// The centre alone: no antialiasing.
    #[value(name = "1")]
    #[serde(rename = "1")]
    One,
    /// A rotated grid.
    #[default]
    #[value(name = "4")]
    #[serde(rename = "4")]
    Four,
    /// One in each of 8 rows and columns.
    #[value(name = "8")]
    #[serde(rename = "8")]
    Eight,
    /// One in each of 16 rows and columns.
    #[value(name = "16")]
    #[serde(rename = "16")]
    Sixteen,
}

/// Offsets in 1/16 pixel from the pixel's centre: no two share a row or a column.
const FOUR: [[i32; 2]; 4] = [[-2, -6], [6, -2], [-6, 2], [2, 6]];
const EIGHT: [[i32; 2]; 8] = [
    [1, -3],
    [-1, 3],
    [5, 1],
    [-3, -5],
    [-5, 5],
    [-7, -1],
    [3, 7],
    [7, -7],
];
const SIXTEEN: [[i32; 2]; 16] = [
    [1, 1],
    [-1, -3],
    [-3, 2],
    [4, -1],
    [-5, -2],
    [2, 5],
    [5, 3],
    [3, -5],
    [-2, 6],
    [0, -7],
    [-4, -6],
    [-6, 4],
    [-8, 0],
    [7, -4],
    [6, 7],
    [-7, -8],
];

impl Samples {
    /// Samples that colour and coverage are the mean of.
    pub fn count(self) -> usize {
        match self {
            Self::One => 1,
            Self::Four => 4,
            Self::Eight => 8,
            Self::Sixteen => 16,
        }
    }

    /// Samples kept for each pixel: those of colour and, last, the centre.
    pub fn stored(self) -> usize {
        match self {
            Self::One => 1,
            _ => self.count() + 1,
        }
    }

    /// Positions of the stored samples; the last is the centre.
    pub(super) fn positions<const STORED: usize>(self) -> [[i32; 2]; STORED] {
        let pattern: &[[i32; 2]] = match self {
            Self::One => &[],
            Self::Four => &FOUR,
            Self::Eight => &EIGHT,
            Self::Sixteen => &SIXTEEN,
        };
        let centre = [SUBPIXEL / 2; 2];
        let mut positions = [centre; STORED];
        for (position, offset) in positions.iter_mut().zip(pattern) {
            *position = [0, 1].map(|axis| centre[axis] + offset[axis] * SUBPIXEL / 16);
        }
        positions
    }

    /// Where the colour samples lie, in pixels from the pixel's upper left corner.
    pub fn offsets(self) -> Vec<[f64; 2]> {
        let positions = self.positions::<17>();
        let pixels = |at: [i32; 2]| at.map(|k| f64::from(k) / f64::from(SUBPIXEL));
        positions[..self.count()]
            .iter()
            .map(|at| pixels(*at))
            .collect()
    }

    /// The colour samples, nearest to the pixel's centre first.
    pub(super) fn by_distance(self) -> Vec<usize> {
        let positions = self.positions::<17>();
        let mut order: Vec<usize> = (0..self.count()).collect();
        order.sort_by_key(|&sample| {
            let [x, y] = positions[sample].map(|v| v - SUBPIXEL / 2);
            x * x + y * y
        });
        order
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patterns_hit_every_row_and_column_once() {
        for samples in [Samples::Four, Samples::Eight, Samples::Sixteen] {
            let positions = samples.positions::<17>();
            let count = samples.count() as i32;
            for axis in [0, 1] {
                let mut cells: Vec<i32> = positions[..samples.count()]
                    .iter()
                    .map(|p| p[axis] * count / SUBPIXEL)
                    .collect();
                cells.sort_unstable();
                assert_eq!(cells, (0..count).collect::<Vec<_>>(), "{samples:?}");
            }
            assert_eq!(positions[samples.count()], [128, 128]);
        }
    }
}
