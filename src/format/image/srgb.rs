//! The sRGB curve, both ways.

/// The sRGB curve, from what is stored in [0, 1] to linear light (IEC 61966-2-1).
pub fn decode_srgb(stored: f32) -> f32 {
    if stored <= 0.04045 {
        stored / 12.92
    } else {
        ((stored + 0.055) / 1.055).powf(2.4)
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
