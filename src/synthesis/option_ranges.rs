//! Ranges of numeric options, the same for every method.

use crate::error::{Error, Result};

/// Passes, sweeps or rounds at most: the orders of all sweeps are held together, and a few do.
const MOST_ROUNDS: u32 = 1000;
/// Distances are multiplied by no larger number: they are 32-bit floats.
const LARGEST_FACTOR: f64 = 1e12;

/// Refuses a count of 0.
pub fn at_least_one(option: &str, value: u64) -> Result<()> {
    if value >= 1 {
        return Ok(());
    }
    Err(Error::option(option, value.to_string(), "1 or more"))
}

/// Refuses more rounds than any run needs.
pub fn few_rounds(option: &str, value: u32, least: u32) -> Result<()> {
    if (least..=MOST_ROUNDS).contains(&value) {
        return Ok(());
    }
    Err(Error::option(
        option,
        value.to_string(),
        format!("{least} to {MOST_ROUNDS}: each visits every site of a level"),
    ))
}

/// Refuses factors with which distances would overflow.
pub fn within_factors(option: &str, value: f64, least: f64) -> Result<()> {
    if (least..=LARGEST_FACTOR).contains(&value) {
        return Ok(());
    }
    Err(Error::option(
        option,
        value.to_string(),
        format!("{least} to {LARGEST_FACTOR:e}: distances times larger numbers overflow"),
    ))
}
