//! Directions in the sample's frame: +x along texture s, +y along texture t, +z out of the
//! surface; view and light directions both point away from the surface.

use glam::DVec3;
use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};

/// Directions closer than this are one, in radians.
pub const SAME_DIRECTION: f64 = 1e-4;

/// A unit vector in the sample's frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(from = "[f64; 3]", into = "[f64; 3]")]
pub struct Direction(pub DVec3);

impl Direction {
    /// θ from +z and φ counter-clockwise from +x, both in radians.
    pub fn from_angles(theta: f64, phi: f64) -> Self {
        let (sin, cos) = theta.sin_cos();
        Self(DVec3::new(sin * phi.cos(), sin * phi.sin(), cos))
    }

    /// The angle from +z, in radians.
    pub fn theta(self) -> f64 {
        self.0.x.hypot(self.0.y).atan2(self.0.z)
    }

    /// The angle from +x, counter-clockwise, in [0, 2π) radians.
    pub fn phi(self) -> f64 {
        self.0.y.atan2(self.0.x).rem_euclid(std::f64::consts::TAU)
    }

    /// Cosine of the angle from +z.
    pub fn cos_theta(self) -> f64 {
        self.0.z
    }

    /// The angle to another direction, in radians; exact for small angles too.
    pub fn angle_to(self, other: Self) -> f64 {
        let (difference, sum) = ((self.0 - other.0).length(), (self.0 + other.0).length());
        2.0 * difference.atan2(sum)
    }

    /// Refuses what is no unit vector or points into the surface; `place` says which it is.
    pub fn check(self, place: &str) -> Result<()> {
        let [x, y, z] = self.0.to_array();
        let fault = |what: &str| Error::data(place, format!("({x}, {y}, {z}) {what}"));
        if !self.0.is_finite() {
            return Err(fault("is not a number").expected("a unit vector"));
        }
        if (self.0.length() - 1.0).abs() > 1e-3 {
            return Err(fault(&format!("has length {}", self.0.length())).expected("a unit vector"));
        }
        if z < -1e-6 {
            return Err(fault("points below the horizon")
                .expected("z >= 0: directions point away from the surface"));
        }
        Ok(())
    }
}

impl From<[f64; 3]> for Direction {
    fn from(xyz: [f64; 3]) -> Self {
        Self(DVec3::from_array(xyz))
    }
}

impl From<Direction> for [f64; 3] {
    fn from(direction: Direction) -> Self {
        direction.0.to_array()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_2;

    #[test]
    fn angles_round_trip() {
        for (theta, phi) in [(0.3, 0.0), (1.2, 2.0), (FRAC_PI_2, 6.0)] {
            let direction = Direction::from_angles(theta, phi);
            assert!((direction.theta() - theta).abs() < 1e-12);
            assert!((direction.phi() - phi).abs() < 1e-12);
        }
        let up = Direction::from_angles(FRAC_PI_2, FRAC_PI_2);
        assert!((up.0 - DVec3::Y).length() < 1e-15);
    }

    #[test]
    fn small_angles_are_exact() {
        let a = Direction::from_angles(0.5, 1.0);
        let b = Direction::from_angles(0.5 + 1e-9, 1.0);
        assert!((a.angle_to(b) - 1e-9).abs() < 1e-15);
    }

    #[test]
    fn unusable_directions_are_refused() {
        let refused = |xyz: [f64; 3]| {
            Direction::from(xyz)
                .check("view 3")
                .unwrap_err()
                .to_string()
        };
        assert!(refused([0.0, 0.0, 2.0]).contains("length 2"));
        assert!(refused([0.0, 0.6, -0.8]).contains("below the horizon"));
        assert!(refused([f64::NAN, 0.0, 1.0]).contains("view 3"));
        assert!(Direction::from([1.0, 0.0, 0.0]).check("x").is_ok());
    }
}
