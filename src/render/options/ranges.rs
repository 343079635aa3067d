//! The ranges that numbers of options must lie in.

use std::fmt;

use crate::error::{Error, Result};

/// Angles in degrees; of larger ones too few digits are left.
pub(super) const ANGLES: [f64; 2] = [-1e6, 1e6];
/// The farthest coordinate, in mesh units.
pub(super) const FARTHEST: f64 = 1e12;

/// A limit as a person writes it: 1e12, not 1000000000000.
pub(super) struct Plain(pub(super) f64);

impl fmt::Display for Plain {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 == 0.0 || (1e-3..1e5).contains(&self.0.abs()) {
            true => write!(f, "{}", self.0),
            false => write!(f, "{:e}", self.0),
        }
    }
}

/// Refuses a number outside its range (option, value, \[least, most\]); NaN lies in none.
pub(super) fn check_numbers(numbers: &[(&str, Option<f64>, [f64; 2])]) -> Result<()> {
    for &(option, value, [least, most]) in numbers {
        if let Some(value) = value.filter(|value| !(least..=most).contains(value)) {
            let expected = format!("{} to {}", Plain(least), Plain(most));
            return Err(Error::option(option, value.to_string(), expected));
        }
    }
    Ok(())
}

/// Refuses a count of 0 or above its limit (option, count, most, what limits it).
pub(super) fn check_counts(counts: &[(&str, u32, u32, &str)]) -> Result<()> {
    for &(option, count, most, why) in counts {
        if !(1..=most).contains(&count) {
            let expected = format!("1 to {most}: {why}");
            return Err(Error::option(option, count.to_string(), expected));
        }
    }
    Ok(())
}
