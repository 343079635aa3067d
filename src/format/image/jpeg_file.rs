//! JPEG out: 8-bit colour at full resolution of all components.

use std::io::Write;
use std::path::Path;

use image::codecs::jpeg::JpegEncoder;
use image::{ExtendedColorType, ImageEncoder};

use crate::error::{Error, Result};
use crate::format::atomic;

/// Writes 8-bit RGB as JPEG; `quality` is 1 to 100.
pub fn write_jpeg(path: &Path, width: u32, height: u32, rgb: &[u8], quality: u8) -> Result<()> {
    if rgb.len() != width as usize * height as usize * 3 {
        return Err(Error::data("pixels", format!("{} numbers", rgb.len()))
            .expected(format!("{width} × {height} × 3")));
    }
    let mut bytes = Vec::new();
    JpegEncoder::new_with_quality(&mut bytes, quality)
        .write_image(rgb, width, height, ExtendedColorType::Rgb8)
        .map_err(|error| Error::data("JPEG", error.to_string()).in_file(path))?;
    atomic::write_file(path, |sink| sink.write_all(&bytes))
}
