//! TIFF, through the `tiff` crate: 8- and 16-bit integers and floats, grey or RGB.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use tiff::ColorType;
use tiff::decoder::{Decoder, DecodingResult, Limits};

use crate::error::{Error, Result};
use crate::format::image::{
    Claim, Encoding, FloatImage, HARMLESS, Precision, color_channels, undecodable, without_alpha,
};

/// Bytes that one byte of a file can stand for: LZW, at most 4095 numbers in 12 bits. Strips that share
/// bytes are refused by it too.
const STRONGEST_COMPRESSION: u64 = 2730;

/// Limits for an image of `decoded` bytes: a strip or tile may be larger than the image, tables are no
/// larger than the file.
fn limits(decoded: u64, file_length: u64) -> Limits {
    let size = |bytes: u64| usize::try_from(bytes).unwrap_or(usize::MAX);
    let mut limits = Limits::unlimited();
    limits.decoding_buffer_size = size(decoded);
    limits.intermediate_buffer_size = size(decoded.max(HARMLESS));
    limits.ifd_value_size = size(file_length);
    limits
}

pub(super) fn read(path: &Path, file_length: u64) -> Result<FloatImage> {
    let file = File::open(path).map_err(Error::io(path, "read"))?;
    let mut decoder = Decoder::new(BufReader::new(file))
        .map_err(undecodable)?
        .with_limits(limits(HARMLESS, file_length));
    let (width, height) = decoder.dimensions().map_err(undecodable)?;
    let color = decoder.colortype().map_err(undecodable)?;
    let stored = match color {
        ColorType::Gray(_) => 1,
        ColorType::GrayA(_) => 2,
        ColorType::RGB(_) => 3,
        ColorType::RGBA(_) => 4,
        other => return Err(undecodable(format!("{other:?} in TIFF"))),
    };
    let claim = Claim {
        width: width.into(),
        height: height.into(),
        stored_bits: u64::from(stored) * u64::from(color.bit_depth()),
        decoded_bytes: u64::from(stored) * u64::from(color.bit_depth().div_ceil(8)),
    };
    let decoded = claim.check(STRONGEST_COMPRESSION, file_length)?;
    let mut decoder = decoder.with_limits(limits(decoded, file_length));
    let (data, encoding, precision) = floats(stored, decoder.read_image().map_err(undecodable)?)?;
    let channels = color_channels(stored);
    if data.len() as u64 != u64::from(width) * u64::from(height) * u64::from(channels) {
        return Err(undecodable(format!("{} numbers in planes", data.len())));
    }
    Ok(FloatImage {
        width,
        height,
        channels,
        data,
        encoding,
        precision,
    })
}

fn floats(stored: u32, numbers: DecodingResult) -> Result<(Vec<f32>, Encoding, Precision)> {
    Ok(match numbers {
        DecodingResult::U8(flat) => (
            without_alpha(stored, &flat, |v| f32::from(v) / 255.0),
            Encoding::Srgb,
            Precision::Bits8,
        ),
        DecodingResult::U16(flat) => (
            without_alpha(stored, &flat, |v| f32::from(v) / 65535.0),
            Encoding::Srgb,
            Precision::Bits16,
        ),
        DecodingResult::F16(flat) => (
            without_alpha(stored, &flat, half::f16::to_f32),
            Encoding::Linear,
            Precision::Float,
        ),
        DecodingResult::F32(flat) => (
            without_alpha(stored, &flat, |v| v),
            Encoding::Linear,
            Precision::Float,
        ),
        DecodingResult::F64(flat) => (
            without_alpha(stored, &flat, |v| v as f32),
            Encoding::Linear,
            Precision::Float,
        ),
        _ => return Err(undecodable("signed or wide integers in TIFF")),
    })
}
