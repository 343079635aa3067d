//! Images in memory: floats, and how they stand for light.

use crate::error::{Error, Result};
use crate::format::image::notes::Note;
use crate::format::image::srgb::{decode_srgb, decode_srgb8};

/// How an image's numbers stand for light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Encoding {
    /// By the sRGB curve: what integer formats hold unless one knows better.
    Srgb,
    /// In proportion: float formats, and whatever was decoded.
    Linear,
    /// Not at all: heights, roughness, normals.
    Data,
}

/// What an image file stored for each number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Precision {
    /// 8-bit integers.
    Bits8,
    /// 16-bit integers.
    Bits16,
    /// Floats.
    Float,
}

/// An image in memory: row 0 at the top, channels interleaved.
#[derive(Clone, Debug, PartialEq)]
pub struct FloatImage {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// 1 (grey) or 3 (red, green, blue).
    pub channels: u32,
    /// height × width × channels numbers; integers of the file scaled to [0, 1].
    pub data: Vec<f32>,
    /// How the numbers stand for light.
    pub encoding: Encoding,
    /// What the file stored.
    pub precision: Precision,
}

impl FloatImage {
    /// A grey image of linear floats, `data` row by row.
    pub fn gray(width: u32, height: u32, data: Vec<f32>) -> Self {
        Self {
            width,
            height,
            channels: 1,
            data,
            encoding: Encoding::Linear,
            precision: Precision::Float,
        }
    }

    /// One number.
    pub fn get(&self, row: u32, col: u32, channel: u32) -> f32 {
        let texel = row as usize * self.width as usize + col as usize;
        self.data[texel * self.channels as usize + channel as usize]
    }

    /// The same image with linear numbers: sRGB is decoded by its exact curve.
    #[must_use]
    pub fn into_linear(mut self) -> Self {
        if self.encoding != Encoding::Srgb {
            return self;
        }
        match self.precision {
            Precision::Bits8 => decode_srgb8(&mut self.data),
            _ => self.data.iter_mut().for_each(|v| *v = decode_srgb(*v)),
        }
        self.encoding = Encoding::Linear;
        self
    }

    /// The same image with 1 channel: the mean of the channels (for maps that hold no colour).
    #[must_use]
    pub fn into_gray(mut self) -> Self {
        if self.channels != 1 {
            let channels = self.channels as usize;
            let mean = |texel: &[f32]| texel.iter().sum::<f32>() / channels as f32;
            self.data = self.data.chunks_exact(channels).map(mean).collect();
            self.channels = 1;
        }
        self
    }

    /// The same image with 3 channels: grey is repeated.
    #[must_use]
    pub fn into_rgb(mut self) -> Self {
        if self.channels == 1 {
            self.data = self.data.iter().flat_map(|&v| [v, v, v]).collect();
            self.channels = 3;
        }
        self
    }

    /// Refuses infinities and NaN, saying where the first one is.
    pub fn check_finite(&self) -> Result<()> {
        let Some(at) = self.data.iter().position(|value| !value.is_finite()) else {
            return Ok(());
        };
        let channels = self.channels as usize;
        let (texel, width) = (at / channels, self.width as usize);
        Err(Error::data(
            format!(
                "row {}, column {}, channel {}",
                texel / width,
                texel % width,
                at % channels
            ),
            self.data[at].to_string(),
        )
        .expected("a finite number"))
    }
}

/// An image with what its reader had to say.
#[derive(Clone, Debug)]
pub struct ReadImage {
    /// The image.
    pub image: FloatImage,
    /// Alpha per texel, where the options keep it and any texel is not opaque.
    pub alpha: Option<Vec<f32>>,
    /// What the user should know.
    pub notes: Vec<Note>,
    /// Whether the layer of the options was there to be chosen.
    pub layer_taken: bool,
}
