//! Functions of the light's direction that a fit sums.

use std::f64::consts::PI;

use crate::btf::direction::Direction;

/// The most terms of a basis.
pub const MOST_TERMS: usize = 16;

/// What a fit's terms are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Basis {
    /// u², v², uv, u, v, 1, where (u, v) are x and y of the light's unit vector (Malzbender 2001 §3).
    Polynomial,
    /// The first so many hemispherical harmonics: 4, 9 or 16 (Gautron 2004 §4). They are orthonormal on the
    /// hemisphere.
    Hemispherical(usize),
}

impl Basis {
    /// How many terms.
    pub fn terms(self) -> usize {
        match self {
            Self::Polynomial => 6,
            Self::Hemispherical(terms) => terms,
        }
    }

    /// The terms' values at a light, in their order in files; those beyond [`terms`](Self::terms) are 0.
    pub fn values(self, light: Direction) -> [f64; MOST_TERMS] {
        let mut values = [0.0; MOST_TERMS];
        match self {
            Self::Polynomial => {
                let (u, v) = (light.0.x, light.0.y);
                values[..6].copy_from_slice(&[u * u, v * v, u * v, u, v, 1.0]);
            }
            Self::Hemispherical(terms) => {
                values[..terms].copy_from_slice(&harmonics(light)[..terms]);
            }
        }
        values
    }
}

/// Hemispherical harmonics up to the third band. With c = cos θ: spherical harmonics at 2c − 1, scaled to the
/// hemisphere.
fn harmonics(light: Direction) -> [f64; MOST_TERMS] {
    let (c, phi) = (light.cos_theta().clamp(0.0, 1.0), light.phi());
    let (sin, sin2, sin3) = (phi.sin(), (2.0 * phi).sin(), (3.0 * phi).sin());
    let (cos, cos2, cos3) = (phi.cos(), (2.0 * phi).cos(), (3.0 * phi).cos());
    // p = −(c − c²) is what its square root and its powers are built of.
    let p = c * c - c;
    let root = (-p).sqrt();
    let first = (6.0 / PI).sqrt() * root;
    let second = (30.0 / PI).sqrt();
    let third = 2.0 * (21.0 / PI).sqrt() * root * (1.0 - 5.0 * c + 5.0 * c * c);
    let tesseral = (210.0 / PI).sqrt() * (2.0 * c - 1.0) * p;
    let sectoral = 2.0 * (35.0 / PI).sqrt() * root.powi(3);
    [
        (0.5 / PI).sqrt(),
        first * cos,
        (1.5 / PI).sqrt() * (2.0 * c - 1.0),
        first * sin,
        second * p * cos2,
        second * (2.0 * c - 1.0) * root * cos,
        (2.5 / PI).sqrt() * (1.0 + 6.0 * p),
        second * (2.0 * c - 1.0) * root * sin,
        second * p * sin2,
        sectoral * cos3,
        tesseral * cos2,
        third * cos,
        (3.5 / PI).sqrt() * (-1.0 + 12.0 * c - 30.0 * c * c + 20.0 * c.powi(3)),
        third * sin,
        tesseral * sin2,
        sectoral * sin3,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A midpoint rule over the hemisphere, exact enough for products of these functions.
    #[test]
    fn harmonics_are_orthonormal_on_the_hemisphere() {
        let (rings, steps) = (400, 64);
        let mut gram = [[0.0; MOST_TERMS]; MOST_TERMS];
        let solid_angle = 2.0 * PI / f64::from(rings * steps);
        for ring in 0..rings {
            for step in 0..steps {
                let theta = ((f64::from(ring) + 0.5) / f64::from(rings)).acos();
                let phi = f64::from(step) / f64::from(steps) * 2.0 * PI;
                let at = harmonics(Direction::from_angles(theta, phi));
                for (row, &a) in gram.iter_mut().zip(&at) {
                    for (entry, &b) in row.iter_mut().zip(&at) {
                        *entry += a * b * solid_angle;
                    }
                }
            }
        }
        for (i, row) in gram.iter().enumerate() {
            for (j, &entry) in row.iter().enumerate() {
                let wanted = f64::from(u8::from(i == j));
                assert!((entry - wanted).abs() < 1e-3, "{i} {j}: {entry}");
            }
        }
    }

    #[test]
    fn the_polynomial_has_its_order() {
        let light = Direction::from([0.6, 0.48, 0.64]);
        let expected = [0.36, 0.2304, 0.288, 0.6, 0.48, 1.0];
        for (found, expected) in Basis::Polynomial.values(light).iter().zip(expected) {
            assert!((found - expected).abs() < 1e-12);
        }
    }
}
