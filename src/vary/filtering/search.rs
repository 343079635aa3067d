//! The most similar of all windows of a texture.

use macro_rules_attribute::apply;

use crate::lanes::{LANES, sum_of_lanes, vectorized};

/// A pattern: numbers, and what each weighs.
#[derive(Clone, Debug, Default)]
pub struct Pattern {
    /// Filled up to whole lanes.
    pub numbers: Vec<f32>,
    /// As many.
    pub weights: Vec<f32>,
}

/// The nearest of some windows, its distance and number; `first` are those that are tried before all others,
/// of which the best wins unless another is nearer than its distance over `factor`.
#[apply(vectorized!)]
pub fn nearest(windows: &[f32], pattern: &Pattern, first: &[u32], factor: f32) -> Option<u32> {
    let stride = pattern.numbers.len();
    let window = |pixel: u32| &windows[pixel as usize * stride..][..stride];
    let mut best: Option<(f32, u32)> = None;
    for &pixel in first {
        let limit = best.map_or(f32::INFINITY, |(distance, _)| distance);
        let distance = distance(pattern, window(pixel), limit);
        if distance < limit {
            best = Some((distance, pixel));
        }
    }
    let mut limit = best.map_or(f32::INFINITY, |(distance, _)| distance / factor);
    for (pixel, window) in (0..).zip(windows.chunks_exact(stride)) {
        let distance = distance(pattern, window, limit);
        if distance < limit {
            limit = distance;
            best = Some((distance, pixel));
        }
    }
    best.map(|(_, pixel)| pixel)
}

/// The weighted squared distance, or infinity once it reaches `limit`. Sums run over fixed lanes in fixed order.
#[inline(always)]
fn distance(pattern: &Pattern, window: &[f32], limit: f32) -> f32 {
    let numbers = pattern.numbers.as_chunks::<LANES>().0.iter();
    let weights = pattern.weights.as_chunks::<LANES>().0;
    let mut sum = 0.0;
    for ((numbers, weights), window) in numbers.zip(weights).zip(window.as_chunks::<LANES>().0) {
        let mut squares = [0.0; LANES];
        for lane in 0..LANES {
            let apart = numbers[lane] - window[lane];
            squares[lane] = weights[lane] * (apart * apart);
        }
        sum += sum_of_lanes(squares);
        if sum >= limit {
            return f32::INFINITY;
        }
    }
    sum
}
