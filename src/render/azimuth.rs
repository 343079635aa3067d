//! World directions by azimuth and elevation: which way is up, where azimuth 0 lies.
//!
//! Azimuth turns counter-clockwise seen from above, elevation is from the horizontal. Azimuth 0
//! of lights and orbits points towards the first frame's camera; the camera itself is placed from
//! the mesh's [front](crate::render::front).

use std::fmt;

use glam::DVec3;
use serde::Serialize;

/// An axis of the world, with its sign.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Axis {
    /// +x
    #[value(name = "x")]
    X,
    /// +y
    #[default]
    #[value(name = "y")]
    Y,
    /// +z
    #[value(name = "z")]
    Z,
    /// −x
    #[value(name = "-x")]
    #[serde(rename = "-x")]
    MinusX,
    /// −y
    #[value(name = "-y")]
    #[serde(rename = "-y")]
    MinusY,
    /// −z
    #[value(name = "-z")]
    #[serde(rename = "-z")]
    MinusZ,
}

impl Axis {
    /// All of them.
    pub const ALL: [Self; 6] = [
        Self::X,
        Self::Y,
        Self::Z,
        Self::MinusX,
        Self::MinusY,
        Self::MinusZ,
    ];

    /// The axis as a unit vector.
    pub fn vector(self) -> DVec3 {
        match self {
            Self::X => DVec3::X,
            Self::Y => DVec3::Y,
            Self::Z => DVec3::Z,
            Self::MinusX => -DVec3::X,
            Self::MinusY => -DVec3::Y,
            Self::MinusZ => -DVec3::Z,
        }
    }
}

impl fmt::Display for Axis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::X => "x",
            Self::Y => "y",
            Self::Z => "z",
            Self::MinusX => "-x",
            Self::MinusY => "-y",
            Self::MinusZ => "-z",
        })
    }
}

/// Whether a direction of any length is along `up`, up or down.
pub fn is_along(up: DVec3, towards: DVec3) -> bool {
    up.cross(towards).length() <= 1e-6 * towards.length()
}

/// The horizontal side that is usually the front: +z, or −y when z is up or down.
pub fn front_of(up: Axis) -> Axis {
    match up {
        Axis::Z | Axis::MinusZ => Axis::MinusY,
        _ => Axis::Z,
    }
}

/// Up, and the horizontal direction of azimuth 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AzimuthFrame {
    up: DVec3,
    zero: DVec3,
}

impl AzimuthFrame {
    /// Azimuth 0 at a horizontal side.
    pub fn facing(up: Axis, front: Axis) -> Self {
        Self {
            up: up.vector(),
            zero: front.vector(),
        }
    }

    /// Azimuth 0 in the horizontal direction of `towards`; where it was when that has none.
    #[must_use]
    pub fn turned_towards(&self, towards: DVec3) -> Self {
        let level = towards - self.up * self.up.dot(towards);
        let zero = if level.length() > 1e-6 * towards.length() {
            level.normalize()
        } else {
            self.zero
        };
        Self { zero, ..*self }
    }

    /// The unit vector that points up.
    pub fn up(&self) -> DVec3 {
        self.up
    }

    /// The unit vector of azimuth 0.
    pub fn zero(&self) -> DVec3 {
        self.zero
    }

    /// The unit direction at an azimuth and elevation, both in radians.
    pub fn direction(&self, azimuth: f64, elevation: f64) -> DVec3 {
        let left = self.up.cross(self.zero);
        let level = self.zero * azimuth.cos() + left * azimuth.sin();
        (level * elevation.cos() + self.up * elevation.sin()).normalize()
    }

    /// Azimuth in [0, 2π) and elevation of a direction, in radians.
    pub fn angles(&self, direction: DVec3) -> (f64, f64) {
        let left = self.up.cross(self.zero);
        let (x, y, z) = (
            direction.dot(self.zero),
            direction.dot(left),
            direction.dot(self.up),
        );
        let azimuth = y.atan2(x).rem_euclid(std::f64::consts::TAU);
        (azimuth, z.atan2(x.hypot(y)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_2;

    #[test]
    fn azimuth_turns_counter_clockwise_seen_from_above() {
        let azimuths = AzimuthFrame::facing(Axis::Y, front_of(Axis::Y));
        assert!((azimuths.direction(0.0, 0.0) - DVec3::Z).length() < 1e-15);
        // Looking down −y with +z towards the reader, counter-clockwise from +z comes +x.
        assert!((azimuths.direction(FRAC_PI_2, 0.0) - DVec3::X).length() < 1e-15);
        assert!((azimuths.direction(1.0, FRAC_PI_2) - DVec3::Y).length() < 1e-15);
        let z_up = AzimuthFrame::facing(Axis::Z, front_of(Axis::Z));
        assert!((z_up.direction(FRAC_PI_2, 0.0) - DVec3::X).length() < 1e-15);
    }

    #[test]
    fn angles_invert_directions() {
        let azimuths =
            AzimuthFrame::facing(Axis::Z, Axis::X).turned_towards(DVec3::new(1.0, 2.0, 0.5));
        for (azimuth, elevation) in [(0.1, 0.2), (3.0, -0.4), (6.0, 1.2)] {
            let (a, e) = azimuths.angles(azimuths.direction(azimuth, elevation));
            assert!((a - azimuth).abs() < 1e-12 && (e - elevation).abs() < 1e-12);
        }
    }
}
