//! Coefficients rounded to bytes, term after term, those first whose rounding changes sums most. What rounding takes
//! from one term, the terms behind it make up for as well as they can at the lights of the capture.

use nalgebra::DVector;

use crate::btf::fits::normal_equations::NormalEquations;
use crate::error::Result;

/// The largest byte.
const MOST: f64 = 255.0;

/// The scale and offset of each term, and how its rounding is made up for.
#[derive(Debug)]
pub(super) struct Quantization {
    pub(super) scale: Vec<f32>,
    pub(super) offset: Vec<f32>,
    /// The terms in the order in which they are rounded.
    order: Vec<usize>,
    /// Per place in the order.
    carries: Vec<DVector<f64>>,
}

impl Quantization {
    /// For coefficients within these ranges. Offsets are whole numbers of steps, 0 to 255, as PTM files have
    /// them; so every range is widened to hold 0.
    pub(super) fn new(equations: &NormalEquations, ranges: &[(f64, f64)]) -> Result<Self> {
        let (mut scale, mut offset) = (Vec::new(), Vec::new());
        for &(low, high) in ranges {
            let (low, high) = (low.min(0.0), high.max(0.0));
            // One step less than bytes have: rounding the offset takes up to half a step on either side.
            let step = ((high - low) / (MOST - 1.0)).max(1e-6) as f32;
            let bias = (-low / f64::from(step)).round().clamp(0.0, MOST) as f32;
            scale.push(step);
            offset.push(-bias * step);
        }
        let change =
            |term: &usize| f64::from(scale[*term]).powi(2) * equations.gram[(*term, *term)];
        let mut order: Vec<usize> = (0..scale.len()).collect();
        order.sort_by(|a, b| change(b).total_cmp(&change(a)));
        let carries = equations.carries(&order)?;
        Ok(Self {
            scale,
            offset,
            order,
            carries,
        })
    }

    /// Rounds a sum's coefficients into bytes; hands back what the bytes stand for.
    pub(super) fn round(&self, coefficients: &DVector<f64>, bytes: &mut [u8]) -> DVector<f64> {
        let mut wanted = coefficients.clone();
        let mut stored = coefficients.clone();
        for (place, &term) in self.order.iter().enumerate() {
            let (scale, offset) = (f64::from(self.scale[term]), f64::from(self.offset[term]));
            bytes[term] = ((wanted[term] - offset) / scale).round().clamp(0.0, MOST) as u8;
            stored[term] = f64::from(bytes[term]) * scale + offset;
            let lost = wanted[term] - stored[term];
            for (&behind, carry) in self.order[place + 1..]
                .iter()
                .zip(self.carries[place].iter())
            {
                wanted[behind] += carry * lost;
            }
        }
        stored
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::btf::direction::Direction;
    use crate::btf::fits::basis::Basis;

    #[test]
    fn carrying_is_better_than_rounding_alone() {
        let lights: Vec<Direction> = (0..60)
            .map(|k| Direction::from_angles(0.02 * f64::from(k), 2.4 * f64::from(k)))
            .collect();
        let equations = NormalEquations::new(Basis::Polynomial, &lights).unwrap();
        let ranges = [
            (-90.0, 20.0),
            (-80.0, 0.0),
            (-5.0, 9.0),
            (-60.0, 60.0),
            (1.0, 30.0),
            (0.0, 200.0),
        ];
        let quantization = Quantization::new(&equations, &ranges).unwrap();
        let (mut carried, mut alone) = (0.0, 0.0);
        for texel in 0..200 {
            let within = |term: usize, &(low, high): &(f64, f64)| {
                let share = (f64::from(texel) * 0.618 + term as f64 * 0.37).fract();
                low + (0.1 + 0.8 * share) * (high - low)
            };
            let wanted =
                DVector::from_iterator(6, ranges.iter().enumerate().map(|(k, r)| within(k, r)));
            let stored = quantization.round(&wanted, &mut [0; 6]);
            let difference = &stored - &wanted;
            carried += equations.product(&difference, &difference);
            let plain = DVector::from_fn(6, |term, _| {
                let step = f64::from(quantization.scale[term]);
                (wanted[term] / step).round() * step - wanted[term]
            });
            alone += equations.product(&plain, &plain);
        }
        assert!(carried < 0.8 * alone, "{carried} {alone}");
    }
}
