//! The sRGB curve, both ways.

use std::sync::LazyLock;

/// The light of each 8-bit number.
static LIGHT_OF_8_BITS: LazyLock<[f32; 256]> =
    LazyLock::new(|| std::array::from_fn(|number| decode_srgb(number as f32 / 255.0)));

/// The sRGB curve, from what is stored in [0, 1] to linear light (IEC 61966-2-1).
pub fn decode_srgb(stored: f32) -> f32 {
    if stored <= 0.04045 {
        stored / 12.92
    } else {
        ((stored + 0.055) / 1.055).powf(2.4)
    }
}

/// Decodes numbers that were 8-bit integers, in place: the same as [`decode_srgb`], from a table where a
/// number is still k / 255.
pub(super) fn decode_srgb8(numbers: &mut [f32]) {
    for number in numbers {
        let nearest = (*number * 255.0).clamp(0.0, 255.0).round();
        *number = match nearest / 255.0 == *number {
            true => LIGHT_OF_8_BITS[nearest as usize],
            false => decode_srgb(*number),
        };
    }
}

/// Linear light by the sRGB curve (IEC 61966-2-1), odd about 0 and going on above 1.
pub fn encode_srgb(linear: f32) -> f32 {
    let size = linear.abs();
    let encoded = if size <= 0.003_130_8 {
        12.92 * size
    } else {
        1.055 * size.powf(1.0 / 2.4) - 0.055
    };
    encoded.copysign(linear)
}

/// Linear light as an 8-bit sRGB number, clamped to [0, 1].
pub fn encode_srgb8(linear: f32) -> u8 {
    (encode_srgb(linear.clamp(0.0, 1.0)) * 255.0 + 0.5) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_gives_what_the_curve_gives() {
        let mut numbers: Vec<f32> = (0..=255).map(|k| k as f32 / 255.0).collect();
        numbers.extend([0.3, -0.1, 1.5, f32::NAN]);
        let expected: Vec<u32> = numbers.iter().map(|&v| decode_srgb(v).to_bits()).collect();
        decode_srgb8(&mut numbers);
        let found: Vec<u32> = numbers.iter().map(|v| v.to_bits()).collect();
        assert_eq!(found[..259], expected[..259]);
        assert!(numbers[259].is_nan());
    }
}
