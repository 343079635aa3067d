//! An image of a sample as the numbers that image sets hold.

use std::f32::consts::PI;

use crate::btf::sample::Sample;
use crate::error::Result;
use crate::format::image::encode_srgb8;

/// Reflectance with the light's cosine, row-major (height, width, RGB).
pub(super) fn reflectance(sample: &Sample, image: usize) -> Result<Vec<f32>> {
    let pixels = sample.image(image)?;
    let mut numbers = vec![0.0; pixels.len()];
    pixels.copy_to(&mut numbers);
    sample.check_image(image, &numbers)?;
    numbers.iter_mut().for_each(|value| *value *= PI);
    Ok(numbers)
}

/// The same in 8-bit sRGB, and how many numbers are above 1.
pub(super) fn in_8_bits(numbers: &[f32]) -> (Vec<u8>, u64) {
    let clipped = numbers.iter().filter(|value| **value > 1.0).count();
    let bytes = numbers.iter().map(|&value| encode_srgb8(value));
    (bytes.collect(), clipped as u64)
}
