//! Pictures as parts of a page: `data:` addresses of PNG and JPEG.

use std::io::Cursor;

use image::codecs::jpeg::JpegEncoder;
use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder};
use serde::Serialize;

use crate::error::{Error, Result};
use crate::format::rgb_image::RgbImage;
use crate::report::numbers;

/// Quality of JPEG, of 100.
const QUALITY: u8 = 85;

/// A picture of a page.
#[derive(Clone, Debug, Serialize)]
pub struct Embedded {
    /// A `data:` address.
    pub source: String,
    /// What is seen.
    pub caption: String,
    /// Whether its pixels are texels, which are shown as squares.
    pub is_texels: bool,
}

impl Embedded {
    /// A picture with every pixel as it is.
    pub fn new(picture: &RgbImage, caption: impl Into<String>) -> Result<Self> {
        Ok(Self {
            source: png(picture)?,
            caption: caption.into(),
            is_texels: false,
        })
    }

    /// The same picture, its pixels shown as squares.
    #[must_use]
    pub fn of_texels(self) -> Self {
        Self {
            is_texels: true,
            ..self
        }
    }
}

fn png(picture: &RgbImage) -> Result<String> {
    let mut bytes = Cursor::new(Vec::new());
    encode(picture, PngEncoder::new(&mut bytes))?;
    Ok(address("png", bytes.get_ref()))
}

/// The address of a picture as JPEG.
pub fn jpeg(picture: &RgbImage) -> Result<String> {
    let mut bytes = Vec::new();
    encode(picture, JpegEncoder::new_with_quality(&mut bytes, QUALITY))?;
    Ok(address("jpeg", &bytes))
}

fn encode(picture: &RgbImage, encoder: impl ImageEncoder) -> Result<()> {
    let (width, height) = (picture.width, picture.height);
    encoder
        .write_image(&picture.pixels, width, height, ExtendedColorType::Rgb8)
        .map_err(|error| Error::data("picture", error.to_string()))
}

fn address(kind: &str, bytes: &[u8]) -> String {
    format!("data:image/{kind};base64,{}", numbers::base64(bytes))
}
