//! A fit in memory: bytes for coefficients, a scale and an offset per term.

use crate::btf::direction::Direction;
use crate::btf::fits::basis::{Basis, MOST_TERMS};

/// How a fit's coefficients make colours.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Colors {
    /// One polynomial per texel, times the texel's colour.
    Lrgb,
    /// One polynomial each for red, green and blue.
    Rgb,
}

/// A fit of every texel, row 0 at the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Fit {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// What the terms are.
    pub basis: Basis,
    /// How the sums make colours.
    pub colors: Colors,
    /// A coefficient is byte · scale + offset, per term.
    pub scale: Vec<f32>,
    /// See `scale`.
    pub offset: Vec<f32>,
    /// Coefficients: `[H, W, terms]` for [`Colors::Lrgb`], `[H, W, 3, terms]` for [`Colors::Rgb`].
    pub coefficients: Vec<u8>,
    /// Colours `[H, W, 3]` of [`Colors::Lrgb`], else empty.
    pub texel_colors: Vec<u8>,
    /// The sum that stands for white: 255 in PTM files, 1 in HSH files.
    pub white: f32,
}

impl Fit {
    /// Texels in all.
    pub fn texels(&self) -> usize {
        self.width as usize * self.height as usize
    }

    /// Bytes of coefficients per texel.
    pub fn coefficients_per_texel(&self) -> usize {
        match self.colors {
            Colors::Lrgb => self.basis.terms(),
            Colors::Rgb => 3 * self.basis.terms(),
        }
    }

    /// The image under a light, as displays take it: [H, W, 3] numbers, 0 black, 1 white, not cut at 1. Sums
    /// below 0 are 0.
    pub fn evaluate(&self, light: Direction, out: &mut [f32]) {
        let weights = Weights::new(self, light);
        let per_texel = self.coefficients_per_texel();
        let texels = self.coefficients.chunks_exact(per_texel);
        match self.colors {
            Colors::Lrgb => {
                let colors = self.texel_colors.chunks_exact(3);
                for ((texel, color), out) in texels.zip(colors).zip(out.chunks_exact_mut(3)) {
                    let luminance = weights.sum(texel) / 255.0;
                    for (out, &byte) in out.iter_mut().zip(color) {
                        *out = f32::from(byte) * luminance;
                    }
                }
            }
            Colors::Rgb => {
                let terms = self.basis.terms();
                for (texel, out) in texels.zip(out.chunks_exact_mut(3)) {
                    for (out, channel) in out.iter_mut().zip(texel.chunks_exact(terms)) {
                        *out = weights.sum(channel);
                    }
                }
            }
        }
    }
}

/// What the bytes of a sum count at one light.
struct Weights {
    of_bytes: [f32; MOST_TERMS],
    constant: f32,
}

impl Weights {
    fn new(fit: &Fit, light: Direction) -> Self {
        let basis = fit.basis.values(light);
        let mut weights = Self {
            of_bytes: [0.0; MOST_TERMS],
            constant: 0.0,
        };
        for (term, &value) in basis[..fit.basis.terms()].iter().enumerate() {
            let value = value / f64::from(fit.white);
            weights.of_bytes[term] = (value * f64::from(fit.scale[term])) as f32;
            weights.constant += (value * f64::from(fit.offset[term])) as f32;
        }
        weights
    }

    /// A sum over white, not below 0.
    fn sum(&self, bytes: &[u8]) -> f32 {
        let products = bytes.iter().zip(&self.of_bytes);
        let sum: f32 = products
            .map(|(&byte, weight)| f32::from(byte) * weight)
            .sum();
        (sum + self.constant).max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_are_multiplied_by_the_luminance() {
        let mut fit = Fit {
            width: 2,
            height: 1,
            basis: Basis::Polynomial,
            colors: Colors::Lrgb,
            scale: vec![1.0, 1.0, 1.0, 2.0, 1.0, 1.0],
            offset: vec![0.0, 0.0, 0.0, -20.0, 0.0, 0.0],
            coefficients: vec![0, 0, 0, 10, 0, 255, 0, 0, 0, 0, 0, 10],
            texel_colors: vec![255, 51, 0, 255, 255, 255],
            white: 255.0,
        };
        let mut out = [0.0; 6];
        fit.evaluate(Direction::from([0.0, 0.0, 1.0]), &mut out);
        assert!((out[0] - 1.0).abs() < 1e-6 && (out[1] - 0.2).abs() < 1e-6 && out[2] == 0.0);
        // The second texel: 10 − 20 u, below 0 from u = 0.5 on.
        fit.evaluate(Direction::from([0.6, 0.0, 0.8]), &mut out);
        assert_eq!(out[3], 0.0);
        fit.evaluate(Direction::from([-0.6, 0.0, 0.8]), &mut out);
        assert!((out[3] - 22.0 / 255.0).abs() < 1e-6);
        fit.colors = Colors::Rgb;
        assert_eq!(fit.coefficients_per_texel(), 18);
    }
}
