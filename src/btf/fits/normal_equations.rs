//! Least squares over the lights of a capture, the same for every texel.

use nalgebra::{DMatrix, DVector};

use crate::btf::direction::Direction;
use crate::btf::fits::basis::{Basis, MOST_TERMS};
use crate::error::{Error, Result};

/// Added to the diagonal, over the mean of the diagonal: lights on one ring leave some sums of terms open, and the
/// smallest coefficients are taken then.
const RIDGE: f64 = 1e-10;

/// The basis at the lights, and what solving for coefficients needs of it.
#[derive(Debug)]
pub(super) struct NormalEquations {
    /// The terms at each light.
    pub(super) at_lights: Vec<[f64; MOST_TERMS]>,
    pub(super) terms: usize,
    /// Products of the terms, summed over the lights.
    pub(super) gram: DMatrix<f64>,
    inverse: DMatrix<f64>,
}

impl NormalEquations {
    pub(super) fn new(basis: Basis, lights: &[Direction]) -> Result<Self> {
        let terms = basis.terms();
        if lights.len() < terms {
            return Err(Error::data("lights", lights.len().to_string())
                .expected(format!("at least {terms}, one per coefficient of the fit")));
        }
        let at_lights: Vec<_> = lights.iter().map(|&light| basis.values(light)).collect();
        let rows = DMatrix::from_fn(lights.len(), terms, |light, term| at_lights[light][term]);
        let mut gram = rows.tr_mul(&rows);
        let ridge = RIDGE * gram.trace() / terms as f64;
        (0..terms).for_each(|term| gram[(term, term)] += ridge);
        let inverse = gram.clone().cholesky().map(|factor| factor.inverse());
        Ok(Self {
            at_lights,
            terms,
            gram,
            inverse: inverse.ok_or_else(|| {
                Error::data("lights", "they do not determine the fit")
                    .expected("lights of several heights")
            })?,
        })
    }

    /// The coefficients of smallest squared error, from the products of values and terms.
    pub(super) fn solve(&self, moments: &[f64]) -> DVector<f64> {
        &self.inverse * DVector::from_column_slice(moments)
    }

    /// xᵀ Φ y with Φ the products of the terms: the product of two sums, summed over the lights.
    pub(super) fn product(&self, x: &DVector<f64>, y: &DVector<f64>) -> f64 {
        (&self.gram * y).dot(x)
    }

    /// Where coefficients are rounded in this order: what those behind a term take over of a change of that term, so
    /// that sums change least. Per place in the order, those factors.
    pub(super) fn carries(&self, order: &[usize]) -> Result<Vec<DVector<f64>>> {
        let carry = |place: usize| {
            let (term, behind) = (order[place], &order[place + 1..]);
            let mixed = DVector::from_iterator(
                behind.len(),
                behind.iter().map(|&other| self.gram[(other, term)]),
            );
            let gram = DMatrix::from_fn(behind.len(), behind.len(), |row, column| {
                self.gram[(behind[row], behind[column])]
            });
            let factor = gram.cholesky();
            let factor =
                factor.ok_or_else(|| Error::data("lights", "they do not determine the fit"))?;
            Ok(factor.solve(&mixed))
        };
        (0..order.len()).map(carry).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sum_of_the_terms_is_found_again() {
        let basis = Basis::Hemispherical(9);
        let lights: Vec<Direction> = (0..40)
            .map(|k| Direction::from_angles(0.1 + 0.03 * f64::from(k), 2.4 * f64::from(k)))
            .collect();
        let equations = NormalEquations::new(basis, &lights).unwrap();
        let wanted = DVector::from_fn(9, |term, _| term as f64 - 3.5);
        let mut moments = [0.0; 9];
        for at in &equations.at_lights {
            let value: f64 = wanted.iter().zip(at).map(|(a, b)| a * b).sum();
            moments
                .iter_mut()
                .zip(at)
                .for_each(|(moment, term)| *moment += value * term);
        }
        let found = equations.solve(&moments);
        assert!((&found - &wanted).amax() < 1e-6, "{found}");
        assert!(NormalEquations::new(basis, &lights[..8]).is_err());
    }
}
