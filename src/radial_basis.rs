//! Interpolation by Gaussian radial basis functions (Zhang 2003 §4.1 and §5): values at a few places, and what
//! they say of every other place, in the plane or along a surface.
//!
//! f(p) = m + Σ wᵢ exp(−d(p, pᵢ)² / 2R²), d the distance, m the mean of the values, the weights such that every
//! value is met exactly. Far from all places f is m.

use nalgebra::{DMatrix, DVector};

use crate::error::{Error, Result};

/// Places at most: the system that is solved has their number squared.
pub const MOST_PLACES: usize = 2000;
/// How far the interpolant may be from a value, over the largest value.
const EXACT: f64 = 1e-6;

/// An interpolant of vectors of `N` numbers.
#[derive(Clone, Debug)]
pub struct RadialBasis<const N: usize> {
    weights: Vec<[f64; N]>,
    mean: [f64; N],
    radius: f64,
}

impl<const N: usize> RadialBasis<N> {
    /// The interpolant of values at places of which `distance(i, j)` says how far they are from each other, whose
    /// functions have the radius R. Errors: no place, more than [`MOST_PLACES`], a radius that is not above 0, and
    /// places so near each other that R tells nothing apart.
    pub fn new(
        values: &[[f64; N]],
        distance: impl Fn(usize, usize) -> f64,
        radius: f64,
    ) -> Result<Self> {
        const PLACE: &str = "radial basis functions";
        // Check the places and the radius.
        let count = values.len();
        if count == 0 || count > MOST_PLACES {
            return Err(Error::data(PLACE, format!("{count} places"))
                .expected(format!("1 to {MOST_PLACES}")));
        }
        if !(radius > 0.0 && radius.is_finite()) {
            let found = format!("radius {radius}");
            return Err(Error::data(PLACE, found).expected("a radius above 0"));
        }
        // Set up the equations.
        let mean = std::array::from_fn(|at| {
            values.iter().map(|value| value[at]).sum::<f64>() / count as f64
        });
        let matrix = DMatrix::from_fn(count, count, |row, col| {
            gaussian(distance(row, col), radius)
        });
        let solver = matrix.clone().lu();
        // Solve them per number; refuse places that are too near each other.
        let mut weights = vec![[0.0; N]; count];
        for at in 0..N {
            let wanted = DVector::from_fn(count, |row, _| values[row][at] - mean[at]);
            let largest = values
                .iter()
                .map(|value| value[at].abs())
                .fold(1.0, f64::max);
            let solved = solver.solve(&wanted);
            let exact =
                |found: &DVector<f64>| (&matrix * found - &wanted).amax() <= EXACT * largest;
            let Some(solved) = solved.filter(exact) else {
                let found = format!("{count} places that a radius of {radius} does not separate");
                return Err(Error::data(PLACE, found)
                    .expected("a smaller radius, or places farther from each other"));
            };
            let pairs = weights.iter_mut().zip(solved.iter());
            pairs.for_each(|(weights, &found)| weights[at] = found);
        }
        Ok(Self {
            weights,
            mean,
            radius,
        })
    }

    /// The interpolated value where the places are so far away, in their order.
    pub fn at(&self, distances: impl Iterator<Item = f64>) -> [f64; N] {
        let mut value = self.mean;
        for (distance, weights) in distances.zip(&self.weights) {
            let share = gaussian(distance, self.radius);
            let pairs = value.iter_mut().zip(weights);
            pairs.for_each(|(value, weight)| *value += share * weight);
        }
        value
    }
}

fn gaussian(distance: f64, radius: f64) -> f64 {
    (-distance * distance / (2.0 * radius * radius)).exp()
}

/// The radius that suits `count` places: the mean way from each to the nearest other. `None` where no two are at a
/// finite distance.
pub fn usual_radius(count: usize, distance: impl Fn(usize, usize) -> f64) -> Option<f64> {
    let nearest = |at: usize| {
        let others = (0..count).filter(|&other| other != at);
        others
            .map(|other| distance(at, other))
            .fold(f64::INFINITY, f64::min)
    };
    let ways: Vec<f64> = (0..count)
        .map(nearest)
        .filter(|way| way.is_finite())
        .collect();
    (!ways.is_empty()).then(|| ways.iter().sum::<f64>() / ways.len() as f64)
}

#[cfg(test)]
mod tests {
    use glam::DVec2;
    use rand::Rng;

    use super::*;
    use crate::random;

    fn interpolant<const N: usize>(
        places: &[DVec2],
        values: &[[f64; N]],
        radius: f64,
    ) -> Result<RadialBasis<N>> {
        RadialBasis::new(values, |a, b| places[a].distance(places[b]), radius)
    }

    fn at<const N: usize>(found: &RadialBasis<N>, places: &[DVec2], place: DVec2) -> [f64; N] {
        found.at(places.iter().map(|known| known.distance(place)))
    }

    #[test]
    fn every_value_is_met_exactly() {
        let mut stream = random::stream(3, "places", 0, 0);
        let mut number = |most: f64| stream.gen_range(0.0..most);
        let places: Vec<DVec2> = (0..12)
            .map(|_| DVec2::new(number(90.0), number(60.0)))
            .collect();
        let values: Vec<[f64; 2]> = (0..12).map(|_| [number(1.0), number(5.0)]).collect();
        let radius = usual_radius(12, |a, b| places[a].distance(places[b])).unwrap();
        let found = interpolant(&places, &values, radius).unwrap();
        for (place, value) in places.iter().zip(&values) {
            for (found, wanted) in at(&found, &places, *place).iter().zip(value) {
                assert!((found - wanted).abs() < 1e-5, "{found} {wanted}");
            }
        }
        // Far away only the mean is left.
        let far = at(&found, &places, DVec2::splat(1e6))[0];
        let mean = values.iter().map(|value| value[0]).sum::<f64>() / 12.0;
        assert!((far - mean).abs() < 1e-12);
    }

    #[test]
    fn half_way_between_two_values_lies_their_mean() {
        let places = [DVec2::new(0.0, 5.0), DVec2::new(20.0, 5.0)];
        let found = interpolant(&places, &[[0.0], [1.0]], 20.0).unwrap();
        let at = |x: f64| at(&found, &places, DVec2::new(x, 5.0))[0];
        assert!((at(10.0) - 0.5).abs() < 1e-12);
        assert!((1..20).all(|x| at(f64::from(x)) > at(f64::from(x) - 1.0)));
    }

    #[test]
    fn places_that_the_radius_does_not_tell_apart_are_refused() {
        let places: Vec<DVec2> = (0..9).map(|x| DVec2::new(f64::from(x), 0.0)).collect();
        let values: Vec<[f64; 1]> = (0..9).map(|x| [f64::from(x % 2)]).collect();
        let said = interpolant(&places, &values, 1e4).unwrap_err().to_string();
        assert!(said.contains("does not separate"), "{said}");
        assert!(interpolant(&places, &values, 0.0).is_err());
        assert!(interpolant::<1>(&[], &[], 1.0).is_err());
        assert_eq!(usual_radius(1, |_, _| 0.0), None);
    }
}
