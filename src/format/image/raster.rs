//! PNG, JPEG, GIF, BMP and Radiance HDR, through the `image` crate.

use std::path::Path;

use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits};

use crate::error::{Error, Result};
use crate::format::image::{
    Claim, Encoding, FloatImage, HARMLESS, Precision, WORKING, color_channels, undecodable,
    without_alpha,
};

/// Bytes that one byte of a file can stand for.
fn strongest_compression(format: ImageFormat) -> u64 {
    match format {
        // Deflate: runs of 258 bytes in 2 bits.
        ImageFormat::Png => 1032,
        // 64 numbers in a bit or two.
        ImageFormat::Jpeg => 1024,
        // LZW: at most 4095 numbers in 12 bits.
        ImageFormat::Gif => 2730,
        // Runs of 255 palette entries in 2 bytes.
        ImageFormat::Bmp => 128,
        // Old run lengths: a line in a few bytes.
        _ => 4096,
    }
}

pub(super) fn read(path: &Path, file_length: u64) -> Result<FloatImage> {
    let mut reader = ImageReader::open(path)
        .and_then(ImageReader::with_guessed_format)
        .map_err(Error::io(path, "read"))?;
    let strongest = reader.format().map_or(1, strongest_compression);
    let mut limits = Limits::no_limits();
    let most = file_length.saturating_mul(strongest).max(HARMLESS);
    limits.max_alloc = Some(most.saturating_add(WORKING));
    reader.limits(limits);
    let decoder = reader.into_decoder().map_err(undecodable)?;
    let (width, height) = decoder.dimensions();
    let claim = Claim {
        width: width.into(),
        height: height.into(),
        stored_bits: decoder.original_color_type().bits_per_pixel().into(),
        decoded_bytes: decoder.color_type().bytes_per_pixel().into(),
    };
    claim.check(strongest, file_length)?;
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
