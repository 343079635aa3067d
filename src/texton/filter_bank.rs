//! The 48 filters of Leung and Malik (Leung 2001 §2), sampled as VGG's `makeLMfilters` samples
//! them: 18 edges, 18 bars (3 scales × 6 orientations, first and second Gaussian derivatives,
//! elongated 3 : 1), then four times Gaussian, Laplacian of Gaussian, and Laplacian at 3σ.
//!
//! Out: taps of 49×49, every filter with zero mean and L1 norm 1, y upwards (row 0 is y = +24), to
//! be applied by convolution.

use std::f64::consts::{PI, SQRT_2};

use ndarray::{Array2, Array3, ArrayView2, ArrayViewMut2, Axis, s};

/// Filters in the bank.
pub const FILTERS: usize = 48;
/// Rows and columns of a filter.
pub const SUPPORT: usize = 49;
/// The centre tap's row and column.
pub const CENTRE: usize = SUPPORT / 2;

const ORIENTATIONS: usize = 6;
const ORIENTED_SCALES: usize = 3;
const ORIENTED: usize = ORIENTATIONS * ORIENTED_SCALES;
const ROUND_SCALES: usize = 4;
/// σ along an oriented filter over σ across it.
const ELONGATION: f64 = 3.0;

/// The filter bank's taps, [48, 49, 49].
pub fn leung_malik() -> Array3<f64> {
    let mut bank = Array3::zeros((FILTERS, SUPPORT, SUPPORT));
    for scale in 0..ORIENTED_SCALES {
        for orientation in 0..ORIENTATIONS {
            let (sigma, angle) = (sigma(scale), PI * orientation as f64 / ORIENTATIONS as f64);
            let at = scale * ORIENTATIONS + orientation;
            bank.index_axis_mut(Axis(0), at)
                .assign(&oriented(sigma, angle, first_derivative));
            bank.index_axis_mut(Axis(0), ORIENTED + at)
                .assign(&oriented(sigma, angle, second_derivative));
        }
    }
    for scale in 0..ROUND_SCALES {
        let (sigma, at) = (sigma(scale), 2 * ORIENTED + 3 * scale);
        bank.index_axis_mut(Axis(0), at)
            .assign(&round_gaussian(sigma));
        bank.index_axis_mut(Axis(0), at + 1)
            .assign(&laplacian(sigma));
        bank.index_axis_mut(Axis(0), at + 2)
            .assign(&laplacian(3.0 * sigma));
    }
    bank.outer_iter_mut().for_each(normalise);
    bank
}

/// √2, 2, 2√2, 4 texels. (The precision of `powi` depends on how it is compiled, that of `powf` does not.)
fn sigma(scale: usize) -> f64 {
    SQRT_2.powf((scale + 1) as f64)
}

/// Samples a function of (x, y), y upwards, in texels from the centre.
fn sampled(f: impl Fn(f64, f64) -> f64) -> Array2<f64> {
    Array2::from_shape_fn((SUPPORT, SUPPORT), |(row, col)| {
        f(col as f64 - CENTRE as f64, CENTRE as f64 - row as f64)
    })
}

/// A Gaussian along the turned x axis times a derivative of one along the turned y axis.
fn oriented(sigma: f64, angle: f64, derivative: impl Fn(f64, f64) -> f64) -> Array2<f64> {
    let (sin, cos) = angle.sin_cos();
    sampled(|x, y| {
        let (along, across) = (cos * x - sin * y, sin * x + cos * y);
        gaussian(ELONGATION * sigma, along) * derivative(sigma, across)
    })
}

fn gaussian(sigma: f64, x: f64) -> f64 {
    let twice_variance = 2.0 * sigma * sigma;
    (-x * x / twice_variance).exp() / (PI * twice_variance).sqrt()
}

fn first_derivative(sigma: f64, x: f64) -> f64 {
    -gaussian(sigma, x) * x / (sigma * sigma)
}

fn second_derivative(sigma: f64, x: f64) -> f64 {
    let variance = sigma * sigma;
    gaussian(sigma, x) * (x * x - variance) / (variance * variance)
}

/// A Gaussian of sum 1, cut where it falls below ε times its peak.
fn round_gaussian(sigma: f64) -> Array2<f64> {
    let mut taps = sampled(|x, y| (-(x * x + y * y) / (2.0 * sigma * sigma)).exp());
    taps.mapv_inplace(|v| if v < f64::EPSILON { 0.0 } else { v });
    let sum = taps.sum();
    taps / sum
}

/// The Laplacian of [`round_gaussian`].
fn laplacian(sigma: f64) -> Array2<f64> {
    let variance = sigma * sigma;
    round_gaussian(sigma) * sampled(|x, y| (x * x + y * y - 2.0 * variance) / (variance * variance))
}

/// Zero mean, then L1 norm 1.
fn normalise(mut taps: ArrayViewMut2<'_, f64>) {
    let mean = taps.sum() / taps.len() as f64;
    taps -= mean;
    let norm = taps.iter().map(|v| v.abs()).sum::<f64>();
    taps /= norm;
}

/// Whether a filter is odd about its centre, f(−v) = −f(v); all others of the bank are even.
pub fn is_odd(taps: ArrayView2<'_, f64>) -> bool {
    let mirrored = taps.slice(s![..;-1, ..;-1]);
    taps.iter().zip(&mirrored).map(|(a, b)| a * b).sum::<f64>() < 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_filter_has_zero_mean_and_unit_l1_norm() {
        for taps in leung_malik().outer_iter() {
            assert!(taps.sum().abs() < 1e-14);
            assert!((taps.iter().map(|v| v.abs()).sum::<f64>() - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn order_and_signs_are_those_of_vgg() {
        let bank = leung_malik();
        let at =
            |filter: usize, x: i32, y: i32| bank[[filter, (24 - y) as usize, (24 + x) as usize]];
        // Edge 0: derivative along y, negative above the centre.
        assert!(at(0, 0, 1) < 0.0 && at(0, 0, -1) > 0.0 && at(0, 0, 0).abs() < 1e-15);
        // Orientation 3 turns by 90°: the derivative runs along x.
        assert!(at(3, 1, 0) < 0.0 && (at(3, 1, 0) - at(0, 0, 1)).abs() < 1e-12);
        // Bars: negative at the centre, as ∂²G.
        assert!(at(18, 0, 0) < 0.0 && at(18, 0, 4) > 0.0);
        // Gaussian, LoG, LoG at 3σ, four times, with growing σ.
        for scale in 0..4 {
            assert!(at(36 + 3 * scale, 0, 0) > 0.0);
            assert!(at(37 + 3 * scale, 0, 0) < at(38 + 3 * scale, 0, 0));
            assert!(at(38 + 3 * scale, 0, 0) < 0.0);
        }
        assert!(at(36, 0, 0) > at(39, 0, 0) && at(39, 0, 0) > at(42, 0, 0));
        // Orientation 1 is at 30°, rotated as [c −s; s c] acting on the points.
        let (x, y) = (3.0, 2.0);
        let (sin, cos) = (PI / 6.0).sin_cos();
        let direct =
            gaussian(3.0 * SQRT_2, cos * x - sin * y) * first_derivative(SQRT_2, sin * x + cos * y);
        let ratio = direct / at(1, 3, 2);
        let again = gaussian(3.0 * SQRT_2, -sin * 1.0) * first_derivative(SQRT_2, cos * 1.0);
        assert!((again / at(1, 0, 1) / ratio - 1.0).abs() < 1e-9);
    }

    #[test]
    fn edges_are_odd_and_all_others_even() {
        let bank = leung_malik();
        for (filter, taps) in bank.outer_iter().enumerate() {
            assert_eq!(is_odd(taps), filter < ORIENTED);
            let sign = if is_odd(taps) { -1.0 } else { 1.0 };
            for ((row, col), v) in taps.indexed_iter() {
                assert!((v - sign * taps[[48 - row, 48 - col]]).abs() < 1e-15);
            }
        }
    }
}
