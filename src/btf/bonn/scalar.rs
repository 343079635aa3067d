//! The number types of matrices in a `.btf` file.

use half::f16;
use half::slice::HalfFloatSliceExt;
use serde::Serialize;

use crate::error::{Error, Result};

/// A number type.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, clap::ValueEnum)]
pub enum Scalar {
    /// 16-bit floats, as all published files have.
    #[default]
    #[serde(rename = "f2")]
    #[value(name = "f2")]
    Half,
    /// 32-bit floats.
    #[serde(rename = "f4")]
    #[value(name = "f4")]
    Single,
    /// 64-bit floats.
    #[serde(rename = "f8")]
    #[value(name = "f8")]
    Double,
}

impl Scalar {
    /// The type whose numbers have so many bytes.
    pub(super) fn of_size(field: &str, size: u8) -> Result<Self> {
        match size {
            2 => Ok(Self::Half),
            4 => Ok(Self::Single),
            8 => Ok(Self::Double),
            other => Err(
                Error::data(format!("{field}: scalar size"), other.to_string())
                    .expected("2 (half), 4 (float) or 8 (double) bytes"),
            ),
        }
    }

    /// Bytes of a number.
    pub fn size(self) -> usize {
        match self {
            Self::Half => 2,
            Self::Single => 4,
            Self::Double => 8,
        }
    }

    /// Numbers of a file; what is beyond `f32` becomes infinite.
    pub(super) fn decode(self, bytes: &[u8], out: &mut [f32]) {
        match self {
            Self::Half => {
                let (words, _) = bytes.as_chunks::<2>();
                let halves: Vec<f16> = words.iter().map(|word| f16::from_le_bytes(*word)).collect();
                halves.convert_to_f32_slice(out);
            }
            Self::Single => {
                let (words, _) = bytes.as_chunks::<4>();
                let pairs = out.iter_mut().zip(words);
                pairs.for_each(|(out, word)| *out = f32::from_le_bytes(*word));
            }
            Self::Double => {
                let (words, _) = bytes.as_chunks::<8>();
                let pairs = out.iter_mut().zip(words);
                pairs.for_each(|(out, word)| *out = f64::from_le_bytes(*word) as f32);
            }
        }
    }

    /// The bytes of numbers, added to `bytes`; refuses what the type cannot hold.
    pub(super) fn encode(self, place: &str, numbers: &[f32], bytes: &mut Vec<u8>) -> Result<()> {
        let largest = match self {
            Self::Half => f16::MAX.to_f32(),
            Self::Single | Self::Double => f32::MAX,
        };
        let fits = |number: &&f32| (-largest..=largest).contains(*number);
        if let Some(&beyond) = numbers.iter().find(|number| !fits(number)) {
            return Err(Error::data(place, beyond.to_string())
                .expected(format!("at most {largest} in size"))
                .advice("--scalar f4 holds larger numbers"));
        }
        match self {
            Self::Half => {
                let mut halves = vec![f16::ZERO; numbers.len()];
                halves.convert_from_f32_slice(numbers);
                bytes.extend(halves.iter().flat_map(|half| half.to_le_bytes()));
            }
            Self::Single => bytes.extend(numbers.iter().flat_map(|number| number.to_le_bytes())),
            Self::Double => {
                let doubles = numbers.iter().map(|&number| f64::from(number));
                bytes.extend(doubles.flat_map(f64::to_le_bytes));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_round_trip_in_every_type() {
        let numbers = [0.0, -1.5, 0.25, 60_000.0];
        for scalar in [Scalar::Half, Scalar::Single, Scalar::Double] {
            let mut bytes = Vec::new();
            scalar.encode("x", &numbers, &mut bytes).unwrap();
            assert_eq!(bytes.len(), 4 * scalar.size());
            let mut back = [0.0; 4];
            scalar.decode(&bytes, &mut back);
            assert_eq!(back, numbers);
            assert_eq!(Scalar::of_size("x", scalar.size() as u8).unwrap(), scalar);
        }
    }

    #[test]
    fn numbers_beyond_a_type_are_refused() {
        let text = Scalar::Half.encode("U", &[1.0, 7e4], &mut Vec::new());
        assert!(text.unwrap_err().to_string().contains("65504"));
        let nan = Scalar::Double.encode("U", &[f32::NAN], &mut Vec::new());
        assert!(nan.unwrap_err().to_string().contains("NaN"));
        let size = Scalar::of_size("channel 0", 3).unwrap_err().to_string();
        assert!(size.contains("channel 0") && size.contains('3'), "{size}");
    }
}
