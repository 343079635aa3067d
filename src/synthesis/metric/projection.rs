//! Windows projected on a few orthonormal directions, and how far apart two of them are at least.

use crate::lanes::{LANES, LaneBlock, sum_of_lanes};

/// Directions projected on.
pub const DIRECTIONS: usize = LANES;
/// Sums that a projection is added up in side by side.
const CHAINS: usize = 4;
/// Share of both windows' squared norms by which a bound is lowered, against the rounding of single
/// precision: directions, projections and residuals are each good to some 1e-6 of them.
pub const SLACK: f32 = 2e-5;

/// What a window gives in every direction, aligned as processors load it fastest.
#[repr(C, align(64))]
#[derive(Clone, Copy, Debug, Default)]
pub struct Projection(pub LaneBlock);

/// What the directions leave of a window.
#[derive(Clone, Copy, Debug, Default)]
pub struct Residual {
    /// The norm of what is left.
    pub residual: f32,
    /// The squared norm of the whole.
    pub square: f32,
}

/// A projected pattern.
#[derive(Clone, Copy, Debug, Default)]
pub struct Projected {
    /// What it gives in every direction.
    pub projection: Projection,
    /// What the directions leave of it.
    pub rest: Residual,
}

impl Projected {
    /// A lower bound of the distance to a window.
    #[inline(always)]
    pub fn bound(&self, projection: &Projection, rest: Residual) -> f32 {
        let mut squares = [0.0; LANES];
        for (lane, square) in squares.iter_mut().enumerate() {
            let apart = self.projection.0[lane] - projection.0[lane];
            *square = apart * apart;
        }
        let apart = self.rest.residual - rest.residual;
        let slack = SLACK * (self.rest.square + rest.square);
        sum_of_lanes(squares) + apart * apart - slack
    }
}

/// What numbers give in every direction, and their weighted squares, while they are summed.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sums {
    shares: [LaneBlock; CHAINS],
    squares: LaneBlock,
}

impl Sums {
    #[inline(always)]
    /// Adds numbers, with their rows of the basis and their weights.
    pub fn add(&mut self, basis: &[LaneBlock], weights: &[f32], numbers: &[f32]) {
        let basis = basis.as_chunks::<LANES>().0;
        let weights = weights.as_chunks::<LANES>().0;
        let blocks = numbers.as_chunks::<LANES>().0.iter().zip(weights);
        for ((numbers, weights), rows) in blocks.zip(basis) {
            for lane in 0..LANES {
                self.squares[lane] += weights[lane] * (numbers[lane] * numbers[lane]);
            }
            for (at, (number, row)) in numbers.iter().zip(rows).enumerate() {
                let shares = &mut self.shares[at % CHAINS];
                for lane in 0..LANES {
                    shares[lane] += number * row[lane];
                }
            }
        }
    }

    #[inline(always)]
    /// The projection of what was added.
    pub fn projected(&self) -> Projected {
        let [a, b, c, d] = &self.shares;
        let (mut shares, mut held) = ([0.0; LANES], [0.0; LANES]);
        for lane in 0..LANES {
            shares[lane] = (a[lane] + b[lane]) + (c[lane] + d[lane]);
            held[lane] = shares[lane] * shares[lane];
        }
        let square = sum_of_lanes(self.squares);
        Projected {
            projection: Projection(shares),
            rest: Residual {
                residual: (square - sum_of_lanes(held)).max(0.0).sqrt(),
                square,
            },
        }
    }
}
