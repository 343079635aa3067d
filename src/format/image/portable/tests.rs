//! PNG files made here, byte by byte or by another writer; what is odd, what is refused.

use std::fs;

use super::*;
use crate::format::image::{Encoding, FloatImage, ReadOptions, read_with};

fn chunk(kind: &[u8; 4], content: &[u8]) -> Vec<u8> {
    let mut checked = kind.to_vec();
    checked.extend(content);
    let mut chunk = (content.len() as u32).to_be_bytes().to_vec();
    chunk.extend(&checked);
    chunk.extend(crc32fast::hash(&checked).to_be_bytes());
    chunk
}

fn zipped(bytes: &[u8]) -> Vec<u8> {
    let mut packed = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::fast());
    std::io::Write::write_all(&mut packed, bytes).unwrap();
    packed.finish().unwrap()
}

/// One row of a PNG with chunks before its pixels.
fn png(columns: u8, depth: u8, color: u8, chunks: &[Vec<u8>], row: &[u8]) -> Vec<u8> {
    let header = [0, 0, 0, columns, 0, 0, 0, 1, depth, color, 0, 0, 0];
    let mut raw = vec![0];
    raw.extend(row);
    let mut bytes = b"\x89PNG\r\n\x1a\n".to_vec();
    bytes.extend(chunk(b"IHDR", &header));
    bytes.extend(chunks.concat());
    bytes.extend(chunk(b"IDAT", &zipped(&raw)));
    bytes.extend(chunk(b"IEND", b""));
    bytes
}

fn read_bytes(bytes: &[u8], options: &ReadOptions) -> Result<FloatImage> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.png");
    fs::write(&path, bytes).unwrap();
    read_with(&path, options).map(|read| read.image)
}

fn gama(scaled: u32) -> Vec<u8> {
    chunk(b"gAMA", &scaled.to_be_bytes())
}

fn near(found: &[f32], expected: &[f32]) {
    assert_eq!(found.len(), expected.len());
    for (found, expected) in found.iter().zip(expected) {
        assert!((found - expected).abs() < 1e-5, "{found} {expected}");
    }
}

#[test]
fn statements_hold_in_the_order_of_the_standard() {
    let mut profile = b"p\0\0".to_vec();
    profile.extend(zipped(
        &moxcms::ColorProfile::new_gray_with_gamma(2.0)
            .encode()
            .unwrap(),
    ));
    let iccp = chunk(b"iCCP", &profile);
    let cicp = chunk(b"cICP", &[1, 8, 0, 1]);
    let srgb = chunk(b"sRGB", b"\0");
    let read = |chunks: &[Vec<u8>]| {
        let bytes = png(1, 8, 0, chunks, &[51]);
        read_bytes(&bytes, &ReadOptions::default()).unwrap()
    };
    let gamma = read(&[gama(100_000)]);
    assert_eq!((gamma.encoding, gamma.data[0]), (Encoding::Linear, 0.2));
    near(&read(&[gama(50_000)]).data, &[0.04]);
    assert_eq!(read(&[srgb, gama(100_000)]).encoding, Encoding::Srgb);
    let profiled = read(&[iccp.clone(), gama(100_000)]);
    assert!(
        (profiled.data[0] - 0.04).abs() < 1e-4,
        "{:?}",
        profiled.data
    );
    let points = read(&[cicp, iccp, gama(50_000)]);
    assert_eq!((points.encoding, points.data[0]), (Encoding::Linear, 0.2));
    assert_eq!(read(&[]).encoding, Encoding::Srgb);
}

#[test]
fn data_and_options_are_before_what_the_file_says() {
    let bytes = png(1, 8, 0, &[gama(50_000)], &[51]);
    let data = read_bytes(&bytes, &ReadOptions::data()).unwrap();
    assert_eq!((data.encoding, data.data[0]), (Encoding::Data, 0.2));
    let linear = ReadOptions {
        encoding: crate::format::image::SourceEncoding::Linear,
        ..ReadOptions::default()
    };
    let image = read_bytes(&bytes, &linear).unwrap();
    assert_eq!((image.encoding, image.data[0]), (Encoding::Linear, 0.2));
}

#[test]
fn what_cannot_be_followed_is_refused_for_colour_alone() {
    let pq = png(1, 8, 0, &[chunk(b"cICP", &[9, 16, 0, 1])], &[51]);
    let error = read_bytes(&pq, &ReadOptions::default())
        .unwrap_err()
        .to_string();
    assert!(error.contains("PQ"), "{error}");
    assert!(read_bytes(&pq, &ReadOptions::data()).is_ok());
}

#[test]
fn small_depths_palettes_and_sixteen_bits_are_whole() {
    let data = |bytes: &[u8]| read_bytes(bytes, &ReadOptions::data()).unwrap().data;
    near(
        &data(&png(4, 2, 0, &[], &[0b00_01_10_11])),
        &[0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0],
    );
    assert_eq!(data(&png(1, 16, 0, &[], &[0x12, 0x34])), [4660.0 / 65535.0]);
    let palette = chunk(b"PLTE", &[255, 0, 0, 0, 0, 255]);
    near(
        &data(&png(2, 1, 3, &[palette], &[0b0100_0000])),
        &[1.0, 0.0, 0.0, 0.0, 0.0, 1.0],
    );
}

#[test]
fn transparent_texels_are_counted_and_refused() {
    let hidden = png(2, 8, 6, &[], &[255, 0, 255, 0, 10, 20, 30, 255]);
    let error = read_bytes(&hidden, &ReadOptions::default())
        .unwrap_err()
        .to_string();
    assert!(error.contains("1 of 2 texels are not opaque"), "{error}");
    let black = ReadOptions {
        alpha: crate::format::image::Alpha::OverBlack,
        ..ReadOptions::default()
    };
    assert_eq!(read_bytes(&hidden, &black).unwrap().data[..3], [0.0; 3]);
    let ignored = ReadOptions {
        alpha: crate::format::image::Alpha::Ignore,
        ..ReadOptions::default()
    };
    assert_eq!(
        read_bytes(&hidden, &ignored).unwrap().data[..3],
        [1.0, 0.0, 1.0]
    );
    // A transparent colour named by tRNS.
    let keyed = png(2, 8, 0, &[chunk(b"tRNS", &[0, 9])], &[9, 8]);
    let error = read_bytes(&keyed, &ReadOptions::default())
        .unwrap_err()
        .to_string();
    assert!(error.contains("1 of 2"), "{error}");
}

#[test]
fn the_orientation_of_exif_is_followed_on_request() {
    let exif = b"II\x2a\0\x08\0\0\0\x01\0\x12\x01\x03\0\x01\0\0\0\x06\0\0\0\0\0\0\0";
    let bytes = png(3, 8, 0, &[chunk(b"eXIf", exif)], &[51, 102, 255]);
    let upright = read_bytes(&bytes, &ReadOptions::default()).unwrap();
    assert_eq!((upright.width, upright.height), (1, 3));
    let stored = ReadOptions {
        orientation: crate::format::image::Orientation::Stored,
        ..ReadOptions::default()
    };
    assert_eq!(read_bytes(&bytes, &stored).unwrap().width, 3);
}
