//! [Radial basis functions](crate::radial_basis) over places in the plane (Zhang 2003 §4.1).

use glam::DVec2;

use crate::error::Result;
use crate::radial_basis::{self, RadialBasis};

/// An interpolant of vectors of `N` numbers.
#[derive(Clone, Debug)]
pub struct PlanarBasis<const N: usize> {
    places: Vec<DVec2>,
    field: RadialBasis<N>,
}

impl<const N: usize> PlanarBasis<N> {
    /// The interpolant of values at as many places. Errors as [`RadialBasis::new`].
    pub fn new(places: Vec<DVec2>, values: &[[f64; N]], radius: f64) -> Result<Self> {
        let distance = |a: usize, b: usize| places[a].distance(places[b]);
        let field = RadialBasis::new(values, distance, radius)?;
        Ok(Self { places, field })
    }

    /// The interpolated value at a place.
    pub fn at(&self, place: DVec2) -> [f64; N] {
        let known = self.places.iter();
        self.field.at(known.map(|known| known.distance(place)))
    }
}

/// The radius that suits places: the mean way from each to the nearest other; `alone` for a single place.
pub fn usual_radius(places: &[DVec2], alone: f64) -> f64 {
    let distance = |a: usize, b: usize| places[a].distance(places[b]);
    radial_basis::usual_radius(places.len(), distance).unwrap_or(alone)
}
