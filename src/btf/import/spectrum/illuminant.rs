//! The lights under which spectral reflectance is seen.

use clap::ValueEnum;
use glam::DVec3;
use serde::Serialize;

use crate::btf::import::spectrum::tables::{
    DAYLIGHT, DAYLIGHT_STEP_NM, FIRST_NM, OBSERVER, STEP_NM,
};

/// A light of the CIE.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Illuminant {
    /// Daylight of 6504 K, the white of sRGB.
    #[default]
    D65,
    /// Daylight of 5003 K.
    D50,
    /// A tungsten lamp of 2856 K.
    A,
    /// Equal energy at every wavelength.
    E,
}

impl Illuminant {
    /// Its power at a wavelength in nanometres, in proportion.
    pub(super) fn power(self, nm: f64) -> f64 {
        match self {
            Self::D65 => daylight(6504.0, nm),
            Self::D50 => daylight(5003.0, nm),
            Self::A => tungsten(nm),
            Self::E => 1.0,
        }
    }

    /// The tristimulus values of its white, Y being 1.
    pub(super) fn white(self) -> DVec3 {
        let sum: DVec3 = OBSERVER
            .iter()
            .enumerate()
            .map(|(row, &seen)| {
                let nm = FIRST_NM + row as f64 * STEP_NM;
                self.power(nm) * DVec3::from_array(seen)
            })
            .sum();
        sum / sum.y
    }
}

/// Illuminant A (CIE 15).
fn tungsten(nm: f64) -> f64 {
    let exponent = |nm: f64| (1.435e7 / (2848.0 * nm)).exp() - 1.0;
    100.0 * (560.0 / nm).powi(5) * exponent(560.0) / exponent(nm)
}

/// Daylight of a colour temperature (CIE 15).
fn daylight(kelvin: f64, nm: f64) -> f64 {
    let t = 1000.0 / kelvin;
    let x = match kelvin <= 7000.0 {
        true => -4.6070 * t.powi(3) + 2.9678 * t.powi(2) + 0.09911 * t + 0.244_063,
        false => -2.0064 * t.powi(3) + 1.9018 * t.powi(2) + 0.24748 * t + 0.237_040,
    };
    let y = -3.0 * x * x + 2.870 * x - 0.275;
    let rounded = |number: f64| (number * 1000.0).round() / 1000.0;
    let divisor = 0.0241 + 0.2562 * x - 0.7341 * y;
    let first = rounded((-1.3515 - 1.7703 * x + 5.9114 * y) / divisor);
    let second = rounded((0.0300 - 31.4424 * x + 30.0717 * y) / divisor);
    let place = ((nm - FIRST_NM) / DAYLIGHT_STEP_NM).clamp(0.0, (DAYLIGHT.len() - 1) as f64);
    let (row, part) = (place.floor() as usize, place.fract());
    let next = (row + 1).min(DAYLIGHT.len() - 1);
    let component = |k: usize| DAYLIGHT[row][k] * (1.0 - part) + DAYLIGHT[next][k] * part;
    component(0) + first * component(1) + second * component(2)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whites_are_those_of_the_standard() {
        for (illuminant, x, y) in [
            (Illuminant::D65, 0.312_72, 0.329_03),
            (Illuminant::D50, 0.345_67, 0.358_50),
            (Illuminant::A, 0.447_57, 0.407_45),
            (Illuminant::E, 0.333_33, 0.333_33),
        ] {
            let white = illuminant.white();
            let sum = white.element_sum();
            let found = (white.x / sum, white.y / sum);
            assert!(
                (found.0 - x).abs() < 1e-4 && (found.1 - y).abs() < 1e-4,
                "{illuminant:?}: {found:?}"
            );
        }
    }

    #[test]
    fn powers_are_those_of_the_published_tables() {
        for (illuminant, nm, power) in [
            (Illuminant::D65, 560.0, 100.0),
            (Illuminant::D65, 450.0, 117.008),
            (Illuminant::D65, 455.0, 117.410),
            (Illuminant::D50, 600.0, 97.688),
            (Illuminant::A, 400.0, 14.7080),
        ] {
            let found = illuminant.power(nm);
            assert!((found - power).abs() < 0.06, "{illuminant:?} {nm}: {found}");
        }
    }
}
