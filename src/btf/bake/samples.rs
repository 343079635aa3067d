//! How many view rays a texel takes, and where in its area they look through.
//!
//! The places are a (0,2)-sequence: van der Corput's sequence and the second dimension of Sobol's. Each of its
//! first 2^m points lies in a stratum of its own, whichever way the texel is cut into 2^m equal rectangles of
//! power-of-two sides (Kollig and Keller 2002, "Efficient multidimensional sampling"). The points are
//! moved round the texel, so that the pattern continues across the borders of texels, and no point lies at the
//! texel's centre or on its middle lines. There the patches of the height field meet, and a normal is the mean
//! of several.

use std::fmt;
use std::str::FromStr;

use glam::DVec2;

use crate::error::{Error, Result};

/// The most view rays of a texel.
const MOST: u32 = 65_536;
/// What a user may ask for.
const RANGE: &str = "1 to 65536, or auto";
/// The fewest and the most that `auto` takes.
pub(super) const AUTO_LEAST: u32 = 4;
pub(super) const AUTO_MOST: u32 = 256;
/// How far a single ray passes the texel's centre by, in texels.
const OFF_CENTRE: f64 = 0.03;
/// What the bits of paired points are changed by: it moves them to a third of their strata, whatever the number of
/// points.
const TO_A_THIRD: u32 = 0x5555_5555;

/// View rays per texel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Samples {
    /// So many, 1 to 65536.
    Fixed(u32),
    /// As many as each texel needs for an error, 4 to 256.
    Auto,
}

impl FromStr for Samples {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        if text == "auto" {
            return Ok(Self::Auto);
        }
        text.parse()
            .map(Self::Fixed)
            .map_err(|_| format!("expected {RANGE}"))
    }
}

impl fmt::Display for Samples {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Fixed(count) => write!(f, "{count}"),
            Self::Auto => f.write_str("auto"),
        }
    }
}

impl Samples {
    /// Refuses none at all, and more than [`MOST`].
    pub(super) fn validate(self) -> Result<()> {
        match self {
            Self::Fixed(count) if !(1..=MOST).contains(&count) => {
                Err(Error::option("samples", count.to_string(), RANGE))
            }
            _ => Ok(()),
        }
    }

    /// The places to look through, relative to the texel's centre, in texels, −½ to ½; x to the right, y
    /// upwards. With `auto` a texel takes the first so many of them.
    pub(super) fn places(self) -> Vec<DVec2> {
        let shifted = |count: u32, shift: f64| -> Vec<DVec2> {
            let place = |index| (point(index) + DVec2::splat(shift)).fract() - DVec2::splat(0.5);
            (0..count).map(place).collect()
        };
        match self {
            Self::Fixed(1) => shifted(1, 0.5 + OFF_CENTRE),
            Self::Fixed(count) => shifted(count, 0.5 / f64::from(count)),
            Self::Auto => (0..AUTO_MOST).map(paired_place).collect(),
        }
    }
}

/// A place of a sequence in which every second point mirrors the one before at the texel's centre: however many pairs
/// are taken, their mean is the centre. (Where the first bit is set, the others are turned over: a linear scrambling,
/// which leaves the strata as they are.)
fn paired_place(index: u32) -> DVec2 {
    let paired = |bits: u32| match bits >> 31 {
        1 => bits ^ (u32::MAX >> 1),
        _ => bits,
    };
    let at = |bits: u32| fraction(paired(bits) ^ TO_A_THIRD) - 0.5;
    DVec2::new(at(index.reverse_bits()), at(sobol(index)))
}

/// A point of the sequence, 0 to below 1 each way.
fn point(index: u32) -> DVec2 {
    DVec2::new(fraction(index.reverse_bits()), fraction(sobol(index)))
}

/// The second dimension of Sobol's sequence, as 32 bits behind the point.
fn sobol(mut index: u32) -> u32 {
    let (mut bits, mut direction) = (0, 1 << 31);
    while index != 0 {
        if index & 1 == 1 {
            bits ^= direction;
        }
        index >>= 1;
        direction ^= direction >> 1;
    }
    bits
}

fn fraction(bits: u32) -> f64 {
    f64::from(bits) / 2_f64.powi(32)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    /// In how many of the columns × rows equal rectangles of a texel points lie.
    fn strata(points: &[DVec2], columns: u32, rows: u32) -> usize {
        let cell = |point: &DVec2| {
            let at = (*point + DVec2::splat(0.5)) * DVec2::new(columns.into(), rows.into());
            (at.x as u32, at.y as u32)
        };
        points.iter().map(cell).collect::<BTreeSet<_>>().len()
    }

    #[test]
    fn each_sample_has_a_stratum_of_its_own() {
        let open = Samples::Auto.places();
        for power in 0..=8 {
            let count = 1_u32 << power;
            let fixed = Samples::Fixed(count).places();
            assert_eq!(fixed.len(), count as usize);
            for columns in (0..=power).map(|bits| 1 << bits) {
                let rows = count / columns;
                assert_eq!(strata(&fixed, columns, rows), count as usize);
                let first = &open[..count as usize];
                assert_eq!(strata(first, columns, rows), count as usize);
            }
        }
    }

    #[test]
    fn no_sample_meets_the_middle_lines_or_the_border() {
        let counts = (1..=70).chain([256, 1000, 4096]).map(Samples::Fixed);
        for samples in counts.chain([Samples::Auto]) {
            for place in samples.places() {
                for along in [place.x, place.y] {
                    assert!((-0.5..0.5).contains(&along));
                    let nearest = along.abs().min(0.5 - along.abs());
                    assert!(nearest > 1e-5, "{samples}: {place}");
                }
            }
        }
    }

    #[test]
    fn samples_surround_the_centre() {
        for power in 0..=8 {
            let count = 1 << power;
            let mean = |places: &[DVec2]| places.iter().sum::<DVec2>() / f64::from(count);
            let fixed = mean(&Samples::Fixed(count).places());
            let allowed = if count == 1 { 1.01 * OFF_CENTRE } else { 1e-9 };
            assert!(fixed.abs().max_element() <= allowed, "{count}: {fixed}");
            let open = mean(&Samples::Auto.places()[..count as usize]);
            let stratum = 1.0 / f64::from(count);
            assert!(
                open.abs().max_element() <= 0.17 * stratum,
                "{count}: {open}"
            );
        }
    }

    /// Neighbouring texels have the same places, so that strata continue across their border: any square of a texel's
    /// size holds as many samples as the texel.
    #[test]
    fn the_pattern_continues_across_borders() {
        let places = Samples::Fixed(4).places();
        for corner in [(0.1, 0.3), (0.3, 0.6), (0.9, 0.2)] {
            let moved = places.iter().map(|place| {
                (*place + DVec2::from(corner)).rem_euclid(DVec2::ONE) - DVec2::splat(0.5)
            });
            let moved: Vec<DVec2> = moved.collect();
            assert_eq!((strata(&moved, 4, 1), strata(&moved, 1, 4)), (4, 4));
        }
    }

    #[test]
    fn counts_and_auto_are_read() {
        assert_eq!("auto".parse(), Ok(Samples::Auto));
        assert_eq!("4".parse(), Ok(Samples::Fixed(4)));
        for wrong in ["-1", "Auto", "4.0", ""] {
            let error = wrong.parse::<Samples>().unwrap_err();
            assert!(error.contains("1 to 65536, or auto"), "{error}");
        }
        for wrong in [0, 65_537] {
            assert!(Samples::Fixed(wrong).validate().is_err());
        }
        assert_eq!(Samples::Auto.to_string().parse(), Ok(Samples::Auto));
    }
}
