//! Interpolation by Gaussian radial basis functions (Zhang 2003 §4.1 and §5): values at a few places, and what
//! they say of every other place.
//!
//! f(p) = m + Σ wᵢ exp(−|p − pᵢ|² / 2R²), m the mean of the values, the weights such that every value is met
//! exactly. Far from all places f is m.

use glam::DVec2;
use nalgebra::{DMatrix, DVector};

use crate::error::{Error, Result};

/// Places at most: the system that is solved has their number squared.
pub const MOST_PLACES: usize = 2000;
/// How far the interpolant may be from a value, over the largest value.
const EXACT: f64 = 1e-6;

/// An interpolant of vectors of `N` numbers.
#[derive(Clone, Debug)]
pub struct RadialBasis<const N: usize> {
    places: Vec<DVec2>,
    weights: Vec<[f64; N]>,
    mean: [f64; N],
    radius: f64,
}

impl<const N: usize> RadialBasis<N> {
    /// The interpolant of values at places, whose functions have the radius R. Errors: no place, more than
    /// [`MOST_PLACES`], a radius that is not above 0, and places so near each other that R tells nothing apart.
    pub fn new(places: Vec<DVec2>, values: &[[f64; N]], radius: f64) -> Result<Self> {
        let count = places.len();
        if count == 0 || count > MOST_PLACES || values.len() != count {
            let found = format!("{count} places with {} values", values.len());
            return Err(Error::data("radial basis functions", found)
                .expected(format!("1 to {MOST_PLACES} places, a value each")));
        }
        if !(radius > 0.0 && radius.is_finite()) {
            return Err(
                Error::data("radial basis functions", format!("radius {radius}"))
                    .expected("a radius above 0"),
            );
        }
        let mean = std::array::from_fn(|at| {
            values.iter().map(|value| value[at]).sum::<f64>() / count as f64
        });
        let matrix = DMatrix::from_fn(count, count, |row, col| {
            gaussian(places[row] - places[col], radius)
        });
        let solver = matrix.clone().lu();
        let mut weights = vec![[0.0; N]; count];
        for at in 0..N {
            let wanted = DVector::from_fn(count, |row, _| values[row][at] - mean[at]);
            let solved = solver.solve(&wanted).filter(|found| {
                let largest = values
                    .iter()
                    .map(|value| value[at].abs())
                    .fold(1.0, f64::max);
                (&matrix * found - &wanted).amax() <= EXACT * largest
            });
            let Some(solved) = solved else {
                return Err(Error::data(
                    "radial basis functions",
                    format!("{count} places that a radius of {radius} does not tell apart"),
                )
                .expected("a smaller radius, or places farther from each other"));
            };
            weights
                .iter_mut()
                .zip(solved.iter())
                .for_each(|(weights, &found)| weights[at] = found);
        }
        Ok(Self {
            places,
            weights,
            mean,
            radius,
        })
    }

    /// The interpolated value at a place.
    pub fn at(&self, place: DVec2) -> [f64; N] {
        let mut value = self.mean;
        for (known, weights) in self.places.iter().zip(&self.weights) {
            let share = gaussian(place - *known, self.radius);
            value
                .iter_mut()
                .zip(weights)
                .for_each(|(value, weight)| *value += share * weight);
        }
        value
    }
}

fn gaussian(apart: DVec2, radius: f64) -> f64 {
    (-apart.length_squared() / (2.0 * radius * radius)).exp()
}

/// The radius that suits places: the mean way from each to the nearest other; `alone` for a single place.
pub fn usual_radius(places: &[DVec2], alone: f64) -> f64 {
    let nearest = places.iter().enumerate().filter_map(|(at, place)| {
        let others = places.iter().enumerate().filter(|(other, _)| *other != at);
        others
            .map(|(_, other)| place.distance(*other))
            .min_by(f64::total_cmp)
    });
    let ways: Vec<f64> = nearest.collect();
    match ways.is_empty() {
        true => alone,
        false => ways.iter().sum::<f64>() / ways.len() as f64,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random;
    use rand::Rng;

    #[test]
    fn every_value_is_met_exactly() {
        let mut stream = random::stream(3, "places", 0, 0);
        let mut number = |most: f64| stream.gen_range(0.0..most);
        let places: Vec<DVec2> = (0..12)
            .map(|_| DVec2::new(number(90.0), number(60.0)))
            .collect();
        let values: Vec<[f64; 2]> = (0..12).map(|_| [number(1.0), number(5.0)]).collect();
        let radius = usual_radius(&places, 1.0);
        let found = RadialBasis::new(places.clone(), &values, radius).unwrap();
        for (place, value) in places.iter().zip(&values) {
            for (found, wanted) in found.at(*place).iter().zip(value) {
                assert!((found - wanted).abs() < 1e-5, "{found} {wanted}");
            }
        }
        // Far away only the mean is left.
        let far = found.at(DVec2::splat(1e6))[0];
        let mean = values.iter().map(|value| value[0]).sum::<f64>() / 12.0;
        assert!((far - mean).abs() < 1e-12);
    }

    #[test]
    fn half_way_between_two_values_lies_their_mean() {
        let places = vec![DVec2::new(0.0, 5.0), DVec2::new(20.0, 5.0)];
        let found = RadialBasis::new(places, &[[0.0], [1.0]], 20.0).unwrap();
        let at = |x: f64| found.at(DVec2::new(x, 5.0))[0];
        assert!((at(10.0) - 0.5).abs() < 1e-12);
        assert!((1..20).all(|x| at(f64::from(x)) > at(f64::from(x) - 1.0)));
    }

    #[test]
    fn places_that_the_radius_does_not_tell_apart_are_refused() {
        let places: Vec<DVec2> = (0..9).map(|x| DVec2::new(f64::from(x), 0.0)).collect();
        let values: Vec<[f64; 1]> = (0..9).map(|x| [f64::from(x % 2)]).collect();
        let said = RadialBasis::new(places.clone(), &values, 1e4)
            .unwrap_err()
            .to_string();
        assert!(said.contains("does not tell apart"), "{said}");
        assert!(RadialBasis::new(places, &values, 0.0).is_err());
        assert!(RadialBasis::<1>::new(Vec::new(), &[], 1.0).is_err());
    }
}
