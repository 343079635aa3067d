//! Sizes in bytes, as people write and read them.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

/// A size in bytes, written with a unit: `3GiB`, `1.5G`, `800MiB`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct ByteSize(pub u64);

/// Unit letters and their binary powers.
const UNITS: [(char, u32); 4] = [('T', 40), ('G', 30), ('M', 20), ('K', 10)];

impl FromStr for ByteSize {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let fault = || format!("`{text}` is not a size; expected one as 3GiB, 800MiB or 1000000");
        let digits_end = text
            .find(|c: char| !c.is_ascii_digit() && c != '.')
            .unwrap_or(text.len());
        let (number, unit) = text.split_at(digits_end);
        let unit = unit.trim().to_ascii_uppercase();
        let power = match unit.trim_end_matches('B').trim_end_matches('I') {
            "" => 0,
            letter => {
                let known = UNITS.iter().find(|(name, _)| letter == name.to_string());
                known.ok_or_else(fault)?.1
            }
        };
        // Whole numbers stay exact; others are rounded to 53 bits.
        if let Some(whole) = number
            .parse()
            .ok()
            .and_then(|n: u64| n.checked_mul(1 << power))
        {
            return Ok(Self(whole));
        }
        let number: f64 = number.parse().map_err(|_| fault())?;
        Ok(Self((number * 2_f64.powi(power as i32)) as u64))
    }
}

impl TryFrom<String> for ByteSize {
    type Error = String;

    fn try_from(text: String) -> std::result::Result<Self, String> {
        text.parse()
    }
}

impl fmt::Display for ByteSize {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (name, power) in UNITS {
            let unit = 2_f64.powi(power as i32);
            if self.0 as f64 >= unit {
                return write!(f, "{:.2} {name}iB", self.0 as f64 / unit);
            }
        }
        write!(f, "{} B", self.0)
    }
}

impl From<ByteSize> for String {
    fn from(size: ByteSize) -> Self {
        size.0.to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_read_with_their_units() {
        for (text, bytes) in [
            ("3GiB", 3 << 30),
            ("1.5G", 3 << 29),
            ("800 MiB", 800 << 20),
            ("77", 77),
            ("18446744073709551615", u64::MAX),
            ("9007199254740993", (1 << 53) + 1),
        ] {
            assert_eq!(text.parse::<ByteSize>(), Ok(ByteSize(bytes)), "{text}");
        }
        assert!("much".parse::<ByteSize>().is_err() && "3XB".parse::<ByteSize>().is_err());
        assert_eq!(ByteSize(3 << 29).to_string(), "1.50 GiB");
    }
}
