//! TIFF and BigTIFF, through the `tiff` crate: grey, RGB and palettes; integers of 1 to 32 bits, floats of
//! 16 to 64; strips and tiles, interleaved or in planes; with alpha.
//!
//! The crate reads no palettes, and inverts or drops channels by the photometric interpretation. So the
//! file is handed to it with that tag set to plain grey, which makes it hand on all channels as stored;
//! what they mean is decided here. JPEG-compressed files are the exception: there the crate's own
//! conversion of YCbCr is wanted.
//!
//! Not handled: CMYK, Lab, LogLuv, masks, signed integers, and TIFF's own tags for primaries and curves.

use std::io::Cursor;

use tiff::decoder::{Decoder, DecodingResult, Limits};
use tiff::tags::Tag;

use crate::error::Result;
use crate::format::image::color::Statement;
use crate::format::image::decoded::{Decoded, channel_names, only_part};
use crate::format::image::facts::Facts;
use crate::format::image::tagged_directory::PhotometricEntry;
use crate::format::image::tagged_samples::{Photometric, Samples};
use crate::format::image::{Claim, HARMLESS, Note, Precision, icc, undecodable};

/// Bytes that one byte of a file can stand for: LZW, at most 4095 numbers in 12 bits. Strips that share
/// bytes are refused by it too.
const STRONGEST_COMPRESSION: u64 = 2730;
/// The TIFF tag of ICC profiles.
const ICC_PROFILE: Tag = Tag::Unknown(34675);

type Reader = Decoder<Cursor<Vec<u8>>>;

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

pub(super) fn read(file: &[u8]) -> Result<Decoded> {
    let file_length = file.len() as u64;
    let mut bytes = file.to_vec();
    // Read kinds of pixels that the decoder does not know as grey.
    let entry = PhotometricEntry::find(&bytes);
    let stated = entry.map_or(1, |entry| entry.value(&bytes));
    let photometric = Photometric::of(stated)?;
    if let Some(entry) = entry.filter(|_| photometric.is_read_as_grey(compression(&bytes))) {
        entry.set(&mut bytes, 1);
    }
    let mut decoder = Decoder::new(Cursor::new(bytes))
        .map_err(undecodable)?
        .with_limits(limits(HARMLESS, file_length));
    // Check the size that the header claims.
    let layout = Layout::of(&mut decoder, photometric)?;
    let claim = Claim {
        width: layout.width.into(),
        height: layout.height.into(),
        stored_bits: u64::from(layout.samples) * u64::from(layout.bits),
        decoded_bytes: u64::from(layout.samples) * u64::from(layout.bits.div_ceil(8)),
    };
    let decoded = claim.check(STRONGEST_COMPRESSION, file_length)?;
    // Read what the file says.
    let described = described(&mut decoder, &layout)?;
    let palette = match photometric {
        Photometric::Palette => Some(
            decoder
                .get_tag_u16_vec(Tag::ColorMap)
                .map_err(undecodable)?,
        ),
        _ => None,
    };
    // Decode the numbers.
    let mut decoder = decoder.with_limits(limits(decoded, file_length));
    let mut numbers = DecodingResult::U8(Vec::new());
    decoder
        .read_image_to_buffer(&mut numbers)
        .map_err(undecodable)?;
    let samples = Samples {
        width: layout.width as usize,
        height: layout.height as usize,
        samples: usize::from(layout.samples),
        bits: usize::from(layout.bits),
        is_planar: layout.is_planar,
        photometric,
        palette,
    };
    let (data, alpha) = samples.texels(numbers, layout.has_alpha())?;
    Ok(Decoded {
        data,
        alpha: alpha.map(|alpha| (alpha, layout.premultiplied())),
        ..described
    })
}

/// The compression that the first directory states.
fn compression(bytes: &[u8]) -> u16 {
    PhotometricEntry::find_tag(bytes, 259).map_or(1, |entry| entry.value(bytes))
}

/// What the tags say of the numbers.
struct Layout {
    width: u32,
    height: u32,
    samples: u16,
    bits: u16,
    is_float: bool,
    is_planar: bool,
    photometric: Photometric,
    /// What the samples beyond colour are; 1 is associated alpha.
    extra: Vec<u16>,
}

impl Layout {
    fn of(decoder: &mut Reader, photometric: Photometric) -> Result<Self> {
        let (width, height) = decoder.dimensions().map_err(undecodable)?;
        let mut number = |tag: Tag, default: u16| -> Result<u16> {
            let found = decoder
                .find_tag_unsigned_vec::<u16>(tag)
                .map_err(undecodable)?;
            Ok(found
                .and_then(|values| values.first().copied())
                .unwrap_or(default))
        };
        let bits = number(Tag::BitsPerSample, 1)?;
        let samples = number(Tag::SamplesPerPixel, 1)?;
        let format = number(Tag::SampleFormat, 1)?;
        let is_planar = number(Tag::PlanarConfiguration, 1)? == 2;
        let extra = decoder
            .find_tag_unsigned_vec::<u16>(Tag::ExtraSamples)
            .map_err(undecodable)?
            .unwrap_or_default();
        if !matches!(format, 1 | 3) {
            return Err(undecodable("signed or complex numbers in TIFF"));
        }
        if samples < photometric.channels() || samples > 64 {
            return Err(undecodable(format!(
                "{samples} channels in {photometric:?} TIFF"
            )));
        }
        Ok(Self {
            width,
            height,
            samples,
            bits,
            is_float: format == 3,
            is_planar,
            photometric,
            extra,
        })
    }

    fn has_alpha(&self) -> bool {
        self.samples > self.photometric.channels()
    }

    fn premultiplied(&self) -> bool {
        self.extra.first() == Some(&1)
    }

    fn precision(&self) -> Precision {
        match (self.is_float, self.bits) {
            (true, _) => Precision::Float,
            (false, ..=8) if self.photometric != Photometric::Palette => Precision::Bits8,
            (false, _) => Precision::Bits16,
        }
    }

    fn numbers(&self) -> String {
        let kind = if self.is_float { "floats" } else { "integers" };
        format!("{}-bit {kind}", self.bits)
    }
}

/// What the tags say of the picture, the pixels still missing.
fn described(decoder: &mut Reader, layout: &Layout) -> Result<Decoded> {
    // Read orientation, compression and profile.
    let channels = u32::from(layout.photometric.colors());
    let mut unsigned = |tag: Tag| decoder.find_tag_unsigned::<u16>(tag).map_err(undecodable);
    let orientation = unsigned(Tag::Orientation)?.unwrap_or(1);
    let compression = unsigned(Tag::Compression)?.unwrap_or(1);
    let statement = match decoder.get_tag_u8_vec(ICC_PROFILE) {
        Ok(profile) => icc::statement(&profile, channels),
        Err(_) => Statement::default(),
    };
    // Note what is not read.
    let mut notes = notes(decoder, layout, &statement);
    let pictures = if decoder.more_images() {
        notes.push(Note::new("pictures", "the first of its images is read"));
        2
    } else {
        1
    };
    let planes = if layout.is_planar { ", planes" } else { "" };
    let compression = format!(
        "{}{planes}, {:?}",
        compression_name(compression),
        layout.photometric
    );
    let names = channel_names(channels, layout.has_alpha());
    Ok(Decoded {
        width: layout.width,
        height: layout.height,
        channels,
        data: Vec::new(),
        alpha: None,
        precision: layout.precision(),
        statement,
        orientation: u8::try_from(orientation)
            .ok()
            .filter(|o| (1..=8).contains(o))
            .unwrap_or(1),
        pixel_aspect: 1.0,
        layer_taken: false,
        notes,
        facts: Facts {
            format: "TIFF".into(),
            pictures,
            parts: vec![only_part(names, &layout.numbers(), &compression)],
            ..Facts::default()
        },
    })
}

fn notes(decoder: &mut Reader, layout: &Layout, statement: &Statement) -> Vec<Note> {
    let mut notes = Vec::new();
    let resolution = |decoder: &mut Reader, tag| decoder.get_tag_f64(tag).unwrap_or(0.0);
    let across = resolution(decoder, Tag::XResolution);
    notes.extend(Note::of_resolution(
        across,
        resolution(decoder, Tag::YResolution),
    ));
    let stated = [
        (301, "TransferFunction"),
        (318, "WhitePoint"),
        (319, "PrimaryChromaticities"),
    ];
    for (tag, name) in stated {
        let is_there = matches!(decoder.find_tag(Tag::Unknown(tag)), Ok(Some(_)));
        if is_there && statement.text.is_empty() {
            let text = format!("its tag {name} is not followed; embed an ICC profile instead");
            notes.push(Note::new("TIFF colour tags", text));
        }
    }
    let beyond = layout.samples.saturating_sub(layout.photometric.channels());
    if beyond > 1 {
        let text = format!("the last {} of its channels are not used", beyond - 1);
        notes.push(Note::new("extra channels", text));
    }
    if beyond > 0 && !matches!(layout.extra.first(), Some(1 | 2)) {
        let text = "a channel of unspecified meaning is taken as alpha";
        notes.push(Note::new("unspecified channel", text));
    }
    notes
}

fn compression_name(code: u16) -> String {
    match code {
        1 => "uncompressed".into(),
        5 => "LZW".into(),
        7 => "JPEG".into(),
        8 | 32946 => "deflate".into(),
        32773 => "PackBits".into(),
        50000 => "Zstandard".into(),
        other => format!("compression {other}"),
    }
}

#[cfg(test)]
mod tests;
