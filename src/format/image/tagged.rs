//! TIFF, through the `tiff` crate: 8- and 16-bit integers and floats, grey or RGB.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use tiff::ColorType;
use tiff::decoder::{Decoder, DecodingResult, Limits};

use crate::error::{Error, Result};
use crate::format::image::{
    Encoding, FloatImage, Precision, check_size, color_channels, undecodable, without_alpha,
};

pub(super) fn read(path: &Path, file_length: u64) -> Result<FloatImage> {
    let file = File::open(path).map_err(Error::io(path, "read"))?;
    let mut decoder = Decoder::new(BufReader::new(file))
        .map_err(undecodable)?
        .with_limits(Limits::unlimited()); // `check_size` is stricter
    let (width, height) = decoder.dimensions().map_err(undecodable)?;
    let color = decoder.colortype().map_err(undecodable)?;
    let stored = match color {
        ColorType::Gray(_) => 1,
        ColorType::GrayA(_) => 2,
        ColorType::RGB(_) => 3,
        ColorType::RGBA(_) => 4,
        other => return Err(undecodable(format!("{other:?} in TIFF"))),
    };
    let bytes_a_texel = u64::from(stored) * u64::from(color.bit_depth().div_ceil(8));
    check_size(width.into(), height.into(), bytes_a_texel, file_length)?;
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
