//! Numbers of a TIFF file, as its strips and tiles hold them, to texels.

use tiff::decoder::DecodingResult;

use crate::error::{Error, Result};
use crate::format::image::undecodable;

/// What the channels of a TIFF file show.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Photometric {
    /// Grey, 0 is white.
    WhiteIsZero,
    /// Grey, 0 is black.
    BlackIsZero,
    Rgb,
    /// Indices into a colour map.
    Palette,
    /// Luma and chroma, read where JPEG compressed.
    YCbCr,
}

impl Photometric {
    pub(super) fn of(stated: u16) -> Result<Self> {
        let name = match stated {
            0 => return Ok(Self::WhiteIsZero),
            1 => return Ok(Self::BlackIsZero),
            2 => return Ok(Self::Rgb),
            3 => return Ok(Self::Palette),
            6 => return Ok(Self::YCbCr),
            4 => "a transparency mask".to_string(),
            5 => "CMYK inks".into(),
            8..=10 => "CIE L*a*b* colours".into(),
            32803 => "a raw colour filter array".into(),
            32844 | 32845 => "LogLuv colours".into(),
            other => format!("photometric interpretation {other}"),
        };
        Err(Error::data("TIFF", name)
            .expected("grey, RGB, a palette, or JPEG-compressed YCbCr")
            .advice("convert it to RGB, with its profile if it has one"))
    }

    /// Channels of the file that make a colour.
    pub(super) fn channels(self) -> u16 {
        match self {
            Self::Rgb | Self::YCbCr => 3,
            _ => 1,
        }
    }

    /// Channels of the colour they make.
    pub(super) fn colors(self) -> u16 {
        match self {
            Self::WhiteIsZero | Self::BlackIsZero => 1,
            _ => 3,
        }
    }

    /// Whether all channels are wanted as stored, which the `tiff` crate does for grey alone.
    pub(super) fn is_read_as_grey(self, compression: u16) -> bool {
        const JPEG: u16 = 7;
        self != Self::YCbCr && compression != JPEG
    }
}

/// How the numbers of an image lie.
pub(super) struct Samples {
    pub(super) width: usize,
    pub(super) height: usize,
    /// Channels of the file.
    pub(super) samples: usize,
    pub(super) bits: usize,
    pub(super) is_planar: bool,
    pub(super) photometric: Photometric,
    /// All reds, then greens, then blues.
    pub(super) palette: Option<Vec<u16>>,
}

impl Samples {
    /// Colour numbers, interleaved, and alpha.
    pub(super) fn texels(
        &self,
        numbers: DecodingResult,
        has_alpha: bool,
    ) -> Result<(Vec<f32>, Option<Vec<f32>>)> {
        let numbers = self.floats(numbers)?;
        let texels = self.width * self.height;
        if numbers.len() != texels * self.samples {
            return Err(undecodable(format!(
                "{} numbers where {texels} texels of {} channels are claimed",
                numbers.len(),
                self.samples
            )));
        }
        let at = |texel: usize, channel: usize| match self.is_planar {
            true => numbers[channel * texels + texel],
            false => numbers[texel * self.samples + channel],
        };
        let channels = usize::from(self.photometric.channels());
        let alpha = has_alpha.then(|| (0..texels).map(|texel| at(texel, channels)).collect());
        let mut data = Vec::with_capacity(texels * usize::from(self.photometric.colors()));
        for texel in 0..texels {
            match (&self.palette, self.photometric) {
                (Some(palette), _) => data.extend(self.entry(palette, at(texel, 0))?),
                (None, Photometric::WhiteIsZero) => data.push(1.0 - at(texel, 0)),
                _ => data.extend((0..channels).map(|channel| at(texel, channel))),
            }
        }
        Ok((data, alpha))
    }

    /// A colour of the palette.
    fn entry(&self, palette: &[u16], share: f32) -> Result<[f32; 3]> {
        let colors = 1_usize << self.bits.min(16);
        let index = (f64::from(share) * (colors - 1) as f64).round() as usize;
        let entry = |channel: usize| palette.get(channel * colors + index).copied();
        match (entry(0), entry(1), entry(2)) {
            (Some(red), Some(green), Some(blue)) if palette.len() == 3 * colors => {
                Ok([red, green, blue].map(|v| f32::from(v) / 65535.0))
            }
            _ => Err(undecodable(format!(
                "a palette of {} numbers for {}-bit indices",
                palette.len(),
                self.bits
            ))),
        }
    }

    /// All numbers as floats, integers scaled to [0, 1].
    fn floats(&self, numbers: DecodingResult) -> Result<Vec<f32>> {
        Ok(match numbers {
            DecodingResult::U8(packed) if self.bits < 8 => self.unpacked(&packed)?,
            DecodingResult::U8(flat) => flat.iter().map(|&v| f32::from(v) / 255.0).collect(),
            DecodingResult::U16(flat) => flat.iter().map(|&v| f32::from(v) / 65535.0).collect(),
            DecodingResult::U32(flat) => {
                let scaled = |&v: &u32| (f64::from(v) / f64::from(u32::MAX)) as f32;
                flat.iter().map(scaled).collect()
            }
            DecodingResult::F16(flat) => flat.iter().map(|v| v.to_f32()).collect(),
            DecodingResult::F32(flat) => flat,
            DecodingResult::F64(flat) => flat.iter().map(|&v| v as f32).collect(),
            _ => return Err(undecodable("signed or 64-bit integers in TIFF")),
        })
    }

    /// Numbers of 1, 2 or 4 bits; every row, in every plane, begins with a whole byte.
    fn unpacked(&self, packed: &[u8]) -> Result<Vec<f32>> {
        if ![1, 2, 4].contains(&self.bits) {
            return Err(undecodable(format!("{}-bit integers in TIFF", self.bits)));
        }
        let row_numbers = match self.is_planar {
            true => self.width,
            false => self.width * self.samples,
        };
        let row_bytes = (row_numbers * self.bits).div_ceil(8);
        let most = f32::from((1_u8 << self.bits) - 1);
        let mut numbers = Vec::with_capacity(self.width * self.height * self.samples);
        for row in packed.chunks_exact(row_bytes) {
            numbers.extend((0..row_numbers).map(|index| {
                let bit = index * self.bits;
                let shift = 8 - self.bits - bit % 8;
                let mask = (1_u8 << self.bits) - 1;
                f32::from(row[bit / 8] >> shift & mask) / most
            }));
        }
        Ok(numbers)
    }
}
