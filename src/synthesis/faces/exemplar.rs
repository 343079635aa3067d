//! The square of an exemplar that choosy sampling analyses.
//!
//! Plain images are used as distances compare them: each number times the root of its channel's weight, colours by the
//! sRGB curve. Textons are used as vectors whose distances are those of Φ (the embedded metric). Only the finest level
//! of the space counts: the pyramids are those of the faces.

use crate::exemplar::dense_windows::flat_vectors;
use crate::exemplar::embedding::Embedding;
use crate::exemplar::level::feature_rows;
use crate::exemplar::space::{Features, Space};
use crate::maps::face_map::Square;
use crate::synthesis::recipes::choosy::SquareImage;
use crate::synthesis::recipes::choosy::recipe::MOST_CHANNELS;

/// A square of texels and their numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct SquareExemplar {
    /// Where it lies on the sample: in the middle.
    pub square: Square,
    /// Numbers per texel.
    pub channels: usize,
    /// Share of Φ's spectrum that the numbers keep; 1 for plain images.
    pub kept: f64,
    numbers: Vec<f32>,
}

impl SquareExemplar {
    /// A square of this many rows and columns, no more than the sample has. Of textons a share `spectrum` of Φ's
    /// spectrum is kept, but no more numbers than choosy sampling takes.
    pub fn new(space: &Space, side: u32, spectrum: f64) -> Self {
        let grid = space.levels[0].grid;
        let square = Square {
            left: (grid.width - side) / 2,
            top: (grid.height - side) / 2,
            side,
        };
        let vectors = Vectors::of_finest(space, spectrum);
        let mut numbers = Vec::with_capacity(side as usize * side as usize * vectors.used.len());
        for row in square.top..square.top + side {
            for column in square.left..square.left + side {
                let texel = grid.texel(row, column).index();
                let first = vectors.rows[texel] as usize * vectors.length;
                let of_texel = &vectors.numbers[first..first + vectors.length];
                numbers.extend(vectors.used.iter().map(|&at| of_texel[at]));
            }
        }
        Self {
            square,
            channels: vectors.used.len(),
            kept: vectors.kept,
            numbers,
        }
    }

    /// The square as it is analysed.
    pub fn image(&self) -> SquareImage<'_> {
        SquareImage {
            side: self.square.side,
            channels: self.channels,
            numbers: &self.numbers,
        }
    }
}

/// The feature vectors of a level.
struct Vectors {
    /// The vector of each texel.
    rows: Vec<u32>,
    /// Numbers of a vector.
    length: usize,
    /// Those that count.
    used: Vec<usize>,
    numbers: Vec<f32>,
    kept: f64,
}

impl Vectors {
    fn of_finest(space: &Space, spectrum: f64) -> Self {
        let level = &space.levels[0];
        let rows = feature_rows(level);
        if let Features::Plain(features) = &level.features {
            let length = features.dim().2;
            let weightless = space.channels.list().iter();
            let weightless: Vec<usize> = weightless
                .filter(|channel| channel.weight == 0.0)
                .flat_map(|channel| channel.numbers())
                .collect();
            return Self {
                rows,
                length,
                used: (0..length).filter(|at| !weightless.contains(at)).collect(),
                numbers: features.iter().copied().collect(),
                kept: 1.0,
            };
        }
        let embedding = Embedding::new(level, spectrum);
        let numbers = flat_vectors(&embedding);
        let used: Vec<usize> = (0..embedding.dimensions.min(MOST_CHANNELS)).collect();
        Self {
            kept: embedding.kept * share_of(&numbers, embedding.dimensions, used.len()),
            rows,
            length: embedding.dimensions,
            used,
            numbers,
        }
    }
}

/// The share of the squares of all numbers that the leading ones of every vector have.
fn share_of(numbers: &[f32], length: usize, leading: usize) -> f64 {
    let squares = |count: usize| -> f64 {
        let vectors = numbers.chunks_exact(length.max(1));
        let leading = vectors.flat_map(|vector| &vector[..count]);
        leading.map(|&number| f64::from(number).powi(2)).sum()
    };
    let all = squares(length);
    if all > 0.0 {
        squares(leading) / all
    } else {
        1.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthesis::tests::fixtures;

    #[test]
    fn the_square_lies_in_the_middle() {
        let (space, _) = fixtures::random_exemplar(3, 8, 1, true);
        let whole = SquareExemplar::new(&space, 8, 1.0);
        let part = SquareExemplar::new(&space, 5, 1.0);
        let Square { left, top, side } = part.square;
        assert_eq!([left, top, side], [1, 1, 5]);
        assert!((whole.kept - 1.0).abs() < 1e-6);
        for row in 0..5 {
            let first = ((row + 1) * 8 + 1) * whole.channels;
            let of_whole = &whole.image().numbers[first..][..5 * whole.channels];
            let of_part = &part.image().numbers[row * 5 * part.channels..][..5 * part.channels];
            assert_eq!(of_part, of_whole);
        }
    }

    #[test]
    fn fewer_numbers_have_a_smaller_share() {
        assert_eq!(share_of(&[3.0, 1.0, -1.0, 1.0], 2, 1), 10.0 / 12.0);
        assert_eq!(share_of(&[0.0; 4], 2, 1), 1.0);
    }
}
