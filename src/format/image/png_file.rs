//! PNG out: 8 or 16 bits per number; grey, colour, or colour with alpha.

use std::io::{self, Write};
use std::path::Path;

use png::{BitDepth, ColorType, Compression, Encoder, Filter, SrgbRenderingIntent};

use crate::error::{Error, Result};
use crate::format::atomic;
use crate::format::ours::PICTURE_MARK;

/// The numbers of a PNG, channels interleaved, row 0 at the top.
#[derive(Clone, Copy, Debug)]
pub enum PngNumbers<'a> {
    /// 8-bit integers.
    Bits8(&'a [u8]),
    /// 16-bit integers.
    Bits16(&'a [u16]),
}

impl PngNumbers<'_> {
    fn len(&self) -> usize {
        match self {
            Self::Bits8(numbers) => numbers.len(),
            Self::Bits16(numbers) => numbers.len(),
        }
    }
}

/// An image to be written as PNG.
#[derive(Clone, Copy, Debug)]
pub struct PngImage<'a> {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// The numbers: 1 (grey), 3 (colour) or 4 (colour and alpha) per texel.
    pub numbers: PngNumbers<'a>,
    /// Whether the file says that its numbers are colours by the sRGB curve.
    pub is_srgb: bool,
}

impl PngImage<'_> {
    fn color_type(&self) -> Result<ColorType> {
        let texels = self.width as usize * self.height as usize;
        let count = self.numbers.len();
        match count.checked_div(texels) {
            Some(1) if count == texels => Ok(ColorType::Grayscale),
            Some(3) if count == 3 * texels => Ok(ColorType::Rgb),
            Some(4) if count == 4 * texels => Ok(ColorType::Rgba),
            _ => Err(Error::data("pixels", format!("{count} numbers"))
                .expected(format!("{texels}, or three or four times as many"))),
        }
    }

    /// The bytes of the file.
    pub fn encode(&self) -> Result<Vec<u8>> {
        let (color, mut bytes) = (self.color_type()?, Vec::new());
        self.write_to(color, &mut bytes)
            .map_err(|error| Error::data("PNG", error.to_string()))?;
        Ok(bytes)
    }

    /// Writes the file complete or not at all.
    pub fn write(&self, path: &Path) -> Result<()> {
        let color = self.color_type().map_err(|error| error.in_file(path))?;
        atomic::write_file(path, |sink| self.write_to(color, sink))
    }

    fn write_to(&self, color: ColorType, sink: &mut impl Write) -> io::Result<()> {
        let [keyword, text] = PICTURE_MARK.map(String::from);
        let mut encoder = Encoder::new(sink, self.width, self.height);
        encoder.set_color(color);
        encoder.set_compression(Compression::Fast);
        encoder.set_filter(Filter::Adaptive);
        if self.is_srgb {
            encoder.set_source_srgb(SrgbRenderingIntent::Perceptual);
        }
        encoder.add_text_chunk(keyword, text)?;
        match self.numbers {
            PngNumbers::Bits8(numbers) => {
                let mut writer = encoder.write_header()?;
                writer.write_image_data(numbers)?;
                writer.finish().map_err(io::Error::from)
            }
            PngNumbers::Bits16(numbers) => {
                encoder.set_depth(BitDepth::Sixteen);
                let bytes: Vec<u8> = numbers.iter().flat_map(|n| n.to_be_bytes()).collect();
                let mut writer = encoder.write_header()?;
                writer.write_image_data(&bytes)?;
                writer.finish().map_err(io::Error::from)
            }
        }
    }
}

/// Writes an 8-bit PNG: `pixels` is row-major (height, width, channels), channels 1 or 3.
pub fn write_png(path: &Path, width: u32, height: u32, pixels: &[u8]) -> Result<()> {
    let image = PngImage {
        width,
        height,
        numbers: PngNumbers::Bits8(pixels),
        is_srgb: false,
    };
    image.write(path)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::format::image::{Alpha, Encoding, Precision, ReadOptions, read_with};

    #[test]
    fn sixteen_bits_and_alpha_come_back() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        let write = |numbers, is_srgb| {
            let (width, height) = (2, 1);
            PngImage {
                width,
                height,
                numbers,
                is_srgb,
            }
            .write(&path)
            .unwrap();
        };
        write(PngNumbers::Bits16(&[258, 65535]), false);
        let read = read_with(&path, &ReadOptions::data()).unwrap().image;
        assert_eq!(read.precision, Precision::Bits16);
        assert_eq!(read.data, [258.0 / 65535.0, 1.0]);
        write(PngNumbers::Bits8(&[9, 8, 7, 255, 6, 5, 4, 0]), true);
        let options = ReadOptions {
            alpha: Alpha::Keep,
            ..ReadOptions::data()
        };
        let read = read_with(&path, &options).unwrap();
        assert_eq!(read.alpha.unwrap(), [1.0, 0.0]);
        assert_eq!(read.image.channels, 3);
        let options = ReadOptions {
            alpha: Alpha::Ignore,
            ..ReadOptions::default()
        };
        assert_eq!(
            read_with(&path, &options).unwrap().image.encoding,
            Encoding::Srgb
        );
    }

    #[test]
    fn numbers_of_no_image_are_refused() {
        let refused = |numbers| {
            let (width, height, is_srgb) = (2, 2, false);
            PngImage {
                width,
                height,
                numbers,
                is_srgb,
            }
            .encode()
            .unwrap_err()
            .to_string()
        };
        assert!(refused(PngNumbers::Bits8(&[0; 8])).contains("8 numbers"));
        assert!(refused(PngNumbers::Bits16(&[0; 13])).contains("13 numbers"));
    }
}
