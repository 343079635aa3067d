//! PNG, JPEG, GIF, BMP and Radiance HDR, through the `image` crate.

use std::path::Path;

use image::{DynamicImage, ImageDecoder, ImageReader, Limits};

use crate::error::{Error, Result};
use crate::format::image::{
    Encoding, FloatImage, Precision, check_size, color_channels, undecodable, without_alpha,
};

pub(super) fn read(path: &Path, file_length: u64) -> Result<FloatImage> {
    let mut reader = ImageReader::open(path)
        .and_then(ImageReader::with_guessed_format)
        .map_err(Error::io(path, "read"))?;
    reader.limits(Limits::no_limits()); // `check_size` is stricter
    let decoder = reader.into_decoder().map_err(undecodable)?;
    let (width, height) = decoder.dimensions();
    let bytes_a_texel = u64::from(decoder.color_type().bytes_per_pixel());
    check_size(width.into(), height.into(), bytes_a_texel, file_length)?;
    DynamicImage::from_decoder(decoder)
        .map_err(undecodable)
        .and_then(|image| floats(&image))
}

fn floats(image: &DynamicImage) -> Result<FloatImage> {
    let stored = u32::from(image.color().channel_count());
    let (data, encoding, precision) = if let Some(flat) = flat_u8(image) {
        let data = without_alpha(stored, flat, |v| f32::from(v) / 255.0);
        (data, Encoding::Srgb, Precision::Bits8)
    } else if let Some(flat) = flat_u16(image) {
        let data = without_alpha(stored, flat, |v| f32::from(v) / 65535.0);
        (data, Encoding::Srgb, Precision::Bits16)
    } else {
        let flat = image
            .as_flat_samples_f32()
            .ok_or_else(|| undecodable(format!("{:?} numbers", image.color())))?
            .samples;
        let data = without_alpha(stored, flat, |v| v);
        (data, Encoding::Linear, Precision::Float)
    };
    Ok(FloatImage {
        width: image.width(),
        height: image.height(),
        channels: color_channels(stored),
        data,
        encoding,
        precision,
    })
}

fn flat_u8(image: &DynamicImage) -> Option<&[u8]> {
    image.as_flat_samples_u8().map(|flat| flat.samples)
}

fn flat_u16(image: &DynamicImage) -> Option<&[u16]> {
    image.as_flat_samples_u16().map(|flat| flat.samples)
}
