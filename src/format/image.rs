//! Images in, as floats with a stated meaning; PNG and JPEG out (`png_file`, `jpeg_file`).
//!
//! One file per format: PNG (`portable`), JPEG, GIF and BMP (`raster`), TIFF (`tagged`), Radiance HDR and OpenEXR.
//! Each hands on what the file stores and says; `decoded` does the rest, the same for all: alpha, orientation,
//! colour. An option of the caller has precedence over what the file says of its colours; without either, integers
//! are sRGB and floats linear. [`read`] is for callers without options, [`read_with`] takes [`ReadOptions`],
//! [`read_bytes`] reads from memory, [`inspect`] also tells what the file says. [`exr_content`] and [`read_planes`]
//! are for OpenEXR files whose channels are no picture.
//!
//! The size in a header is accepted only if the file's length can hold it: each format has a strongest compression.
//! Decoded images up to 16 MiB are read in any case.

mod color;
mod decoded;
mod facts;
mod float_image;
mod icc;
mod jpeg_file;
mod jpeg_header;
mod notes;
mod openexr;
mod openexr_content;
mod openexr_facts;
mod openexr_layers;
mod options;
mod orientation;
mod png_file;
mod portable;
mod primaries;
mod radiance;
mod raster;
mod srgb;
mod srgb_color;
mod tagged;
mod tagged_directory;
mod tagged_samples;

use std::fs;
use std::path::Path;

pub use crate::format::image::facts::{Channel, Facts, Part, Transparency};
pub use crate::format::image::float_image::{Encoding, FloatImage, Precision, ReadImage};
pub use crate::format::image::jpeg_file::write_jpeg;
pub use crate::format::image::notes::{Note, Notes};
pub use crate::format::image::openexr_content::{ExrContent, Planes};
pub use crate::format::image::options::{
    Alpha, Flags, Gamut, Missing, Orientation, Purpose, ReadOptions, SourceEncoding,
};
pub use crate::format::image::png_file::{PngImage, PngNumbers, write_png};
pub use crate::format::image::primaries::{adapted_to_rec709, rec709_to_xyz};
pub use crate::format::image::srgb::{decode_srgb, encode_srgb, encode_srgb8};
pub use crate::format::image::srgb_color::SrgbColor;

use crate::error::{Error, Result};
use crate::format::guard::guarded;
use crate::format::image::decoded::Decoded;

/// The most texels an image may have: 16384 × 16384.
const MOST_TEXELS: u64 = 1 << 28;
/// Images this small are decoded whatever their header says, in decoded bytes.
const HARMLESS: u64 = 16 << 20;
/// Memory that a decoder may use beside the image, in bytes.
const WORKING: u64 = 64 << 20;

/// What a file says, and what reading it comes to.
#[derive(Debug)]
pub struct Inspection {
    /// What the file says.
    pub facts: Facts,
    /// The image as the options have it, or why it is refused.
    pub read: Result<ReadImage>,
}

/// Reads an image file as colour, without options; its format is known by its first bytes, not its name.
pub fn read(path: &Path) -> Result<FloatImage> {
    read_with(path, &ReadOptions::default()).map(|read| read.image)
}

/// Reads an image file as `options` say.
pub fn read_with(path: &Path, options: &ReadOptions) -> Result<ReadImage> {
    read_bytes(path, &bytes_of(path)?, options)
}

/// Reads an image whose file is in memory; errors call it `name`.
pub fn read_bytes(name: &Path, bytes: &[u8], options: &ReadOptions) -> Result<ReadImage> {
    guarded(name, || decoded(bytes, options)?.finished(options))
}

/// What the first part of an OpenEXR file holds; `None` for any other file.
pub fn exr_content(name: &Path, bytes: &[u8]) -> Result<Option<ExrContent>> {
    match kind_of(bytes) {
        FileKind::OpenExr => guarded(name, || openexr::content(bytes).map(Some)),
        _ => Ok(None),
    }
}

/// The channels of an OpenEXR file's first part that `is_wanted` accepts, each as a plane of its own.
pub fn read_planes(name: &Path, bytes: &[u8], is_wanted: impl Fn(&str) -> bool) -> Result<Planes> {
    guarded(name, || openexr::read_planes(bytes, is_wanted))
}

/// Reads an image file and tells what it says of itself, also where it is refused for a reason that leaves
/// its header sound.
pub fn inspect(path: &Path, options: &ReadOptions) -> Result<Inspection> {
    let bytes = bytes_of(path)?;
    guarded(path, || match decoded(&bytes, options) {
        Ok(decoded) => Ok(Inspection {
            facts: decoded.facts(),
            read: decoded.finished(options),
        }),
        Err(error) if kind_of(&bytes) == FileKind::OpenExr => Ok(Inspection {
            facts: openexr::facts(&bytes)?,
            read: Err(error),
        }),
        Err(error) => Err(error),
    })
}

fn bytes_of(path: &Path) -> Result<Vec<u8>> {
    fs::read(path).map_err(Error::io(path, "read"))
}

fn decoded(bytes: &[u8], options: &ReadOptions) -> Result<Decoded> {
    match kind_of(bytes) {
        FileKind::OpenExr => openexr::read(bytes, options),
        FileKind::Tiff => tagged::read(bytes),
        FileKind::Png => portable::read(bytes),
        FileKind::Radiance => radiance::read(bytes),
        FileKind::Other => raster::read(bytes),
    }
}

/// What the first bytes of a file say of its format.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum FileKind {
    OpenExr,
    Tiff,
    Png,
    Radiance,
    /// JPEG, GIF, BMP, or no image.
    Other,
}

fn kind_of(bytes: &[u8]) -> FileKind {
    match bytes {
        [0x76, 0x2f, 0x31, 0x01, ..] => FileKind::OpenExr,
        [b'I', b'I', 42 | 43, 0, ..] | [b'M', b'M', 0, 42 | 43, ..] => FileKind::Tiff,
        [0x89, b'P', b'N', b'G', ..] => FileKind::Png,
        [b'#', b'?', ..] => FileKind::Radiance,
        _ => FileKind::Other,
    }
}

/// What the header of an image claims.
#[derive(Clone, Copy)]
struct Claim {
    width: u64,
    height: u64,
    /// Bits of a texel before compression.
    stored_bits: u64,
    /// Bytes of a decoded texel.
    decoded_bytes: u64,
}

impl Claim {
    /// Refuses sides that are zero or too large, and more texels than a file of `file_length` bytes can
    /// hold where compression makes at most `strongest` bytes of one: such a file is cut or forged.
    /// Hands back the bytes of the decoded image.
    fn check(self, strongest: u64, file_length: u64) -> Result<u64> {
        let fault = |expected: String| {
            Err(Error::data("size", format!("{} × {}", self.width, self.height)).expected(expected))
        };
        let texels = self.width.saturating_mul(self.height);
        if texels == 0 || texels > MOST_TEXELS {
            return fault(format!("1 to {MOST_TEXELS} texels"));
        }
        let decoded = texels.saturating_mul(self.decoded_bytes);
        let stored = texels.saturating_mul(self.stored_bits) / 8;
        if decoded > HARMLESS && stored / strongest > file_length {
            return fault(format!(
                "fewer texels in a file of {file_length} bytes: it is truncated or not what it claims"
            ));
        }
        Ok(decoded)
    }
}

/// A fault of a decoder, in its own words.
fn undecodable(error: impl std::fmt::Display) -> Error {
    Error::data("image", error.to_string())
        .expected("PNG, JPEG, TIFF, GIF, BMP, Radiance HDR or OpenEXR")
}

#[cfg(test)]
mod tests;
