//! Small image sets and archives, made by code.
#![allow(dead_code, reason = "every test file uses its own part")]

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fs;
use std::io::{Cursor, Write};
use std::path::{Path, PathBuf};

use image::{ImageFormat, Rgb, RgbImage};
use mesotex::btf::Direction;
use mesotex::format::exr;
use mesotex::format::exr::{Compression, ExrImage, Numbers};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

/// Writes an archive of these members.
pub fn zip(path: &Path, members: &BTreeMap<PathBuf, Vec<u8>>, stored: bool) {
    fs::write(path, zipped(members, stored)).unwrap();
}

/// An archive of these members.
pub fn zipped(members: &BTreeMap<PathBuf, Vec<u8>>, stored: bool) -> Vec<u8> {
    let method = match stored {
        true => CompressionMethod::Stored,
        false => CompressionMethod::Deflated,
    };
    let options = SimpleFileOptions::default().compression_method(method);
    let mut writer = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, bytes) in members {
        writer.start_file(name.to_str().unwrap(), options).unwrap();
        writer.write_all(bytes).unwrap();
    }
    writer.finish().unwrap().into_inner()
}

/// Writes an image of one grey.
pub fn grey(path: &Path, width: u32, height: u32, number: u8) {
    let image = RgbImage::from_pixel(width, height, Rgb([number; 3]));
    image.save(path).unwrap();
}

/// The name of an image of UBO2003.
pub fn ubo_name(number: usize, light: Direction, view: Direction) -> String {
    let degrees = |radians: f64| radians.to_degrees().round() as u32 % 360;
    let [tl, pl, tv, pv] = [light.theta(), light.phi(), view.theta(), view.phi()].map(degrees);
    format!("SET/tv{tv:03}_pv{pv:03}/{number:05} tl{tl:03} pl{pl:03} tv{tv:03} pv{pv:03}.jpg")
}

/// A 24-bit bitmap of one grey.
pub fn bitmap(width: u32, height: u32, number: u8) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    RgbImage::from_pixel(width, height, Rgb([number; 3]))
        .write_to(&mut bytes, ImageFormat::Bmp)
        .unwrap();
    bytes.into_inner()
}

/// A file of Unix compress: every byte a code of 9 bits, the table cleared before codes would grow.
pub fn compressed(bytes: &[u8]) -> Vec<u8> {
    let mut bits: Vec<bool> = Vec::new();
    for chunk in bytes.chunks(200) {
        let codes = chunk.iter().map(|&byte| u32::from(byte));
        for code in codes.chain([256]) {
            bits.extend((0..9).map(|bit| code >> bit & 1 == 1));
        }
        let group = bits.len().next_multiple_of(9 * 8);
        bits.resize(group, false);
    }
    let byte = |bits: &[bool]| {
        bits.iter()
            .rev()
            .fold(0, |held, &bit| held << 1 | u8::from(bit))
    };
    let mut file = vec![0x1f, 0x9d, 0x90];
    file.extend(bits.chunks(8).map(byte));
    file
}

/// Writes a spectral image of 3 × 2 texels, 400 to 720 nm in steps of 10.
pub fn spectral(path: &Path, reflectance: impl Fn(f64) -> f32) {
    let channels = (400..=720).step_by(10).map(|nm| {
        let numbers = vec![reflectance(f64::from(nm)); 6];
        (format!("{nm}.000000"), Numbers::Float(Cow::Owned(numbers)))
    });
    let image = ExrImage {
        size: [3, 2],
        channels: channels.collect(),
        attributes: BTreeMap::new(),
    };
    exr::write(path, &exr::encode(&image, Compression::Zip).unwrap()).unwrap();
}

/// Writes an image of 2 × 2 texels in channels X, Y and Z.
pub fn xyz(path: &Path, color: [f32; 3]) {
    let plane = |value: f32| Numbers::Float(Cow::Owned(vec![value; 4]));
    let channels = ["X", "Y", "Z"].into_iter().zip(color);
    let image = ExrImage {
        size: [2, 2],
        channels: channels
            .map(|(name, value)| (name.to_owned(), plane(value)))
            .collect(),
        attributes: BTreeMap::new(),
    };
    exr::write(path, &exr::encode(&image, Compression::Zip).unwrap()).unwrap();
}

/// A Radiance file whose size line names columns first, its pixels being rows: red counts columns, green rows,
/// in sixteenths.
pub fn hdr_with_faulty_line(width: u8, height: u8) -> Vec<u8> {
    let mut file = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n".to_vec();
    file.extend(format!("+X {width} -Y {height}\n").into_bytes());
    for row in 0..height {
        for column in 0..width {
            // Exponent 128: mantissas are 256ths.
            file.extend([column * 16, row * 16, 8, 128]);
        }
    }
    file
}
