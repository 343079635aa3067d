//! PNG, through the `png` crate: every colour type and depth, and what its chunks say of colour.
//!
//! Of several statements the first of these holds: cICP, iCCP, sRGB, gAMA and cHRM (PNG, third edition,
//! 4.3). Palettes, depths below 8 and tRNS are expanded; 16 bits stay 16.

use std::io::Cursor;

use png::{BitDepth, CodingIndependentCodePoints, Decoder, Info, Limits, Transformations};

use crate::error::Result;
use crate::format::image::color::{Curve, Statement};
use crate::format::image::decoded::{Decoded, channel_names, only_part, split_alpha};
use crate::format::image::facts::Facts;
use crate::format::image::orientation::of_exif;
use crate::format::image::primaries::Chromaticities;
use crate::format::image::{Claim, HARMLESS, Note, Precision, WORKING, icc, undecodable};

/// Bytes that one byte of a file can stand for: deflate holds runs of 258 bytes in 2 bits.
const STRONGEST_COMPRESSION: u64 = 1032;

pub(super) fn read(file: &[u8]) -> Result<Decoded> {
    let file_length = file.len() as u64;
    // Bound what the decoder may allocate.
    let most = file_length
        .saturating_mul(STRONGEST_COMPRESSION)
        .max(HARMLESS)
        .saturating_add(WORKING);
    let bytes = usize::try_from(most).unwrap_or(usize::MAX);
    let mut decoder = Decoder::new_with_limits(Cursor::new(file), Limits { bytes });
    decoder.set_transformations(Transformations::EXPAND);
    let mut reader = decoder.read_info().map_err(undecodable)?;
    let (color, depth) = reader.output_color_type();
    let stored = color.samples();
    let info = reader.info();
    // Check the size that the header claims.
    let claim = Claim {
        width: info.width.into(),
        height: info.height.into(),
        stored_bits: info.bits_per_pixel() as u64,
        decoded_bytes: stored as u64 * if depth == BitDepth::Sixteen { 2 } else { 1 },
    };
    claim.check(STRONGEST_COMPRESSION, file_length)?;
    // Decode.
    let mut decoded = described(info, stored, depth);
    let length = reader
        .output_buffer_size()
        .ok_or_else(|| undecodable("a size beyond this machine"))?;
    let mut buffer = vec![0; length];
    reader.next_frame(&mut buffer).map_err(undecodable)?;
    let (channels, data, alpha) = match depth {
        BitDepth::Sixteen => {
            let numbers: Vec<u16> = buffer
                .chunks_exact(2)
                .map(|pair| u16::from_be_bytes([pair[0], pair[1]]))
                .collect();
            split_alpha(stored, &numbers, |v| f32::from(v) / 65535.0)
        }
        _ => split_alpha(stored, &buffer, |v| f32::from(v) / 255.0),
    };
    (decoded.channels, decoded.data) = (channels, data);
    decoded.alpha = alpha.map(|alpha| (alpha, false));
    Ok(decoded)
}

/// What the header and its chunks say, the pixels still missing.
fn described(info: &Info<'_>, stored: usize, depth: BitDepth) -> Decoded {
    // Name the channels and how they are stored.
    let channels = if stored < 3 { 1 } else { 3 };
    let pictures = info
        .animation_control
        .map_or(1, |control| control.num_frames);
    let interlaced = if info.interlaced { ", interlaced" } else { "" };
    let numbers = format!("{}-bit integers", info.bit_depth as u8);
    let compression = format!("deflate, {:?}{interlaced}", info.color_type);
    let names = channel_names(channels, stored == 2 || stored == 4);
    let mut part = only_part(names, &numbers, &compression);
    let texts = info.uncompressed_latin1_text.iter();
    part.attributes = texts.map(|t| (t.keyword.clone(), t.text.clone())).collect();
    // Note what is not read.
    let mut notes = Vec::new();
    if pictures > 1 {
        let text = format!("the first of its {pictures} images is read");
        notes.push(Note::new("pictures", text));
    }
    if let Some(dims) = &info.pixel_dims {
        notes.extend(Note::of_resolution(dims.xppu.into(), dims.yppu.into()));
    }
    Decoded {
        width: info.width,
        height: info.height,
        channels,
        data: Vec::new(),
        alpha: None,
        precision: match depth {
            BitDepth::Sixteen => Precision::Bits16,
            _ => Precision::Bits8,
        },
        statement: statement(info, channels),
        orientation: of_exif(info.exif_metadata.as_deref()),
        pixel_aspect: 1.0,
        layer_taken: false,
        notes,
        facts: Facts {
            format: "PNG".into(),
            pictures: pictures.into(),
            parts: vec![part],
            ..Facts::default()
        },
    }
}

fn statement(info: &Info<'_>, channels: u32) -> Statement {
    // The most exact statement is taken.
    if let Some(points) = &info.coding_independent_code_points {
        return of_code_points(points);
    }
    if let Some(profile) = &info.icc_profile {
        return icc::statement(profile, channels);
    }
    if info.srgb.is_some() {
        return Statement::srgb("sRGB chunk");
    }
    // Without one, gamma and primaries are.
    let gamma = info
        .gama_chunk
        .map(|gamma| f64::from(gamma.into_scaled()) / 1e5);
    let primaries = info.chrm_chunk.map(|chunk| {
        let pair = |(x, y): (png::ScaledFloat, png::ScaledFloat)| {
            [x, y].map(|v| f64::from(v.into_scaled()) / 1e5)
        };
        Chromaticities {
            red: pair(chunk.red),
            green: pair(chunk.green),
            blue: pair(chunk.blue),
            white: pair(chunk.white),
        }
    });
    let text = match (gamma, primaries) {
        (None, None) => String::new(),
        (Some(gamma), None) => format!("gAMA {gamma}"),
        (None, Some(primaries)) => format!("cHRM {primaries}"),
        (Some(gamma), Some(primaries)) => format!("gAMA {gamma}, cHRM {primaries}"),
    };
    let curve = match gamma {
        Some(gamma) if !(0.01..=10.0).contains(&gamma) => {
            return Statement::unusable(text, format!("its gamma is {gamma}"));
        }
        Some(gamma) if (gamma - 1.0).abs() < 1e-4 => Some(Curve::Linear),
        Some(gamma) => Some(Curve::Power(1.0 / gamma)),
        None => None,
    };
    Statement::of(curve, primaries, text)
}

/// Code points of ITU-T H.273.
fn of_code_points(points: &CodingIndependentCodePoints) -> Statement {
    let text = format!(
        "cICP primaries {}, transfer {}, matrix {}",
        points.color_primaries, points.transfer_function, points.matrix_coefficients
    );
    let refused = |why: &str| Statement::unusable(text.clone(), why);
    if points.matrix_coefficients != 0 || !points.is_video_full_range_image {
        return refused("its cICP chunk is not full-range RGB");
    }
    let curve = match points.transfer_function {
        1 | 6 | 14 | 15 => Curve::Rec709,
        4 => Curve::Power(2.2),
        5 => Curve::Power(2.8),
        8 => Curve::Linear,
        13 => Curve::Srgb,
        16 => return refused("its transfer is PQ: absolute display light, not a reflectance"),
        18 => return refused("its transfer is HLG: display light, not a reflectance"),
        _ => return refused("its cICP transfer is not one that is read (1, 4, 5, 6, 8, 13 to 15)"),
    };
    let primaries = match points.color_primaries {
        1 => Chromaticities::REC709,
        5 => Chromaticities::PAL,
        6 | 7 => Chromaticities::NTSC,
        9 => Chromaticities::REC2020,
        11 => Chromaticities::P3_DCI,
        12 => Chromaticities::P3_D65,
        _ => {
            return refused(
                "its cICP primaries are not those that are read (1, 5 to 7, 9, 11, 12)",
            );
        }
    };
    Statement::of(Some(curve), Some(primaries), text)
}

#[cfg(test)]
mod tests;
