//! Every format read back from what another writer (or bytes by hand) put there; bad input.

use std::fs;

use exr::prelude::{WritableImage, write_rgb_file};
use image::{ImageBuffer, Luma, Rgb, Rgba};

use super::*;

fn folder() -> tempfile::TempDir {
    tempfile::tempdir().unwrap()
}

#[test]
fn integers_are_scaled_and_opaque_alpha_is_left_out() {
    let folder = folder();
    let path = folder.path().join("a.png");
    let rgba = ImageBuffer::from_fn(3, 2, |x, y| Rgba([x as u8 * 10, y as u8, 255, 255]));
    rgba.save(&path).unwrap();
    let image = read(&path).unwrap();
    assert_eq!((image.width, image.height, image.channels), (3, 2, 3));
    assert_eq!(image.get(1, 2, 0), 20.0 / 255.0);
    assert_eq!(image.get(1, 2, 1), 1.0 / 255.0);
    assert_eq!(
        (image.encoding, image.precision),
        (Encoding::Srgb, Precision::Bits8)
    );
    let deep: ImageBuffer<Luma<u16>, Vec<u16>> =
        ImageBuffer::from_fn(2, 1, |x, _| Luma([1 + 60000 * x as u16]));
    for name in ["b.png", "b.tif"] {
        let path = folder.path().join(name);
        deep.save(&path).unwrap();
        let image = read(&path).unwrap();
        assert_eq!(image.data, [1.0 / 65535.0, 60001.0 / 65535.0], "{name}");
        assert_eq!(image.precision, Precision::Bits16);
    }
}

#[test]
fn float_formats_are_linear_as_they_stand() {
    let folder = folder();
    let pixel = |x: usize, y: usize| (x as f32 - 0.5, y as f32 * 100.0, 0.25_f32);
    let exr = folder.path().join("a.exr");
    write_rgb_file(&exr, 3, 2, pixel).unwrap();
    let image = read(&exr).unwrap();
    assert_eq!(image.get(1, 2, 0), 1.5);
    assert_eq!(image.get(1, 2, 1), 100.0);
    assert_eq!(image.encoding, Encoding::Linear);
    let tif = folder.path().join("a.tif");
    let floats: ImageBuffer<Rgb<f32>, Vec<f32>> =
        ImageBuffer::from_fn(3, 2, |x, y| Rgb([x as f32, y as f32, -2.0]));
    floats.save(&tif).unwrap();
    let image = read(&tif).unwrap();
    assert_eq!(&image.data[15..], [2.0, 1.0, -2.0]);
}

#[test]
fn a_gray_float_tiff_and_a_single_exr_channel_are_read() {
    let folder = folder();
    let tif = folder.path().join("h.tif");
    let file = fs::File::create(&tif).unwrap();
    tiff::encoder::TiffEncoder::new(file)
        .unwrap()
        .write_image::<tiff::encoder::colortype::Gray32Float>(2, 1, &[0.5, -3.0])
        .unwrap();
    assert_eq!(read(&tif).unwrap().data, [0.5, -3.0]);
    let exr = folder.path().join("h.exr");
    let channels = exr::prelude::SpecificChannels::new(
        (exr::prelude::ChannelDescription::named(
            "displacement",
            exr::prelude::SampleType::F32,
        ),),
        |at: exr::prelude::Vec2<usize>| (at.0 as f32,),
    );
    exr::prelude::Image::from_channels((2, 1), channels)
        .write()
        .to_file(&exr)
        .unwrap();
    assert_eq!(read(&exr).unwrap().data, [0.0, 1.0]);
}

#[test]
fn srgb_is_decoded_by_its_curve_and_back() {
    assert_eq!(decode_srgb(0.0), 0.0);
    assert!((decode_srgb(1.0) - 1.0).abs() < 1e-6);
    // The published value of mid grey 188/255.
    assert!((decode_srgb(188.0 / 255.0) - 0.502_886).abs() < 1e-5);
    for stored in 0..=255_u8 {
        assert_eq!(encode_srgb8(decode_srgb(f32::from(stored) / 255.0)), stored);
    }
}

#[test]
fn gray_and_color_convert() {
    let gray = FloatImage {
        width: 2,
        height: 1,
        channels: 1,
        data: vec![0.25, 0.5],
        encoding: Encoding::Linear,
        precision: Precision::Float,
    };
    let color = gray.clone().into_rgb();
    assert_eq!(color.data, [0.25, 0.25, 0.25, 0.5, 0.5, 0.5]);
    assert_eq!(color.into_gray(), gray);
}

#[test]
fn previews_read_back() {
    let folder = folder();
    let path = folder.path().join("p.png");
    write_png(&path, 2, 1, &[0, 128, 255, 1, 2, 3]).unwrap();
    assert_eq!(read(&path).unwrap().get(0, 1, 2), 3.0 / 255.0);
    write_png(&path, 2, 1, &[9, 8]).unwrap();
    assert_eq!(read(&path).unwrap().channels, 1);
    assert!(write_png(&path, 2, 2, &[0; 5]).is_err());
}

#[test]
fn not_a_number_is_found_by_place() {
    let folder = folder();
    let path = folder.path().join("n.exr");
    write_rgb_file(&path, 3, 2, |x, y| {
        (0.0_f32, if (x, y) == (2, 1) { f32::NAN } else { 0.0 }, 0.0)
    })
    .unwrap();
    let error = read(&path).unwrap().check_finite().unwrap_err().to_string();
    assert!(error.contains("row 1, column 2, channel 1: NaN"), "{error}");
}

#[test]
fn what_is_no_image_is_refused_with_its_name() {
    let folder = folder();
    let whole = folder.path().join("a.png");
    write_png(&whole, 40, 40, &[77; 4800]).unwrap();
    let bytes = fs::read(&whole).unwrap();
    let broken = |name: &str, bytes: &[u8]| {
        let path = folder.path().join(name);
        fs::write(&path, bytes).unwrap();
        let error = read(&path).unwrap_err().to_string();
        assert!(error.contains(name), "{error}");
        error
    };
    broken("cut.png", &bytes[..bytes.len() / 2]);
    broken("empty.png", &[]);
    broken("text.png", b"this is a text");
    broken("cut.exr", &[0x76, 0x2f, 0x31, 0x01, 2]);
    broken("cut.tif", b"II\x2a\0\x08\0");
    assert!(read(&folder.path().join("missing.png")).is_err());
}

#[test]
fn a_forged_size_is_refused_before_it_is_allocated() {
    let folder = folder();
    let path = folder.path().join("huge.png");
    // A PNG header that claims 16384 × 16384 RGB, and nothing after it.
    let mut bytes = b"\x89PNG\r\n\x1a\n\0\0\0\x0dIHDR\0\0\x40\0\0\0\x40\0\x08\x02\0\0\0".to_vec();
    let mut crc = flate2::Crc::new();
    crc.update(&bytes[12..29]);
    bytes.extend(crc.sum().to_be_bytes());
    bytes.extend(b"\0\0\0\x04IDATabcd\0\0\0\0");
    fs::write(&path, &bytes).unwrap();
    let error = read(&path).unwrap_err().to_string();
    assert!(error.contains("16384 × 16384"), "{error}");
    let refused = |width, height, file_length| {
        let claim = Claim {
            width,
            height,
            stored_bits: 24,
            decoded_bytes: 3,
        };
        claim.check(1032, file_length).is_err()
    };
    assert!(refused(1 << 20, 1 << 20, u64::MAX) && refused(0, 5, 100) && refused(u64::MAX, 2, 100));
    assert!(
        !refused(2048, 2048, 100) && refused(4096, 4096, 40_000) && !refused(4096, 4096, 50_000)
    );
}

/// A GIF whose header claims 4096 × 4096 and whose one frame is a single pixel.
#[test]
fn a_gif_beyond_what_its_bytes_can_hold_is_refused() {
    let folder = folder();
    let path = folder.path().join("big.gif");
    let mut bytes = b"GIF89a\0\x10\0\x10\x80\0\0\0\0\0\xff\xff\xff".to_vec();
    bytes.extend(b",\0\0\0\0\x01\0\x01\0\0\x02\x02\x44\x01\0;");
    fs::write(&path, &bytes).unwrap();
    let error = read(&path).unwrap_err().to_string();
    assert!(error.contains("4096 × 4096"), "{error}");
}

fn png_chunk(kind: &[u8; 4], content: &[u8]) -> Vec<u8> {
    let mut checked = kind.to_vec();
    checked.extend(content);
    let mut crc = flate2::Crc::new();
    crc.update(&checked);
    let mut chunk = (content.len() as u32).to_be_bytes().to_vec();
    chunk.extend(checked);
    chunk.extend(crc.sum().to_be_bytes());
    chunk
}

/// The png crate panics over it, which is no reason to take the program down.
#[test]
fn a_palette_of_a_broken_length_is_an_error_that_names_the_file() {
    crate::format::guard::silence();
    let folder = folder();
    let path = folder.path().join("palette.png");
    let mut packed = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::fast());
    std::io::Write::write_all(&mut packed, &[0, 1]).unwrap();
    let bytes = [
        b"\x89PNG\r\n\x1a\n".to_vec(),
        png_chunk(b"IHDR", b"\0\0\0\x01\0\0\0\x01\x08\x03\0\0\0"),
        png_chunk(b"PLTE", &[1, 2, 3, 4]),
        png_chunk(b"IDAT", &packed.finish().unwrap()),
        png_chunk(b"IEND", b""),
    ];
    fs::write(&path, bytes.concat()).unwrap();
    let error = read(&path).unwrap_err().to_string();
    assert!(error.contains("palette.png"), "{error}");
}
