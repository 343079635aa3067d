//! A basis in which every filter is diagonal, exactly, at either border.
//!
//! A convolution on a wrapped image is circular. On an image that is reflected with its edge
//! repeated, as often as needed, it is circular too, on the image's even continuation of twice the
//! size. In both cases the image is a sum of waves e(x) = α cos θ(x), θ(x) = ω(x + h) − φ, along
//! each axis, and a filter f turns a wave into a weighted sum of itself and its quadrature
//! o(x) = α sin θ(x):
//!
//! Σ_v f(v) e(x − v) = e(x) Σ f(v) cos ωv + o(x) Σ f(v) sin ωv.
//!
//! - wrapped: the real Fourier basis (h = 0, φ = 0 or π/2, ω = 2πj/n);
//! - reflected: the cosine basis DCT-II (h = ½, φ = 0, ω = πk/n).
//!
//! So F_f = Σ_p S_p diag(d_{f,p}) A with A the orthonormal analysis, p the four parities
//! (even or odd along y and x), S_p the waves or their quadratures and d_{f,p} sums over the taps.
//! Sides are short, so the transforms are dense matrix products.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use ndarray::{Array2, Array3, ArrayView2};
use rayon::prelude::*;

use crate::grid::TexelGrid;
use crate::matrix::{Update, as_rows, as_rows_mut, multiply, product_of};
use crate::texton::filter_bank::CENTRE;

/// Even or odd along one axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Parity {
    /// The waves themselves.
    Even,
    /// Their quadratures.
    Odd,
}

/// Even and odd, in the order that indices use.
pub const PARITIES: [Parity; 2] = [Parity::Even, Parity::Odd];

/// Parities along y and x, [ee, eo, oe, oo].
pub const PLANE_PARITIES: [[Parity; 2]; 4] = [
    [Parity::Even, Parity::Even],
    [Parity::Even, Parity::Odd],
    [Parity::Odd, Parity::Even],
    [Parity::Odd, Parity::Odd],
];

/// One wave of an axis.
struct Wave {
    /// ω, radians a texel.
    frequency: f64,
    /// φ, radians.
    phase: f64,
    /// α, which makes the waves orthonormal.
    amplitude: f64,
}

/// The waves of one axis and their quadratures.
pub struct AxisBasis {
    /// ω of every wave, radians a texel.
    frequencies: Vec<f64>,
    /// S_e [texels, waves]; its transpose is the analysis A.
    even: Array2<f32>,
    /// S_o [texels, waves].
    odd: Array2<f32>,
}

impl AxisBasis {
    /// The basis of an axis of `side` texels.
    pub fn new(side: usize, wraps: bool) -> Self {
        let waves = if wraps { fourier(side) } else { cosines(side) };
        let shift = if wraps { 0.0 } else { 0.5 };
        let sampled = |f: fn(f64) -> f64| {
            Array2::from_shape_fn((side, side), |(x, k)| {
                let wave = &waves[k];
                let angle = wave.frequency * (x as f64 + shift) - wave.phase;
                (wave.amplitude * f(angle)) as f32
            })
        };
        Self {
            frequencies: waves.iter().map(|wave| wave.frequency).collect(),
            even: sampled(f64::cos),
            odd: sampled(f64::sin),
        }
    }

    /// S of one parity, [texels, waves].
    pub fn synthesis(&self, parity: Parity) -> ArrayView2<'_, f32> {
        match parity {
            Parity::Even => self.even.view(),
            Parity::Odd => self.odd.view(),
        }
    }

    /// A, [waves, texels].
    pub fn analysis(&self) -> ArrayView2<'_, f32> {
        self.even.t()
    }

    /// cos ωv or sin ωv, [taps, waves].
    fn tap_waves(&self, parity: Parity, taps: usize) -> Array2<f64> {
        Array2::from_shape_fn((taps, self.frequencies.len()), |(tap, k)| {
            let angle = self.frequencies[k] * (tap as f64 - CENTRE as f64);
            match parity {
                Parity::Even => angle.cos(),
                Parity::Odd => angle.sin(),
            }
        })
    }
}

/// 1, then cos and sin of ω = 2πj/n in turn; for an even side the last is the alternating wave.
fn fourier(side: usize) -> Vec<Wave> {
    let n = side as f64;
    (0..side)
        .map(|k| {
            let j = k.div_ceil(2);
            let single = j == 0 || 2 * j == side;
            Wave {
                frequency: TAU * j as f64 / n,
                phase: if k % 2 == 0 && !single {
                    FRAC_PI_2
                } else {
                    0.0
                },
                amplitude: if single { n.recip() } else { 2.0 / n }.sqrt(),
            }
        })
        .collect()
}

fn cosines(side: usize) -> Vec<Wave> {
    let n = side as f64;
    (0..side)
        .map(|k| Wave {
            frequency: PI * k as f64 / n,
            phase: 0.0,
            amplitude: if k == 0 { n.recip() } else { 2.0 / n }.sqrt(),
        })
        .collect()
}

/// The basis of a texel grid: waves along y times waves along x, index ky · W + kx.
pub struct FilterEigenbasis {
    /// The texel grid.
    pub grid: TexelGrid,
    /// Waves along the columns of texels, from row to row.
    pub y: AxisBasis,
    /// Waves along the rows.
    pub x: AxisBasis,
}

impl FilterEigenbasis {
    /// The basis of a grid: wrapped when it is tileable, else reflected.
    pub fn new(grid: TexelGrid) -> Self {
        Self {
            grid,
            y: AxisBasis::new(grid.height as usize, grid.tileable),
            x: AxisBasis::new(grid.width as usize, grid.tileable),
        }
    }

    /// Rows and columns of the grid.
    pub fn sides(&self) -> (usize, usize) {
        (self.grid.height as usize, self.grid.width as usize)
    }

    /// The coefficients of images, H·W numbers each, one after another.
    pub fn coefficients(&self, images: &[f32]) -> Vec<f32> {
        let (height, width) = self.sides();
        let texels = height * width;
        let mut coefficients = vec![0.0; images.len()];
        coefficients
            .par_chunks_mut(texels)
            .zip(images.par_chunks(texels))
            .for_each(|(waves, image)| {
                let along_x = product_of(as_rows(image, height, width), self.x.analysis().t());
                let waves = as_rows_mut(waves, height, width);
                multiply(self.y.analysis(), along_x.view(), waves, Update::Replace);
            });
        coefficients
    }

    /// d_{f,p} of every filter of a bank [filters, taps, taps].
    pub fn transfer(&self, bank: &Array3<f64>) -> Transfer {
        let factors = PLANE_PARITIES.map(|parities| self.transfer_of(bank, parities));
        Transfer { factors }
    }

    fn transfer_of(&self, bank: &Array3<f64>, [y, x]: [Parity; 2]) -> Array2<f32> {
        let (filters, taps, _) = bank.dim();
        let (waves_y, waves_x) = (self.y.tap_waves(y, taps), self.x.tap_waves(x, taps));
        let mut factors = Array2::zeros((filters, self.grid.len()));
        for (filter, mut row) in bank.outer_iter().zip(factors.outer_iter_mut()) {
            let plane = waves_y.t().dot(&filter.dot(&waves_x));
            row.iter_mut().zip(&plane).for_each(|(d, &v)| *d = v as f32);
        }
        // Rounding where a filter has none of this parity; the constant wave passes no filter.
        factors.mapv_inplace(|d: f32| if d.abs() < NEGLIGIBLE { 0.0 } else { d });
        factors
    }
}

/// Below this a transfer factor is rounding: the taps' absolute values sum to 1.
const NEGLIGIBLE: f32 = 1e-9;

/// The filters as factors of the basis' waves.
pub struct Transfer {
    /// d_{f,p}: for each of [`PLANE_PARITIES`] [filters, waves].
    factors: [Array2<f32>; 4],
}

impl Transfer {
    /// d of one parity (index into [`PLANE_PARITIES`]), [filters, waves].
    pub fn factors(&self, parity: usize) -> ArrayView2<'_, f32> {
        self.factors[parity].view()
    }

    /// The filters that have both parities.
    pub fn filters_with(&self, p: usize, q: usize) -> Vec<usize> {
        let has = |parity: usize, filter: usize| {
            self.factors[parity].row(filter).iter().any(|&d| d != 0.0)
        };
        (0..self.factors[0].nrows())
            .filter(|&f| has(p, f) && has(q, f))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::texton::filter_bank::leung_malik;
    use crate::texton::oracle;

    /// Σ_p S_p diag(d_{f,p}) A I, the route of this file, image by image.
    fn responses(basis: &FilterEigenbasis, bank: &Array3<f64>, image: &[f32]) -> Array2<f32> {
        let (height, width) = basis.sides();
        let coefficients = basis.coefficients(image);
        let transfer = basis.transfer(bank);
        let mut out = Array2::zeros((bank.dim().0, basis.grid.len()));
        for (filter, mut row) in out.outer_iter_mut().enumerate() {
            for (p, [y, x]) in PLANE_PARITIES.into_iter().enumerate() {
                let weighted: Vec<f32> = coefficients
                    .iter()
                    .zip(transfer.factors(p).row(filter))
                    .map(|(c, d)| c * d)
                    .collect();
                let plane = as_rows(&weighted, height, width);
                let along_x = plane.dot(&basis.x.synthesis(x).t());
                let texels = basis.y.synthesis(y).dot(&along_x);
                row.iter_mut().zip(&texels).for_each(|(r, v)| *r += v);
            }
        }
        out
    }

    #[test]
    fn diagonal_filters_are_convolutions_at_both_borders_and_any_side() {
        let bank = leung_malik();
        for (height, width) in [(8, 12), (7, 5), (1, 9), (26, 30)] {
            for tileable in [true, false] {
                let grid = TexelGrid {
                    width,
                    height,
                    tileable,
                };
                let image: Vec<f32> = (0..grid.len())
                    .map(|i| ((i * 7919) % 101) as f32 / 101.0)
                    .collect();
                let fast = responses(&FilterEigenbasis::new(grid), &bank, &image);
                let slow = oracle::responses(grid, &bank, &image);
                for (a, b) in fast.iter().zip(&slow) {
                    assert!(
                        (f64::from(*a) - b).abs() < 2e-6,
                        "{grid:?}: {a} against {b}"
                    );
                }
            }
        }
    }

    #[test]
    fn the_waves_are_orthonormal() {
        for side in [1, 2, 5, 8] {
            for wraps in [true, false] {
                let basis = AxisBasis::new(side, wraps);
                let gram = basis.analysis().dot(&basis.analysis().t());
                for ((i, j), v) in gram.indexed_iter() {
                    let expected = if i == j { 1.0 } else { 0.0 };
                    assert!((v - expected).abs() < 1e-6);
                }
            }
        }
    }
}
