//! Radiance HDR: header, all eight orders of rows and columns, flat pixels, old and new run lengths.
//!
//! A number is mantissa × 2^(exponent − 136), as in most readers (Radiance itself adds half a step).
//! `EXPOSURE` and `COLORCORR` are divided out; RGB is linear Rec. 709 unless `PRIMARIES` says otherwise;
//! XYZE is converted with the white of equal energy, Radiance's own, kept white.

use crate::error::{Error, Result};
use crate::format::image::color::{Curve, Statement};
use crate::format::image::decoded::{Decoded, only_part};
use crate::format::image::facts::Facts;
use crate::format::image::primaries::Chromaticities;
use crate::format::image::{Claim, Precision};

/// Bytes that one byte of a file can stand for: old run lengths hold a line in a few bytes.
const STRONGEST_COMPRESSION: u64 = 4096;
/// The longest header, in bytes.
const LONGEST_HEADER: usize = 64 << 10;

pub(super) fn read(bytes: &[u8]) -> Result<Decoded> {
    let mut lines = Lines { bytes, at: 0 };
    let header = Header::read(&mut lines)?;
    let raster = Raster::parse(&lines.next("resolution line")?)?;
    let claim = Claim {
        width: raster.width() as u64,
        height: raster.height() as u64,
        stored_bits: 32,
        decoded_bytes: 12,
    };
    claim.check(STRONGEST_COMPRESSION, bytes.len() as u64)?;
    let data = pixels(&bytes[lines.at..], &raster, header.scale)?;
    let kind = if header.is_xyz { "XYZE" } else { "RGBE" };
    let mut part = only_part(&["R", "G", "B"], kind, "run lengths");
    part.attributes = header.attributes;
    Ok(Decoded {
        width: raster.width() as u32,
        height: raster.height() as u32,
        channels: 3,
        data,
        alpha: None,
        precision: Precision::Float,
        statement: header.statement,
        orientation: 1,
        pixel_aspect: header.pixel_aspect,
        layer_taken: false,
        notes: Vec::new(),
        facts: Facts {
            format: "Radiance HDR".into(),
            pictures: 1,
            parts: vec![part],
            ..Facts::default()
        },
    })
}

struct Lines<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl Lines<'_> {
    fn next(&mut self, place: &str) -> Result<String> {
        let rest = &self.bytes[self.at..];
        let end = rest
            .iter()
            .position(|&b| b == b'\n')
            .ok_or_else(|| Error::data(place, "the end of the file").expected("a line of text"))?;
        self.at += end + 1;
        if self.at > LONGEST_HEADER {
            return Err(Error::data(
                place,
                format!("a header of more than {LONGEST_HEADER} bytes"),
            )
            .expected("an empty line before"));
        }
        Ok(String::from_utf8_lossy(&rest[..end])
            .trim_end_matches('\r')
            .to_owned())
    }
}

struct Header {
    is_xyz: bool,
    /// What each stored number is multiplied by.
    scale: [f64; 3],
    pixel_aspect: f64,
    statement: Statement,
    attributes: Vec<(String, String)>,
}

impl Header {
    fn read(lines: &mut Lines<'_>) -> Result<Self> {
        let mut header = Self {
            is_xyz: false,
            scale: [1.0; 3],
            pixel_aspect: 1.0,
            statement: Statement::default(),
            attributes: Vec::new(),
        };
        let (mut primaries, mut gamma) = (None, 1.0);
        let signature = lines.next("signature")?;
        header.attributes.push(("signature".into(), signature));
        // Read the lines up to an empty one.
        loop {
            let line = lines.next("header")?;
            if line.is_empty() {
                break;
            }
            let Some((name, value)) = line.split_once('=').map(|(n, v)| (n.trim(), v.trim()))
            else {
                continue;
            };
            header.attributes.push((name.into(), value.into()));
            match name {
                "FORMAT" => header.is_xyz = is_xyz(value)?,
                "EXPOSURE" => header.divide([positive(name, value)?; 3]),
                "COLORCORR" => header.divide(positives(name, value)?),
                "PIXASPECT" => header.pixel_aspect /= positive(name, value)?,
                "GAMMA" => gamma = positive(name, value)?,
                "PRIMARIES" => primaries = Some((value.to_owned(), chromaticities(value)?)),
                _ => {}
            }
        }
        // Say what the colours mean.
        let curve = if gamma == 1.0 {
            Curve::Linear
        } else {
            Curve::Power(gamma)
        };
        header.statement = match (header.is_xyz, primaries) {
            (true, _) => Statement::of(Some(curve), Some(Chromaticities::XYZ), "FORMAT xyze"),
            (false, Some((text, found))) => {
                Statement::of(Some(curve), Some(found), format!("PRIMARIES {text}"))
            }
            (false, None) if gamma == 1.0 => Statement::default(),
            (false, None) => Statement::of(Some(curve), None, format!("GAMMA {gamma}")),
        };
        Ok(header)
    }

    fn divide(&mut self, by: [f64; 3]) {
        for (scale, by) in self.scale.iter_mut().zip(by) {
            *scale /= by;
        }
    }
}

fn is_xyz(format: &str) -> Result<bool> {
    match format {
        "32-bit_rle_rgbe" => Ok(false),
        "32-bit_rle_xyze" => Ok(true),
        other => Err(Error::data("FORMAT", other).expected("32-bit_rle_rgbe or 32-bit_rle_xyze")),
    }
}

fn positive(name: &str, text: &str) -> Result<f64> {
    let number = text.parse::<f64>().ok().filter(|v| *v > 1e-30 && *v < 1e30);
    number.ok_or_else(|| Error::data(name, text).expected("a number above 0"))
}

fn positives(name: &str, text: &str) -> Result<[f64; 3]> {
    let numbers: Vec<f64> = text
        .split_whitespace()
        .map(|word| positive(name, word))
        .collect::<Result<_>>()?;
    <[f64; 3]>::try_from(numbers).map_err(|_| Error::data(name, text).expected("3 numbers above 0"))
}

fn chromaticities(text: &str) -> Result<Chromaticities> {
    let numbers: Vec<f64> = text
        .split_whitespace()
        .filter_map(|word| word.parse().ok())
        .collect();
    let Ok([rx, ry, gx, gy, bx, by, wx, wy]) = <[f64; 8]>::try_from(numbers) else {
        return Err(Error::data("PRIMARIES", text)
            .expected("8 numbers: x and y of red, green, blue, white"));
    };
    Ok(Chromaticities {
        red: [rx, ry],
        green: [gx, gy],
        blue: [bx, by],
        white: [wx, wy],
    })
}

/// The order of pixels: lines along one axis, one after the other along the other.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Raster {
    /// Lines, and pixels of one.
    lines: usize,
    length: usize,
    /// Whether lines are columns.
    columns: bool,
    /// Whether the first line, and the first pixel of one, are at the bottom or the right.
    lines_from_end: bool,
    pixels_from_end: bool,
}

impl Raster {
    fn parse(line: &str) -> Result<Self> {
        let fault = || {
            Error::data("resolution line", format!("`{}`", line.escape_debug()))
                .expected("two of ±Y rows and ±X columns, as -Y 480 +X 640")
        };
        let words: Vec<&str> = line.split_whitespace().collect();
        let [first, lines, second, length] = words[..] else {
            return Err(fault());
        };
        let side = |word: &str| word.parse::<u32>().map_err(|_| fault());
        let from_end = |axis: &str| match axis {
            "-Y" | "+X" => Ok(false),
            "+Y" | "-X" => Ok(true),
            _ => Err(fault()),
        };
        let raster = Self {
            lines: side(lines)? as usize,
            length: side(length)? as usize,
            columns: first.ends_with('X'),
            lines_from_end: from_end(first)?,
            pixels_from_end: from_end(second)?,
        };
        match raster.columns == second.ends_with('Y') {
            true => Ok(raster),
            false => Err(fault()),
        }
    }

    fn width(&self) -> usize {
        if self.columns {
            self.lines
        } else {
            self.length
        }
    }

    fn height(&self) -> usize {
        if self.columns {
            self.length
        } else {
            self.lines
        }
    }

    /// The texel, row by row from the top, of a pixel of a line.
    fn texel(&self, line: usize, pixel: usize) -> usize {
        let turned = |index: usize, count: usize, from_end: bool| match from_end {
            true => count - 1 - index,
            false => index,
        };
        let line = turned(line, self.lines, self.lines_from_end);
        let pixel = turned(pixel, self.length, self.pixels_from_end);
        match self.columns {
            true => pixel * self.lines + line,
            false => line * self.length + pixel,
        }
    }
}

fn pixels(bytes: &[u8], raster: &Raster, scale: [f64; 3]) -> Result<Vec<f32>> {
    let mut data = vec![0.0; raster.lines * raster.length * 3];
    let mut line = vec![[0_u8; 4]; raster.length];
    let mut source = Source { bytes };
    for index in 0..raster.lines {
        source
            .line(&mut line)
            .map_err(|found| Error::data(format!("line {index}"), found).expected("pixels"))?;
        for (pixel, stored) in line.iter().enumerate() {
            let power = 2.0_f64.powi(i32::from(stored[3]) - 136);
            let texel = raster.texel(index, pixel) * 3;
            for channel in 0..3 {
                let light = f64::from(stored[channel]) * power * scale[channel];
                data[texel + channel] = if stored[3] == 0 { 0.0 } else { light as f32 };
            }
        }
    }
    Ok(data)
}

struct Source<'a> {
    bytes: &'a [u8],
}

impl Source<'_> {
    fn take<const N: usize>(&mut self) -> std::result::Result<[u8; N], String> {
        let (first, rest) = self
            .bytes
            .split_first_chunk::<N>()
            .ok_or("the end of the file")?;
        self.bytes = rest;
        Ok(*first)
    }

    fn line(&mut self, line: &mut [[u8; 4]]) -> std::result::Result<(), String> {
        let length = line.len();
        if let ([2, 2, high, low, ..], 8..=0x7fff) = (self.bytes, length)
            && *high < 128
        {
            let stated = usize::from(*high) << 8 | usize::from(*low);
            if stated != length {
                return Err(format!("a line of {stated} pixels in place of {length}"));
            }
            self.take::<4>()?;
            return (0..4).try_for_each(|component| self.component(line, component));
        }
        self.old_line(line)
    }

    /// One component of a line in new run lengths.
    fn component(
        &mut self,
        line: &mut [[u8; 4]],
        component: usize,
    ) -> std::result::Result<(), String> {
        let mut at = 0;
        while at < line.len() {
            let [code] = self.take()?;
            let is_run = code > 128;
            let count = usize::from(if is_run { code - 128 } else { code });
            if count == 0 || at + count > line.len() {
                return Err(format!("a run of {count} at pixel {at}"));
            }
            let repeated = if is_run {
                Some(self.take::<1>()?[0])
            } else {
                None
            };
            for pixel in &mut line[at..at + count] {
                pixel[component] = match repeated {
                    Some(value) => value,
                    None => self.take::<1>()?[0],
                };
            }
            at += count;
        }
        Ok(())
    }

    /// A line of flat pixels, among which (1, 1, 1, n) repeats the last one n times; several in a row
    /// are the bytes of one count, the lowest first.
    fn old_line(&mut self, line: &mut [[u8; 4]]) -> std::result::Result<(), String> {
        let (mut at, mut shift) = (0, 0);
        while at < line.len() {
            let pixel = self.take::<4>()?;
            let [1, 1, 1, count] = pixel else {
                line[at] = pixel;
                (at, shift) = (at + 1, 0);
                continue;
            };
            let count = usize::from(count) << shift;
            if at == 0 || at + count > line.len() || shift > 16 {
                return Err(format!("a run of {count} at pixel {at}"));
            }
            let last = line[at - 1];
            line[at..at + count].fill(last);
            (at, shift) = (at + count, shift + 8);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
