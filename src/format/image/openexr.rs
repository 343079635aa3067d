//! OpenEXR: the pixels of one layer, where the display window puts them.
//!
//! The picture is the display window. Data outside of it (overscan) is cut off; data missing inside of it
//! is an error, or black. Which channels are read is decided in `openexr_layers`.
//!
//! Not handled: deep data, and subsampled channels (luminance and chroma at half resolution), which the
//! `exr` crate does not read. Both are refused by name.

use std::io::Cursor;

use exr::block;
use exr::block::UncompressedBlock;
use exr::math::Vec2;
use exr::meta::MetaData;
use exr::meta::attribute::{AttributeValue, IntegerBounds, SampleType};
use exr::meta::header::Header;
use half::f16;

use crate::error::{Error, Result};
use crate::format::image::color::{Curve, Statement};
use crate::format::image::decoded::Decoded;
use crate::format::image::facts::Facts;
use crate::format::image::openexr_content::{ExrContent, Planes};
use crate::format::image::openexr_facts;
use crate::format::image::openexr_layers::{Kind, Layers};
use crate::format::image::options::{Missing, ReadOptions};
use crate::format::image::primaries::Chromaticities;
use crate::format::image::{Claim, Note, Precision, undecodable};

/// Bytes that one byte of a file can stand for. PIZ does better on pictures of one colour; those are
/// refused beyond the size that is always read.
const STRONGEST_COMPRESSION: u64 = 4096;

/// The headers of a file, their sizes checked against its length.
fn headers(file: &[u8]) -> Result<MetaData> {
    let meta = MetaData::read_from_buffered(Cursor::new(file), false).map_err(undecodable)?;
    for header in meta.headers.iter().filter(|header| !header.deep) {
        claim(header, header.layer_size).check(STRONGEST_COMPRESSION, file.len() as u64)?;
    }
    Ok(meta)
}

fn claim(header: &Header, size: Vec2<usize>) -> Claim {
    let bytes = header.channels.bytes_per_pixel as u64;
    Claim {
        width: size.0 as u64,
        height: size.1 as u64,
        stored_bits: bytes * 8,
        // Four floats at most are made of a pixel.
        decoded_bytes: bytes.max(16),
    }
}

/// Refuses a part with channels of less than full resolution: the crate would misread all of it.
fn check_sampling(header: &Header) -> Result<()> {
    let channels = &header.channels.list;
    match channels.iter().find(|c| c.sampling != Vec2(1, 1)) {
        None => Ok(()),
        Some(channel) => Err(Error::data(
            format!("channel {}", channel.name),
            format!(
                "subsampled, one sample for {} × {} pixels (luminance and chroma)",
                channel.sampling.0, channel.sampling.1
            ),
        )
        .expected("channels of full resolution")
        .advice(
            "save it with channels R, G and B, from the program that made it or from a viewer",
        )),
    }
}

/// What the headers say.
pub(super) fn facts(file: &[u8]) -> Result<Facts> {
    let meta = headers(file)?;
    Ok(openexr_facts::of(&meta, &Layers::of(&meta)))
}

pub(super) fn read(file: &[u8], options: &ReadOptions) -> Result<Decoded> {
    // Choose the layer and its channels.
    let meta = headers(file)?;
    let layers = Layers::of(&meta);
    let chosen = layers.choose(options)?;
    let header = &meta.headers[chosen.part];
    check_sampling(header)?;
    // Check windows and sizes before anything is allocated.
    let windows = ImageWindows::of(header);
    let mut notes = Vec::new();
    windows.check(header, options.missing, file.len() as u64, &mut notes)?;
    // Read the planes.
    let wanted: Vec<usize> = chosen
        .channels
        .iter()
        .chain(&chosen.alpha)
        .copied()
        .collect();
    let mut planes = planes(file, chosen.part, &wanted, &windows)?;
    let statement = statement(header);
    let alpha = planes.split_off(chosen.channels.len()).pop();
    // Make interleaved pixels of them.
    let mut color = planes;
    if chosen.kind == Kind::Pair {
        color.push(vec![0.0; windows.texels()]);
    }
    let mut data = interleave(&color, windows.texels());
    if chosen.kind == Kind::LuminanceChroma {
        to_rgb(&mut data, header);
    }
    Ok(Decoded {
        width: windows.display.size.0 as u32,
        height: windows.display.size.1 as u32,
        channels: color.len() as u32,
        data,
        alpha: alpha.map(|alpha| (alpha, true)),
        precision: Precision::Float,
        statement,
        orientation: 1,
        pixel_aspect: f64::from(header.shared_attributes.pixel_aspect),
        layer_taken: chosen.was_named,
        notes,
        facts: openexr_facts::of(&meta, &layers),
    })
}

/// The windows of an image: where data lie, and what is shown of them.
struct ImageWindows {
    data: IntegerBounds,
    display: IntegerBounds,
}

impl ImageWindows {
    fn of(header: &Header) -> Self {
        Self {
            data: header.data_window(),
            display: header.shared_attributes.display_window,
        }
    }

    fn texels(&self) -> usize {
        self.display.size.0 * self.display.size.1
    }

    /// Texels of the display window that the data window does not cover.
    fn missing(&self) -> u64 {
        let overlap = |axis: fn(&IntegerBounds) -> [i64; 2]| {
            let ([a, b], [c, d]) = (axis(&self.data), axis(&self.display));
            (b.min(d) - a.max(c)).max(0) as u64
        };
        let across = overlap(|w| span(w.position.0, w.size.0));
        let down = overlap(|w| span(w.position.1, w.size.1));
        (self.texels() as u64).saturating_sub(across * down)
    }

    fn check(
        &self,
        header: &Header,
        missing: Missing,
        file_length: u64,
        notes: &mut Vec<Note>,
    ) -> Result<()> {
        let without_value = self.missing();
        let text = format!(
            "{without_value} of {} texels of the display window {} have no value: the data window is {}",
            self.texels(),
            corners(&self.display),
            corners(&self.data)
        );
        if without_value > 0 && missing == Missing::Refuse {
            return Err(Error::data("windows", text)
                .expected("data for the whole display window")
                .advice(
                    "save whole frames; or, where every image has the same data window and only that is \
                     wanted, make it the display window (oiiotool IN.exr --fullpixels -o OUT.exr)",
                ));
        }
        if without_value > 0 {
            notes.push(Note::new("windows", format!("{text}; read as black")));
        }
        claim(header, self.display.size)
            .check(STRONGEST_COMPRESSION, file_length)
            .map(|_| ())
    }
}

fn span(start: i32, length: usize) -> [i64; 2] {
    [i64::from(start), i64::from(start) + length as i64]
}

/// First column and row to last column and row.
fn corners(window: &IntegerBounds) -> String {
    let ([left, right], [top, bottom]) = (
        span(window.position.0, window.size.0),
        span(window.position.1, window.size.1),
    );
    format!("({left}, {top}) to ({}, {})", right - 1, bottom - 1)
}

/// What the header of the first part says.
pub(super) fn content(file: &[u8]) -> Result<ExrContent> {
    let meta = headers(file)?;
    let header = &meta.headers[0];
    let channels = header.channels.list.iter();
    Ok(ExrContent {
        channels: channels.map(|channel| channel.name.to_string()).collect(),
        states_color: !statement(header).text.is_empty(),
    })
}

/// The channels of the first part that `is_wanted` accepts.
pub(super) fn read_planes(file: &[u8], is_wanted: impl Fn(&str) -> bool) -> Result<Planes> {
    let meta = headers(file)?;
    let header = &meta.headers[0];
    if header.deep {
        return Err(Error::data("OpenEXR", "deep data").expected("a flat image"));
    }
    check_sampling(header)?;
    let windows = ImageWindows::of(header);
    windows.check(header, Missing::Refuse, file.len() as u64, &mut Vec::new())?;
    let name = |channel: usize| header.channels.list[channel].name.to_string();
    let wanted: Vec<usize> = (0..header.channels.list.len())
        .filter(|&channel| is_wanted(&name(channel)))
        .collect();
    let planes = planes(file, 0, &wanted, &windows)?;
    Ok(Planes {
        width: windows.display.size.0 as u32,
        height: windows.display.size.1 as u32,
        channels: wanted.into_iter().map(name).zip(planes).collect(),
    })
}

/// Some channels of a part over the display window.
fn planes(
    file: &[u8],
    part: usize,
    wanted: &[usize],
    windows: &ImageWindows,
) -> Result<Vec<Vec<f32>>> {
    let mut planes = vec![vec![0.0; windows.texels()]; wanted.len()];
    let reader = block::read(Cursor::new(file), false).map_err(undecodable)?;
    let meta = reader.meta_data().clone();
    let chunks = reader
        .filter_chunks(false, |_, tile, block| {
            block.layer == part && tile.is_largest_resolution_level()
        })
        .map_err(undecodable)?;
    let header = &meta.headers[part];
    for chunk in chunks {
        let block = UncompressedBlock::decompress_chunk(chunk.map_err(undecodable)?, &meta, false)
            .map_err(undecodable)?;
        for line in block.lines(&header.channels) {
            let channel = line.location.channel;
            let places = wanted.iter().enumerate().filter(|(_, w)| **w == channel);
            for (plane, _) in places {
                let place = (line.location.position.0, line.location.position.1);
                let kind = header.channels.list[channel].sample_type;
                copy_line(&mut planes[plane], windows, place, kind, line.value);
            }
        }
    }
    Ok(planes)
}

/// Puts what of a line of samples lies inside the display window where it belongs.
fn copy_line(
    plane: &mut [f32],
    windows: &ImageWindows,
    (column, row): (usize, usize),
    kind: SampleType,
    bytes: &[u8],
) {
    let row =
        row as i64 + i64::from(windows.data.position.1) - i64::from(windows.display.position.1);
    let width = windows.display.size.0 as i64;
    if !(0..windows.display.size.1 as i64).contains(&row) {
        return;
    }
    let first =
        column as i64 + i64::from(windows.data.position.0) - i64::from(windows.display.position.0);
    let mut put = |index: usize, value: f32| {
        let column = first + index as i64;
        if (0..width).contains(&column) {
            plane[(row * width + column) as usize] = value;
        }
    };
    let halves = bytes.chunks_exact(2).map(|b| [b[0], b[1]]).enumerate();
    let words = bytes
        .chunks_exact(4)
        .map(|b| [b[0], b[1], b[2], b[3]])
        .enumerate();
    match kind {
        SampleType::F16 => halves.for_each(|(i, b)| put(i, f16::from_ne_bytes(b).to_f32())),
        SampleType::F32 => words.for_each(|(i, b)| put(i, f32::from_ne_bytes(b))),
        SampleType::U32 => words.for_each(|(i, b)| put(i, u32::from_ne_bytes(b) as f32)),
    }
}

fn interleave(planes: &[Vec<f32>], texels: usize) -> Vec<f32> {
    let mut numbers = Vec::with_capacity(texels * planes.len());
    numbers.extend((0..texels).flat_map(|texel| planes.iter().map(move |plane| plane[texel])));
    numbers
}

fn chromaticities(header: &Header) -> Option<Chromaticities> {
    let found = header.shared_attributes.chromaticities?;
    let pair = |v: Vec2<f32>| [f64::from(v.0), f64::from(v.1)];
    Some(Chromaticities {
        red: pair(found.red),
        green: pair(found.green),
        blue: pair(found.blue),
        white: pair(found.white),
    })
}

/// What the header says of colours: chromaticities, else the name of an interop colour space.
fn statement(header: &Header) -> Statement {
    if let Some(found) = chromaticities(header) {
        let text = format!("chromaticities {found}");
        return match found.is(&Chromaticities::XYZ) {
            true => Statement::tristimulus(text),
            false => Statement::of(Some(Curve::Linear), Some(found), text),
        };
    }
    let others = [
        &header.shared_attributes.other,
        &header.own_attributes.other,
    ];
    let mut attributes = others.into_iter().flatten();
    let id = attributes.find_map(|(name, value)| match value {
        AttributeValue::Text(text) if *name == *"colorInteropID" => Some(text.to_string()),
        _ => None,
    });
    id.map_or_else(Statement::default, |id| of_interop_id(&id))
}

/// The colour spaces that the Academy Software Foundation names.
fn of_interop_id(id: &str) -> Statement {
    let text = format!("colorInteropID {id}");
    let linear = |primaries| Statement::of(Some(Curve::Linear), Some(primaries), text.clone());
    match id {
        "lin_rec709_scene" | "lin_rec709_display" | "lin_rec709" => linear(Chromaticities::REC709),
        "lin_p3d65_scene" | "lin_p3d65" => linear(Chromaticities::P3_D65),
        "lin_rec2020_scene" | "lin_rec2020" => linear(Chromaticities::REC2020),
        "lin_adobergb_scene" | "lin_adobergb" => linear(Chromaticities::ADOBE),
        "lin_ap0_scene" | "lin_ap0" => linear(Chromaticities::AP0),
        "lin_ap1_scene" | "lin_ap1" => linear(Chromaticities::AP1),
        "lin_ciexyzd65_scene" | "lin_ciexyzd65" => Statement::tristimulus(text),
        "srgb_rec709_scene" | "srgb_rec709_display" | "srgb_rec709" => Statement::srgb(text),
        "data" | "unknown" | "raw" => Statement::default(),
        _ => Statement::unusable(text, format!("its colour space `{id}` is not known")),
    }
}

/// Luminance and chroma (Y, RY, BY) to RGB of the file's primaries.
fn to_rgb(data: &mut [f32], header: &Header) {
    let primaries = chromaticities(header).unwrap_or(Chromaticities::REC709);
    let matrix = primaries.to_xyz().or(Chromaticities::REC709.to_xyz());
    let weights = matrix.map_or([0.2126, 0.7152, 0.0722], |m| {
        let sum = m.col(0).y + m.col(1).y + m.col(2).y;
        [m.col(0).y / sum, m.col(1).y / sum, m.col(2).y / sum]
    });
    for texel in data.chunks_exact_mut(3) {
        let [luminance, ry, by] = [texel[0], texel[1], texel[2]].map(f64::from);
        let (red, blue) = ((ry + 1.0) * luminance, (by + 1.0) * luminance);
        let green = (luminance - red * weights[0] - blue * weights[2]) / weights[1];
        texel.copy_from_slice(&[red as f32, green as f32, blue as f32]);
    }
}

#[cfg(test)]
mod tests;
