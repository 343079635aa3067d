//! The sample on its two triangular grids, with a Gaussian and a Laplacian pyramid on each.

use crate::error::{Error, Result};
use crate::grid::TexCoord;
use crate::progress::Progress;
use crate::sites::faces::triangular_grid::{GridTurn, TriangularGrid};
use crate::synthesis::recipes::choosy::face_values::FaceValues;
use crate::synthesis::recipes::choosy::kernel::kernels;
use crate::synthesis::recipes::choosy::value_pyramid::ValuePyramid;

/// A square image, or any numbers on a square of texels.
#[derive(Clone, Copy, Debug)]
pub struct SquareImage<'a> {
    /// Rows and columns.
    pub side: u32,
    /// Numbers per texel.
    pub channels: usize,
    /// The numbers, texel after texel, row after row from the top.
    pub numbers: &'a [f32],
}

impl SquareImage<'_> {
    /// Adds the bilinear mean at a coordinate to a row of zeros; the border's texels are continued outwards.
    fn sample(&self, at: TexCoord, row: &mut [f32]) {
        let last = self.side as usize - 1;
        let split = |along: f32| {
            let along = along.clamp(0.0, last as f32);
            let whole = (along as usize).min(last);
            (whole, (whole + 1).min(last), along - whole as f32)
        };
        let (left, right, across) = split(at.s - 0.5);
        let (top, bottom, down) = split(self.side as f32 - at.t - 0.5);
        for (line, column, weight) in [
            (top, left, (1.0 - down) * (1.0 - across)),
            (top, right, (1.0 - down) * across),
            (bottom, left, down * (1.0 - across)),
            (bottom, right, down * across),
        ] {
            let texel = (line * self.side as usize + column) * self.channels;
            let numbers = &self.numbers[texel..][..self.channels];
            row.iter_mut()
                .zip(numbers)
                .for_each(|(sum, number)| *sum += weight * number);
        }
    }

    /// The texel that a coordinate lies in, the nearest one beyond the border.
    fn nearest(&self, at: TexCoord) -> &[f32] {
        let last = self.side as usize - 1;
        let column = (at.s.max(0.0) as usize).min(last);
        let line = ((self.side as f32 - at.t).max(0.0) as usize).min(last);
        &self.numbers[(line * self.side as usize + column) * self.channels..][..self.channels]
    }
}

/// The grids' turns, in the order in which their pyramids stand.
pub const TURNS: [GridTurn; 2] = [GridTurn::Upright, GridTurn::Quarter];

/// The analysed sample.
#[derive(Clone, Debug, PartialEq)]
pub struct AnalysisSample {
    /// The grid, the same at both turns.
    pub grid: TriangularGrid,
    /// The pyramids on the upright grid and on the turned one.
    pub pyramids: [ValuePyramid; 2],
    /// The texels under the faces of the finest level, on the upright grid and on the turned one.
    pub texels: [FaceValues; 2],
}

impl AnalysisSample {
    /// Analyses a sample. `ratios` has, for every level from the coarsest on, σ over the mean distance of adjacent
    /// faces: that of the [surface](super::kernel::distance_ratio).
    ///
    /// Errors: a side that 2^(levels − 1) does not divide, numbers that are not finite or not as many as stated.
    pub fn new(image: SquareImage<'_>, ratios: &[f64], progress: Progress<'_>) -> Result<Self> {
        check_image(image)?;
        let grid = TriangularGrid::new(image.side, ratios.len() as u32)?;
        let kernels = kernels(&grid.pyramid, ratios);
        let finest = ratios.len() - 1;
        let faces = grid.pyramid.levels[finest].count();
        let pyramid = |turn| {
            let mut values = FaceValues::zeros(faces, image.channels);
            for face in 0..faces {
                image.sample(grid.place(finest, face, turn), values.row_mut(face));
            }
            ValuePyramid::new(&kernels, values, progress)
        };
        let texels = |turn| {
            let mut texels = FaceValues::zeros(faces, image.channels);
            for face in 0..faces {
                let texel = image.nearest(grid.place(finest, face, turn));
                texels.row_mut(face).copy_from_slice(texel);
            }
            texels
        };
        let [upright, turned] = TURNS;
        Ok(Self {
            pyramids: [pyramid(upright)?, pyramid(turned)?],
            texels: TURNS.map(texels),
            grid,
        })
    }
}

fn check_image(image: SquareImage<'_>) -> Result<()> {
    let wanted = (image.side as usize)
        .checked_mul(image.side as usize)
        .and_then(|texels| texels.checked_mul(image.channels));
    if image.channels == 0 || image.side == 0 || wanted != Some(image.numbers.len()) {
        let found = format!(
            "{} numbers, {} per texel",
            image.numbers.len(),
            image.channels
        );
        let side = image.side;
        return Err(Error::data("sample", found).expected(format!("{side} × {side} texels")));
    }
    match image.numbers.iter().position(|number| !number.is_finite()) {
        None => Ok(()),
        Some(at) => {
            let texel = at / image.channels;
            let (row, column) = (texel / image.side as usize, texel % image.side as usize);
            let place = format!("sample, row {row}, column {column}");
            Err(Error::data(place, image.numbers[at].to_string()).expected("a finite number"))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faces_hold_what_the_sample_has_at_their_places() {
        // Linear in both directions, so that bilinear means are exact inside.
        let numbers: Vec<f32> = (0..32 * 32)
            .flat_map(|at| [(at % 32) as f32 + 0.5, 32.0 - (at / 32) as f32 - 0.5])
            .collect();
        let image = SquareImage {
            side: 32,
            channels: 2,
            numbers: &numbers,
        };
        let sample = AnalysisSample::new(image, &[1.2, 1.2], Progress::silent()).unwrap();
        for (turn, pyramid) in TURNS.into_iter().zip(&sample.pyramids) {
            let finest = &pyramid.gaussian[1];
            for face in 0..finest.count() {
                let TexCoord { s, t } = sample.grid.place(1, face, turn);
                let wanted = [s, t].map(|at| at.clamp(0.5, 31.5));
                for (held, wanted) in finest.row(face).iter().zip(wanted) {
                    assert!((held - wanted).abs() < 1e-4);
                }
            }
            assert_eq!(pyramid.gaussian[0].count() * 4, finest.count());
        }
        for (turn, texels) in TURNS.into_iter().zip(&sample.texels) {
            for face in 0..texels.count() {
                let TexCoord { s, t } = sample.grid.place(1, face, turn);
                let row = texels.row(face);
                // The middles of texels, half a texel from a place inside the sample at most.
                assert_eq!(row[0].fract(), 0.5);
                for (held, at) in row.iter().zip([s, t]) {
                    assert!((held - at.clamp(0.0, 32.0)).abs() <= 0.5 + 1e-4);
                }
            }
        }
    }

    #[test]
    fn numbers_that_do_not_fit_are_refused() {
        let analysed = |side, channels, numbers: &[f32]| {
            let image = SquareImage {
                side,
                channels,
                numbers,
            };
            AnalysisSample::new(image, &[1.0], Progress::silent()).map(|_| ())
        };
        assert!(analysed(8, 1, &[0.0; 64]).is_ok());
        assert!(analysed(8, 2, &[0.0; 64]).is_err());
        assert!(analysed(8, 0, &[]).is_err());
        let mut numbers = [0.0; 64];
        numbers[19] = f32::NAN;
        let error = analysed(8, 1, &numbers).unwrap_err().to_string();
        assert!(error.contains("row 2, column 3"), "{error}");
    }
}
