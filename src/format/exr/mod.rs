//! OpenEXR frames: any channels and header attributes out; attributes and single channels back in.
//!
//! One part, scan lines. The same content is the same bytes: blocks are compressed in parallel but
//! written in order, and the header's attributes are sorted by name (the `exr` crate keeps those
//! beyond the standard's in a hash map). Not handled: tiles, deep data, subsampled channels.

mod zip;

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::Cursor;
use std::path::Path;

use ::exr::block::chunk::{Chunk, CompressedBlock, CompressedScanLineBlock};
use ::exr::block::writer::ChunksWriter;
use ::exr::block::{BlockIndex, UncompressedBlock};
use ::exr::compression::Compression as ExrCompression;
use ::exr::math::Vec2;
use ::exr::meta::attribute::{
    AttributeValue, ChannelDescription, Chromaticities, LineOrder, SampleType, Text,
};
use ::exr::meta::header::{Header, LayerAttributes};
use ::exr::meta::{BlockDescription, MetaData};
use half::f16;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};
use crate::format::atomic;
use crate::format::guard::guarded;

/// How the pixels are compressed. All but `pxr24` keep every bit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Compression {
    /// Not at all: largest files, least work.
    None,
    /// Runs of equal bytes.
    Rle,
    /// Deflate, line by line.
    Zips,
    /// Deflate, 16 lines at a time.
    #[default]
    Zip,
    /// Wavelets and Huffman codes.
    Piz,
    /// Deflate; 32-bit floats lose their last 8 bits.
    Pxr24,
}

impl From<Compression> for ExrCompression {
    fn from(compression: Compression) -> Self {
        match compression {
            Compression::None => Self::Uncompressed,
            Compression::Rle => Self::RLE,
            Compression::Zips => Self::ZIP1,
            Compression::Zip => Self::ZIP16,
            Compression::Piz => Self::PIZ,
            Compression::Pxr24 => Self::PXR24,
        }
    }
}

/// The numbers of one channel, row by row from the top.
#[derive(Clone, Debug, PartialEq)]
pub enum Numbers<'a> {
    /// 16-bit floats.
    Half(Cow<'a, [f16]>),
    /// 32-bit floats.
    Float(Cow<'a, [f32]>),
    /// 32-bit unsigned integers.
    Uint(Cow<'a, [u32]>),
}

impl Numbers<'_> {
    fn sample_type(&self) -> SampleType {
        match self {
            Self::Half(_) => SampleType::F16,
            Self::Float(_) => SampleType::F32,
            Self::Uint(_) => SampleType::U32,
        }
    }

    fn len(&self) -> usize {
        match self {
            Self::Half(numbers) => numbers.len(),
            Self::Float(numbers) => numbers.len(),
            Self::Uint(numbers) => numbers.len(),
        }
    }

    fn bytes_each(&self) -> usize {
        self.sample_type().bytes_per_sample()
    }

    /// Some of the numbers, as bytes in the machine's order.
    fn bytes(&self, range: std::ops::Range<usize>) -> &[u8] {
        match self {
            Self::Half(numbers) => bytemuck::cast_slice(&numbers[range]),
            Self::Float(numbers) => bytemuck::cast_slice(&numbers[range]),
            Self::Uint(numbers) => bytemuck::cast_slice(&numbers[range]),
        }
    }
}

/// A header attribute of a frame.
#[derive(Clone, Debug, PartialEq)]
pub enum Attribute {
    /// `string`
    Text(String),
    /// `float`
    Float(f32),
    /// `int`
    Int(i32),
    /// `v3f`
    Vector([f32; 3]),
    /// `m44f`, row-major.
    Matrix([f32; 16]),
}

/// A picture in memory with what its header says.
#[derive(Clone, Debug, PartialEq)]
pub struct ExrImage<'a> {
    /// Columns and rows.
    pub size: [u32; 2],
    /// Channels by name; written in the names' order.
    pub channels: BTreeMap<String, Numbers<'a>>,
    /// Attributes by name. `worldToCamera` and `worldToNDC` are matrices.
    pub attributes: BTreeMap<String, Attribute>,
}

/// CIE xy of Rec. 709's primaries and white, as the `chromaticities` of every frame.
pub const REC709: [[f32; 2]; 4] = [[0.64, 0.33], [0.30, 0.60], [0.15, 0.06], [0.3127, 0.3290]];

/// CIE xy of XYZ itself and of equal energy: the `chromaticities` of tristimulus values.
pub const XYZ: [[f32; 2]; 4] = [[1.0, 0.0], [0.0, 1.0], [0.0, 0.0], [1.0 / 3.0, 1.0 / 3.0]];

/// Encodes an image of Rec. 709; `write` puts the bytes in place.
pub fn encode(image: &ExrImage, compression: Compression) -> Result<Vec<u8>> {
    encode_with(image, compression, REC709)
}

/// Encodes an image of other primaries and another white.
pub fn encode_with(
    image: &ExrImage,
    compression: Compression,
    chromaticities: [[f32; 2]; 4],
) -> Result<Vec<u8>> {
    let header = header(image, compression, chromaticities)?;
    let mut bytes = Cursor::new(Vec::new());
    ::exr::block::write(
        &mut bytes,
        [header].into_iter().collect(),
        true,
        |meta, writer| {
            for (index, chunk) in compress(image, compression, &meta)? {
                writer.write_chunk(index, chunk)?;
            }
            Ok(())
        },
    )
    .map_err(|error| Error::data("EXR image", error.to_string()))?;
    let mut bytes = bytes.into_inner();
    sort_attributes(&mut bytes)?;
    Ok(bytes)
}

/// Writes encoded bytes as a file that appears complete or not at all.
pub fn write(path: &Path, encoded: &[u8]) -> Result<()> {
    use std::io::Write;
    atomic::write_file(path, |sink| sink.write_all(encoded))
}

fn header(
    image: &ExrImage,
    compression: Compression,
    chromaticities: [[f32; 2]; 4],
) -> Result<Header> {
    // Check the lengths of the channels.
    let [width, height] = image.size.map(|side| side as usize);
    for (name, numbers) in &image.channels {
        if numbers.len() != width * height {
            return Err(
                Error::data(format!("channel {name}"), numbers.len().to_string())
                    .expected(format!("{width} × {height} numbers")),
            );
        }
    }
    // Describe the channels.
    let channels = image
        .channels
        .iter()
        .map(|(name, numbers)| ChannelDescription::named(text(name), numbers.sample_type()))
        .collect();
    let mut header = Header::new(text("frame"), (width, height), channels).with_encoding(
        compression.into(),
        BlockDescription::ScanLines,
        LineOrder::Increasing,
    );
    // State the primaries.
    let [red, green, blue, white] = chromaticities.map(|[x, y]| Vec2(x, y));
    header.shared_attributes.chromaticities = Some(Chromaticities {
        red,
        green,
        blue,
        white,
    });
    header.own_attributes = LayerAttributes::default();
    header.own_attributes.screen_window_width = 1.0;
    // Add the attributes; those of the standard have places of their own.
    for (name, attribute) in &image.attributes {
        let value = match attribute {
            Attribute::Text(value) => AttributeValue::Text(text(value)),
            Attribute::Float(value) => AttributeValue::F32(*value),
            Attribute::Int(value) => AttributeValue::I32(*value),
            Attribute::Vector([x, y, z]) => AttributeValue::FloatVec3((*x, *y, *z)),
            Attribute::Matrix(value) => match name.as_str() {
                "worldToCamera" => {
                    header.own_attributes.world_to_camera = Some(*value);
                    continue;
                }
                "worldToNDC" => {
                    header.own_attributes.world_to_normalized_device = Some(*value);
                    continue;
                }
                _ => AttributeValue::Matrix4x4(*value),
            },
        };
        header.own_attributes.other.insert(text(name), value);
    }
    Ok(header)
}

fn text(value: &str) -> Text {
    Text::from_bytes_unchecked(value.bytes().collect())
}

/// Compresses all blocks in parallel; the result is in the file's order.
fn compress(
    image: &ExrImage,
    compression: Compression,
    meta: &MetaData,
) -> ::exr::error::Result<Vec<(usize, Chunk)>> {
    let blocks: Vec<_> = meta.enumerate_ordered_header_block_indices().collect();
    blocks
        .into_par_iter()
        .map(|(position, index)| {
            let chunk = match compression {
                Compression::Zip | Compression::Zips => zip_chunk(image, &index)?,
                _ => None,
            };
            let chunk = match chunk {
                Some(chunk) => chunk,
                None => {
                    let data = block_bytes(image, &index);
                    UncompressedBlock { index, data }.compress_to_chunk(&meta.headers)?
                }
            };
            Ok((position, chunk))
        })
        .collect()
}

/// A block deflated here; `None` where that saves nothing.
fn zip_chunk(image: &ExrImage, index: &BlockIndex) -> std::io::Result<Option<Chunk>> {
    let first = index.pixel_position.y();
    let compressed = zip::compress(image, first..first + index.pixel_size.y())?;
    Ok(compressed.map(|compressed_pixels_le| Chunk {
        layer_index: index.layer,
        compressed_block: CompressedBlock::ScanLine(CompressedScanLineBlock {
            y_coordinate: first as i32,
            compressed_pixels_le,
        }),
    }))
}

/// A block's numbers: line by line, channel by channel.
fn block_bytes(image: &ExrImage, index: &BlockIndex) -> Vec<u8> {
    let width = image.size[0] as usize;
    let first = index.pixel_position.y();
    let bytes_a_pixel: usize = image.channels.values().map(Numbers::bytes_each).sum();
    let mut bytes = Vec::with_capacity(width * index.pixel_size.y() * bytes_a_pixel);
    for row in first..first + index.pixel_size.y() {
        for numbers in image.channels.values() {
            bytes.extend_from_slice(numbers.bytes(row * width..(row + 1) * width));
        }
    }
    bytes
}

/// Where the header's attributes begin: after the magic number and the version.
const ATTRIBUTES_AT: usize = 8;

/// Sorts the header's attributes by name, in place: none changes its length.
fn sort_attributes(bytes: &mut [u8]) -> Result<()> {
    let unreadable = || Error::data("EXR header", "attributes that cannot be followed");
    let mut attributes: Vec<&[u8]> = Vec::new();
    let mut at = ATTRIBUTES_AT;
    while *bytes.get(at).ok_or_else(unreadable)? != 0 {
        let length = attribute_length(&bytes[at..]).ok_or_else(unreadable)?;
        attributes.push(bytes.get(at..at + length).ok_or_else(unreadable)?);
        at += length;
    }
    attributes.sort_unstable();
    let sorted = attributes.concat();
    bytes[ATTRIBUTES_AT..at].copy_from_slice(&sorted);
    Ok(())
}

/// The length of the attribute that `bytes` begin with: name, type, size, value.
fn attribute_length(bytes: &[u8]) -> Option<usize> {
    let name = bytes.iter().position(|&byte| byte == 0)? + 1;
    let kind = bytes[name..].iter().position(|&byte| byte == 0)? + 1;
    let size = bytes.get(name + kind..)?.first_chunk::<4>()?;
    (name + kind + 4).checked_add(u32::from_le_bytes(*size) as usize)
}

/// Reads a header's text attribute; `None` when the file is no EXR or has no such attribute.
pub fn read_text_attribute(path: &Path, name: &str) -> Option<String> {
    let read = guarded(path, || {
        let meta = MetaData::read_from_file(path, false)
            .map_err(|error| Error::data("EXR header", error.to_string()))?;
        let own = meta.headers.first().map(|header| &header.own_attributes);
        Ok(match own.and_then(|own| own.other.get(&text(name))) {
            Some(AttributeValue::Text(value)) => Some(value.to_string()),
            _ => None,
        })
    });
    read.ok().flatten()
}

#[cfg(test)]
mod tests {
    use super::*;
    use ::exr::prelude::{FlatSamples, read};

    fn image() -> ExrImage<'static> {
        let (width, height) = (37, 21);
        let count = width * height;
        let ramp = |k: usize| (k as f32 * 0.37).sin().abs();
        let mut channels = BTreeMap::new();
        let halfs: Vec<_> = (0..count).map(|k| f16::from_f32(ramp(k))).collect();
        channels.insert("R".into(), Numbers::Half(halfs.into()));
        let depths: Vec<f32> = (0..count).map(ramp).collect();
        channels.insert("Z".into(), Numbers::Float(depths.into()));
        let labels: Vec<u32> = (0..count as u32).map(|k| k * 99_991).collect();
        channels.insert("texton.I".into(), Numbers::Uint(labels.into()));
        let mut matrix = [0.0; 16];
        matrix[12] = 7.0;
        let attributes = [
            ("worldToCamera", Attribute::Matrix(matrix)),
            ("lightDirection", Attribute::Vector([0.0, 1.0, 0.0])),
            ("lightIrradiance", Attribute::Float(2.5)),
            ("frame", Attribute::Int(12)),
            ("mesotex:options", Attribute::Text("{\"a\": 1}".into())),
        ];
        ExrImage {
            size: [width as u32, height as u32],
            channels,
            attributes: attributes
                .map(|(name, value)| (name.to_string(), value))
                .into(),
        }
    }

    #[test]
    fn every_lossless_compression_round_trips() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        let image = image();
        for compression in [
            Compression::None,
            Compression::Rle,
            Compression::Zips,
            Compression::Zip,
            Compression::Piz,
        ] {
            write(&path, &encode(&image, compression).unwrap()).unwrap();
            let back = ::exr::prelude::read_all_flat_layers_from_file(&path).unwrap();
            let layer = &back.layer_data[0];
            for channel in &layer.channel_data.list {
                let numbers = match &channel.sample_data {
                    FlatSamples::F16(v) => Numbers::Half(v.into()),
                    FlatSamples::F32(v) => Numbers::Float(v.into()),
                    FlatSamples::U32(v) => Numbers::Uint(v.into()),
                };
                assert_eq!(numbers, image.channels[&channel.name.to_string()]);
            }
            assert_eq!(layer.attributes.world_to_camera.unwrap()[12], 7.0);
            let light = &layer.attributes.other[&text("lightDirection")];
            assert_eq!(*light, AttributeValue::FloatVec3((0.0, 1.0, 0.0)));
            assert!(back.attributes.chromaticities.is_some());
        }
        let options = read_text_attribute(&path, "mesotex:options");
        assert_eq!(options.as_deref(), Some("{\"a\": 1}"));
        assert_eq!(read_text_attribute(&path, "nothing"), None);
        let _ = read();
    }

    #[test]
    fn the_same_image_is_the_same_bytes() {
        let first = encode(&image(), Compression::Zip).unwrap();
        for _ in 0..20 {
            assert_eq!(encode(&image(), Compression::Zip).unwrap(), first);
        }
    }

    #[test]
    fn channels_of_another_size_are_refused() {
        let mut image = image();
        image
            .channels
            .insert("A".into(), Numbers::Float(vec![0.0].into()));
        let error = encode(&image, Compression::Zip).unwrap_err().to_string();
        assert!(error.contains("channel A"), "{error}");
    }
}
