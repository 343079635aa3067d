//! JPEG, GIF and BMP, through the `image` crate.

use std::io::Cursor;

use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits};

use crate::error::{Error, Result};
use crate::format::image::color::Statement;
use crate::format::image::decoded::{Decoded, channel_names, only_part, split_alpha};
use crate::format::image::facts::Facts;
use crate::format::image::jpeg_header::JpegHeader;
use crate::format::image::orientation::of_exif;
use crate::format::image::{Claim, HARMLESS, Note, Precision, WORKING, icc, undecodable};

/// Bytes that one byte of a file can stand for.
fn strongest_compression(format: ImageFormat) -> u64 {
    match format {
        // 64 numbers in a bit or two.
        ImageFormat::Jpeg => 1024,
        // LZW: at most 4095 numbers in 12 bits.
        ImageFormat::Gif => 2730,
        // Runs of 255 palette entries in 2 bytes.
        _ => 128,
    }
}

/// A decoder of the whole file, its format, and its header if that is JPEG's.
///
/// Refuses formats that are not read, and sizes that the file is too short for.
fn decoder(bytes: &[u8]) -> Result<(impl ImageDecoder, ImageFormat, Option<JpegHeader>)> {
    // Find the format.
    let file_length = bytes.len() as u64;
    let mut reader = ImageReader::new(Cursor::new(bytes))
        .with_guessed_format()
        .map_err(undecodable)?;
    let format = match reader.format() {
        Some(format @ (ImageFormat::Jpeg | ImageFormat::Gif | ImageFormat::Bmp)) => format,
        _ => return Err(undecodable("an unsupported format, or not an image")),
    };
    let jpeg = (format == ImageFormat::Jpeg).then(|| JpegHeader::of(bytes));
    if let Some(header) = &jpeg {
        check_jpeg(header)?;
    }
    // Bound what the decoder may allocate.
    let strongest = strongest_compression(format);
    let mut limits = Limits::no_limits();
    let most = file_length.saturating_mul(strongest).max(HARMLESS);
    limits.max_alloc = Some(most.saturating_add(WORKING));
    reader.limits(limits);
    // Check the size that the header claims.
    let decoder = reader.into_decoder().map_err(undecodable)?;
    let (width, height) = decoder.dimensions();
    let claim = Claim {
        width: width.into(),
        height: height.into(),
        stored_bits: decoder.original_color_type().bits_per_pixel().into(),
        decoded_bytes: decoder.color_type().bytes_per_pixel().into(),
    };
    claim.check(strongest, file_length)?;
    Ok((decoder, format, jpeg))
}

pub(super) fn read(bytes: &[u8]) -> Result<Decoded> {
    // Decode.
    let (mut decoder, format, jpeg) = decoder(bytes)?;
    let (width, height) = decoder.dimensions();
    let profile = decoder.icc_profile().map_err(undecodable)?;
    let exif = decoder.exif_metadata().map_err(undecodable)?;
    let image = DynamicImage::from_decoder(decoder).map_err(undecodable)?;
    let stored = image.color().channel_count() as usize;
    let flat = image
        .as_flat_samples_u8()
        .ok_or_else(|| undecodable(format!("{:?} numbers", image.color())))?;
    let (channels, data, alpha) = split_alpha(stored, flat.samples, |v| f32::from(v) / 255.0);
    // Say what the file holds.
    let compression = match &jpeg {
        Some(header) => format!("JPEG, {}", header.process),
        None => format!("{format:?}"),
    };
    let names = channel_names(channels, alpha.is_some());
    let density = jpeg.and_then(|header| header.density);
    Ok(Decoded {
        width,
        height,
        channels,
        data,
        alpha: alpha.map(|alpha| (alpha, false)),
        precision: Precision::Bits8,
        statement: match &profile {
            Some(profile) => icc::statement(profile, channels),
            None => Statement::default(),
        },
        orientation: of_exif(exif.as_deref()),
        pixel_aspect: 1.0,
        layer_taken: false,
        notes: density
            .and_then(|[across, down]| Note::of_resolution(across.into(), down.into()))
            .into_iter()
            .collect(),
        facts: Facts {
            format: format!("{format:?}").to_uppercase(),
            pictures: 1,
            parts: vec![only_part(names, "8-bit integers", &compression)],
            ..Facts::default()
        },
    })
}

/// Refuses by name what the decoder would turn into colours by guess, or not at all.
fn check_jpeg(header: &JpegHeader) -> Result<()> {
    let refused = |found: String| {
        Err(Error::data("JPEG", found)
            .expected("8-bit grey, RGB or YCbCr, baseline or progressive")
            .advice("convert it to RGB, as PNG or TIFF: the inks' profile decides the colours"))
    };
    match header.components {
        4 => return refused(format!("{} inks", header.four_components())),
        0 | 1 | 3 => {}
        other => return refused(format!("{other} components")),
    }
    if !header.is_whole && !header.process.is_empty() {
        return Err(
            Error::data("JPEG", "truncated: the mark of the image's end is missing")
                .expected("a whole file")
                .advice("get the file again; if it is whole, save it again"),
        );
    }
    match (header.precision, header.process) {
        (0 | 8, "" | "baseline" | "extended" | "progressive") => Ok(()),
        (bits, process) => Err(Error::data("JPEG", format!("{process}, {bits} bits"))
            .expected("8-bit grey, RGB or YCbCr, baseline or progressive")
            .advice("save it again as PNG, TIFF or baseline JPEG")),
    }
}

#[cfg(test)]
mod tests {
    use image::codecs::jpeg::JpegEncoder;
    use image::{ExtendedColorType, ImageEncoder};

    use crate::format::image::{Encoding, ReadOptions, read_with};
    use crate::format::image::{Orientation, inspect};

    /// A JPEG of 16 × 8 pixels, dark on the left, with segments put behind its first two bytes.
    fn jpeg(segments: &[u8]) -> Vec<u8> {
        let pixels: Vec<u8> = (0..128)
            .map(|i| if i % 16 < 8 { 10 } else { 200 })
            .collect();
        let mut bytes = Vec::new();
        JpegEncoder::new_with_quality(&mut bytes, 95)
            .write_image(&pixels, 16, 8, ExtendedColorType::L8)
            .unwrap();
        bytes.splice(2..2, segments.iter().copied());
        bytes
    }

    #[test]
    fn orientation_and_profile_of_a_jpeg_are_followed() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.jpg");
        let exif = b"\xff\xe1\0\x22Exif\0\0MM\0\x2a\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01\0\x06\0\0\0\0\0\0";
        std::fs::write(&path, jpeg(exif)).unwrap();
        let upright = read_with(&path, &ReadOptions::default()).unwrap().image;
        assert_eq!((upright.width, upright.height), (8, 16));
        // Turned clockwise, the left side is up.
        assert!(upright.get(0, 4, 0) < 0.1 && upright.get(15, 4, 0) > 0.7);
        let stored = ReadOptions {
            orientation: Orientation::Stored,
            ..ReadOptions::default()
        };
        let read = read_with(&path, &stored).unwrap();
        assert_eq!(
            (read.image.width, read.notes[0].subject),
            (16, "orientation")
        );
        let profile = moxcms::ColorProfile::new_gray_with_gamma(1.0)
            .encode()
            .unwrap();
        let mut segment = b"\xff\xe2".to_vec();
        segment.extend((profile.len() as u16 + 16).to_be_bytes());
        segment.extend(b"ICC_PROFILE\0\x01\x01");
        segment.extend(profile);
        std::fs::write(&path, jpeg(&segment)).unwrap();
        let found = inspect(&path, &ReadOptions::default()).unwrap();
        assert!(
            found.facts.color.starts_with("ICC profile"),
            "{}",
            found.facts.color
        );
        assert_eq!(found.read.unwrap().image.encoding, Encoding::Linear);
    }

    #[test]
    fn a_file_that_is_cut_off_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.jpg");
        let whole = jpeg(b"");
        std::fs::write(&path, &whole[..whole.len() - 3]).unwrap();
        let error = read_with(&path, &ReadOptions::default()).unwrap_err();
        assert!(error.to_string().contains("truncated"), "{error}");
    }

    #[test]
    fn inks_are_refused_by_name() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.jpg");
        let frame =
            b"\xff\xd8\xff\xc0\0\x14\x08\0\x01\0\x01\x04\x01\x11\0\x02\x11\0\x03\x11\0\x04\x11\0";
        std::fs::write(&path, frame).unwrap();
        let error = read_with(&path, &ReadOptions::default())
            .unwrap_err()
            .to_string();
        assert!(error.contains("a.jpg") && error.contains("CMYK"), "{error}");
    }
}
