//! How the numbers of sources that hold no image files stand for light.

use crate::error::{Error, Result};
use crate::format::image::{SourceEncoding, decode_srgb};

/// The function from a stored number to linear light; `auto` is that of the source where the user says nothing.
pub(in crate::btf) fn curve(
    encoding: SourceEncoding,
    auto: fn(f32) -> f32,
) -> Result<fn(f32) -> f32> {
    match encoding {
        SourceEncoding::Auto => Ok(auto),
        SourceEncoding::Srgb => Ok(decode_srgb),
        SourceEncoding::Linear => Ok(|number| number),
        SourceEncoding::Gamma22 => Ok(|number| number.powf(2.2)),
        SourceEncoding::Xyz => Err(Error::option(
            "encoding",
            "xyz for a source of red, green and blue",
            "auto, srgb, linear or gamma-2.2",
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_are_those_of_the_option() {
        let of = |encoding| curve(encoding, decode_srgb).unwrap()(0.5);
        assert_eq!(of(SourceEncoding::Auto), decode_srgb(0.5));
        assert_eq!(of(SourceEncoding::Linear), 0.5);
        assert!((of(SourceEncoding::Gamma22) - 0.5f32.powf(2.2)).abs() < 1e-7);
        assert!(curve(SourceEncoding::Xyz, decode_srgb).is_err());
    }
}
