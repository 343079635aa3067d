//! Hemispherical harmonics, `.rti`.
//!
//! A header in text: comment lines that begin with `#`, the type (3 stands for HSH), a line `width height colours`, a
//! line `terms basis bytes`; then two lists of `terms` floats (little endian) and one byte per coefficient, rows from
//! the top, per texel red's terms, green's, blue's. The lists are a scale and an offset, coefficient = byte/255 ·
//! first + second, as fitters of `#HSH1.2` write them; or minima and maxima, coefficient = byte/255 · (second −
//! first) + first. Scales are not negative and maxima are not below minima: that tells the two apart in nearly all
//! files. Sums are those of displays, 1 white.

use std::io::{self, Write};
use std::path::Path;

use crate::btf::fits::basis::Basis;
use crate::btf::fits::fit::{Colors, Fit};
use crate::btf::fits::header::{Header, take};
use crate::error::{Error, Result};
use crate::format::atomic;
use crate::format::guard::guarded;

/// The comment line of files whose lists are scales and offsets.
const SCALED: &str = "#HSH1.2";
/// The type that stands for hemispherical harmonics.
const HSH: u32 = 3;
/// The basis of red, green and blue with terms of their own.
const SEPARATE_COLORS: u32 = 2;

/// What the two lists of floats are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lists {
    /// Scale and offset.
    ScaleOffset,
    /// Minimum and maximum.
    MinimumMaximum,
}

/// Reads an HSH `.rti` file.
pub fn read(path: &Path) -> Result<Fit> {
    let bytes = std::fs::read(path).map_err(Error::io(path, "read"))?;
    guarded(path, || parse(&bytes))
}

/// The fit in the bytes of a file.
fn parse(bytes: &[u8]) -> Result<Fit> {
    // Read the mark of this program, if there is one.
    let mut header = Header::new(bytes);
    let mut is_marked = false;
    while header.is_at_comment() {
        is_marked |= header.line("comment")? == SCALED;
    }
    // Check the header.
    expect(
        header.number("type", "a number")?,
        HSH,
        "type",
        "3: hemispherical harmonics",
    )?;
    let (width, height) = header.sides()?;
    expect(header.number("colours", "3")?, 3, "colours", "3")?;
    let terms: usize = header.number("terms", "4, 9 or 16")?;
    if ![4, 9, 16].contains(&terms) {
        return Err(Error::data("terms", terms.to_string()).expected("4, 9 or 16"));
    }
    let basis = header.number("basis", "2")?;
    expect(
        basis,
        SEPARATE_COLORS,
        "basis",
        "2: red, green and blue apart",
    )?;
    expect(
        header.number("bytes", "1")?,
        1,
        "bytes per coefficient",
        "1",
    )?;
    // Read scale and offset, which other writers store as minimum and maximum.
    let mut body = header.end()?;
    let first = floats(take(&mut body, 4 * terms as u64, "first list")?);
    let second = floats(take(&mut body, 4 * terms as u64, "second list")?);
    let (scale, offset) = match lists_of(&first, &second, is_marked)? {
        Lists::ScaleOffset => (first, second),
        Lists::MinimumMaximum => (
            first
                .iter()
                .zip(&second)
                .map(|(low, high)| high - low)
                .collect(),
            first,
        ),
    };
    // Read the coefficients.
    let texels = u64::from(width) * u64::from(height);
    Ok(Fit {
        width,
        height,
        basis: Basis::Hemispherical(terms),
        colors: Colors::Rgb,
        scale: scale.iter().map(|scale| scale / 255.0).collect(),
        offset,
        coefficients: take(&mut body, 3 * terms as u64 * texels, "coefficients")?.to_vec(),
        texel_colors: Vec::new(),
        white: 1.0,
    })
}

fn expect(found: u32, wanted: u32, what: &str, expected: &str) -> Result<()> {
    match found == wanted {
        true => Ok(()),
        false => Err(Error::data(what, found.to_string()).expected(expected)),
    }
}

fn floats(bytes: &[u8]) -> Vec<f32> {
    bytes
        .as_chunks()
        .0
        .iter()
        .map(|&four| f32::from_le_bytes(four))
        .collect()
}

/// What the lists are, by their numbers; where both would do, by the mark in the comments.
fn lists_of(first: &[f32], second: &[f32], is_marked: bool) -> Result<Lists> {
    for (list, numbers) in [("first list", first), ("second list", second)] {
        if let Some(term) = numbers.iter().position(|number| !number.is_finite()) {
            let place = format!("{list}, term {term}");
            return Err(Error::data(place, numbers[term].to_string()).expected("a finite number"));
        }
    }
    let may_scale = first.iter().all(|&scale| scale >= 0.0);
    let may_bound = first.iter().zip(second).all(|(low, high)| low <= high);
    match (may_scale, may_bound) {
        (true, true) if is_marked => Ok(Lists::ScaleOffset),
        (true, false) => Ok(Lists::ScaleOffset),
        (_, true) => Ok(Lists::MinimumMaximum),
        (false, false) => Err(
            Error::data("lists", "negative scales, and minima above maxima")
                .expected("scales and offsets, or minima and maxima, per term")
                .advice("the file is damaged, or its header states another number of terms"),
        ),
    }
}

/// Writes a fit of hemispherical harmonics, with lists of the chosen kind.
pub fn write(path: &Path, fit: &Fit, lists: Lists) -> Result<()> {
    atomic::write_file(path, |sink| encode(sink, fit, lists))
}

fn encode(sink: &mut impl Write, fit: &Fit, lists: Lists) -> io::Result<()> {
    let terms = fit.basis.terms();
    if fit.basis != Basis::Hemispherical(terms) || fit.colors != Colors::Rgb {
        return Err(io::Error::other("no hemispherical harmonics per colour"));
    }
    if lists == Lists::ScaleOffset {
        writeln!(sink, "{SCALED}")?;
    }
    writeln!(
        sink,
        "{HSH}\n{} {} 3\n{terms} {SEPARATE_COLORS} 1",
        fit.width, fit.height
    )?;
    let ranges: Vec<f32> = fit.scale.iter().map(|scale| 255.0 * scale).collect();
    let maxima = ranges
        .iter()
        .zip(&fit.offset)
        .map(|(range, offset)| range + offset)
        .collect();
    let [first, second] = match lists {
        Lists::ScaleOffset => [ranges, fit.offset.clone()],
        Lists::MinimumMaximum => [fit.offset.clone(), maxima],
    };
    for number in first.iter().chain(&second) {
        sink.write_all(&number.to_le_bytes())?;
    }
    sink.write_all(&fit.coefficients)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fit(terms: usize) -> Fit {
        Fit {
            width: 3,
            height: 2,
            basis: Basis::Hemispherical(terms),
            colors: Colors::Rgb,
            scale: (0..terms).map(|k| (k + 1) as f32 / 64.0).collect(),
            offset: (0..terms).map(|k| k as f32 * 0.25 - 1.0).collect(),
            coefficients: (0..18 * terms).map(|k| (k * 5 % 256) as u8).collect(),
            texel_colors: Vec::new(),
            white: 1.0,
        }
    }

    fn bytes_of(fit: &Fit, lists: Lists) -> Vec<u8> {
        let mut bytes = Vec::new();
        encode(&mut bytes, fit, lists).unwrap();
        bytes
    }

    #[test]
    fn both_kinds_of_lists_round_trip() {
        for terms in [4, 9, 16] {
            for lists in [Lists::ScaleOffset, Lists::MinimumMaximum] {
                let fit = fit(terms);
                let found = parse(&bytes_of(&fit, lists)).unwrap();
                assert_eq!(found.coefficients, fit.coefficients);
                for (found, wanted) in found.scale.iter().zip(&fit.scale) {
                    assert!((found - wanted).abs() < 1e-6, "{lists:?}");
                }
                assert_eq!(found.offset, fit.offset);
            }
        }
    }

    #[test]
    fn lists_are_told_apart_by_their_numbers() {
        let of = |first: &[f32], second: &[f32], marked| lists_of(first, second, marked);
        let scaled = Lists::ScaleOffset;
        assert_eq!(of(&[1.0, 2.0], &[-1.0, -3.0], false).unwrap(), scaled);
        assert_eq!(
            of(&[-1.0, 2.0], &[1.0, 3.0], true).unwrap(),
            Lists::MinimumMaximum
        );
        assert_eq!(of(&[1.0], &[2.0], true).unwrap(), scaled);
        assert_eq!(of(&[1.0], &[2.0], false).unwrap(), Lists::MinimumMaximum);
        assert!(of(&[-1.0, 2.0], &[1.0, 1.0], true).is_err());
        assert!(
            of(&[f32::NAN], &[1.0], true)
                .unwrap_err()
                .to_string()
                .contains("term 0")
        );
    }

    #[test]
    fn headers_that_do_not_add_up_are_refused() {
        let bytes = bytes_of(&fit(4), Lists::ScaleOffset);
        let refused = |from: &[u8], to: &[u8]| {
            let at = bytes
                .windows(from.len())
                .position(|part| part == from)
                .unwrap();
            let changed = [&bytes[..at], to, &bytes[at + from.len()..]].concat();
            parse(&changed).unwrap_err().to_string()
        };
        assert!(refused(b"\n3\n", b"\n1\n").contains("hemispherical"));
        assert!(refused(b"2 3\n", b"2 1\n").contains("colours"));
        assert!(refused(b"4 2 1\n", b"7 2 1\n").contains("4, 9 or 16"));
        assert!(refused(b"4 2 1\n", b"4 1 1\n").contains("basis"));
        assert!(refused(b"4 2 1\n", b"4 2 4\n").contains("bytes per coefficient"));
        assert!(refused(b"3 2 3\n", b"3 9 3\n").contains("324 bytes"));
        assert!(parse(b"#HSH1.2\n3\n").is_err());
    }
}
