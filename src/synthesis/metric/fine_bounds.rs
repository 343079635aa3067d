//! Finer bounds: the coordinates of windows in more directions, as bytes.
//!
//! In noisy images the few directions of a [projection](super::projection) rule out too little: a window of noise
//! is far from all others by about the same distance, most of it in other directions. The coordinates in those are kept
//! as bytes; those of a window fill one cache line. A byte is off by half a step at most, by which the bound is
//! lowered.

use crate::lanes::{LANES, LaneBlock, sum_apart};
use crate::synthesis::metric::projection::{SLACK, Sums};

/// Blocks of finer directions.
pub const FINE_BLOCKS: usize = 3;
/// The largest byte.
const MOST: f32 = i8::MAX as f32;

/// A pattern in the finer directions.
#[derive(Clone, Copy, Debug, Default)]
pub struct FinePattern {
    coordinates: [LaneBlock; FINE_BLOCKS],
    /// The norm of what all directions leave.
    residual: f32,
    /// The squared norm of the whole.
    square: f32,
}

/// A window in the finer directions.
#[repr(C, align(64))]
#[derive(Clone, Copy, Debug, Default)]
pub struct FinePoint {
    steps: [[i8; LANES]; FINE_BLOCKS],
    /// What a step is.
    step: f32,
    /// The norm of what all directions leave.
    residual: f32,
    /// The squared norm of the whole.
    square: f32,
}

impl FinePattern {
    /// A pattern from what it gives block by block, the first directions' first.
    #[inline(always)]
    pub fn new(first: &Sums, fine: &[Sums; FINE_BLOCKS]) -> Self {
        let first = first.projected();
        let coordinates = fine.each_ref().map(|sums| sums.projected().projection.0);
        let mut held = first.projection.0.map(|number| number * number);
        for block in &coordinates {
            for lane in 0..LANES {
                held[lane] += block[lane] * block[lane];
            }
        }
        let square = first.rest.square;
        Self {
            coordinates,
            residual: (square - sum_apart(&held)).max(0.0).sqrt(),
            square,
        }
    }

    /// A lower bound of the distance to a window, of which the first directions make up `first`.
    #[inline(always)]
    pub fn bound(&self, first: f32, point: &FinePoint) -> f32 {
        let (step, half) = (point.step, 0.5 * point.step);
        let mut squares = [0.0; LANES];
        for (coordinates, steps) in self.coordinates.iter().zip(&point.steps) {
            for lane in 0..LANES {
                let apart = (coordinates[lane] - f32::from(steps[lane]) * step).abs() - half;
                let apart = if apart > 0.0 { apart } else { 0.0 };
                squares[lane] += apart * apart;
            }
        }
        let apart = self.residual - point.residual;
        let slack = SLACK * (self.square + point.square);
        first + sum_apart(&squares) + apart * apart - slack
    }
}

impl FinePoint {
    /// Rounds a window's coordinates to bytes.
    pub fn new(window: &FinePattern) -> Self {
        let numbers = window.coordinates.as_flattened();
        let largest = numbers
            .iter()
            .fold(0.0f32, |most, number| most.max(number.abs()));
        let step = (largest / MOST).max(f32::MIN_POSITIVE);
        let round = |number: f32| (number / step).round() as i8;
        Self {
            steps: window.coordinates.map(|block| block.map(round)),
            step,
            residual: window.residual,
            square: window.square,
        }
    }
}
