//! Many pictures on one: thumbnails in rows, a label under each.

use rayon::prelude::*;

use crate::format::image::{decode_srgb, encode_srgb8};
use crate::format::rgb_image::RgbImage;
use crate::report::lettering;

const BACKGROUND: u8 = 24;
const INK: u8 = 230;
/// Blank pixels round thumbnails and labels.
const GAP: u32 = 10;
/// What stands between the parts of a label.
const BETWEEN: &str = "  ";

/// A picture at most `width` columns wide, by the mean of linear light in each new pixel.
pub fn reduced(picture: RgbImage, width: u32) -> RgbImage {
    if picture.width <= width {
        return picture;
    }
    // Find the height.
    let height =
        (u64::from(picture.height) * u64::from(width)).div_ceil(u64::from(picture.width)) as u32;
    // Average the linear light of the pixels that each new one covers.
    let linear: Vec<f32> = (0..=255u8)
        .map(|v| decode_srgb(f32::from(v) / 255.0))
        .collect();
    let source = |new: u32, old_side: u32, new_side: u32| {
        let scaled = |k: u32| u64::from(k) * u64::from(old_side) / u64::from(new_side);
        let (from, to) = (scaled(new), scaled(new + 1));
        from as usize..to.max(from + 1) as usize
    };
    let row = |row: u32| {
        (0..width).flat_map(move |column| [[row, column, 0], [row, column, 1], [row, column, 2]])
    };
    let mean = |[row, column, channel]: [u32; 3]| {
        let rows = source(row, picture.height, height);
        let columns = source(column, picture.width, width);
        let count = (rows.len() * columns.len()) as f32;
        let sum: f32 = rows
            .flat_map(|r| columns.clone().map(move |c| (r, c)))
            .map(|(r, c)| (r * picture.width as usize + c) * 3 + channel as usize)
            .map(|at| linear[usize::from(picture.pixels[at])])
            .sum();
        encode_srgb8(sum / count)
    };
    let rows = (0..height).into_par_iter().flat_map_iter(row);
    RgbImage {
        width,
        height,
        pixels: rows.map(mean).collect(),
    }
}

/// Copies a picture into the sheet, its corner at `column` and `row`.
fn paste(sheet: &mut RgbImage, picture: &RgbImage, column: u32, row: u32) {
    let bytes = picture.width as usize * 3;
    for (index, line) in picture.pixels.chunks(bytes).enumerate() {
        let at = ((row as usize + index) * sheet.width as usize + column as usize) * 3;
        sheet.pixels[at..at + bytes].copy_from_slice(line);
    }
}

/// Writes lines of text over the background.
fn write_lines(sheet: &mut RgbImage, lines: &[String], column: u32, row: u32) {
    let width = sheet.width as usize;
    for (top, line) in (row..).step_by(lettering::HEIGHT as usize).zip(lines) {
        lettering::ink(line, |x, y, covered| {
            let at = ((top + y) as usize * width + (column + x) as usize) * 3;
            let shade = f32::from(BACKGROUND) + covered * f32::from(INK - BACKGROUND);
            sheet.pixels[at..at + 3].fill(shade as u8);
        });
    }
}

/// Lays thumbnails out in rows, with a label under each.
///
/// The parts of a label stand two spaces apart; the first names the picture. Others that all labels have stand once, in
/// a heading, after the number of pictures and before the `legend`.
pub fn contact_sheet(thumbnails: &[(RgbImage, String)], legend: &str) -> RgbImage {
    let labels = thumbnails
        .iter()
        .map(|(_, label)| label.split(BETWEEN).collect());
    let mut labels: Vec<Vec<&str>> = labels.collect();
    let common = take_common(&mut labels);
    let pictures = || thumbnails.iter().map(|(picture, _)| picture);
    let tallest = pictures().map(|picture| picture.height).max().unwrap_or(1);
    // No part of a label is broken.
    let parts = labels.iter().flatten().map(|part| lettering::width(part));
    let widest = pictures()
        .map(|picture| picture.width)
        .chain(parts)
        .max()
        .unwrap_or(1);
    let labels: Vec<Vec<String>> = labels.iter().map(|parts| wrapped(parts, widest)).collect();
    let lines = labels.iter().map(Vec::len).max().unwrap_or(0) as u32;
    let cell = [
        widest + GAP,
        tallest + GAP / 2 + lines * lettering::HEIGHT + GAP,
    ];
    let columns = (thumbnails.len() as f64).sqrt().ceil().max(1.0) as u32;
    let rows = (thumbnails.len() as u32).div_ceil(columns).max(1);

    let count = match thumbnails.len() {
        1 => "1 frame".to_owned(),
        count => format!("{count} frames"),
    };
    let heading = [vec![count.as_str()], common, vec![legend]].concat();
    let longest = heading.iter().map(|part| lettering::width(part)).max();
    let width = (columns * cell[0] - GAP).max(longest.unwrap_or(0));
    let heading = wrapped(&heading, width);
    let top = GAP + heading.len() as u32 * lettering::HEIGHT + GAP;

    let mut sheet = RgbImage::plain(width + 2 * GAP, top + rows * cell[1], BACKGROUND);
    write_lines(&mut sheet, &heading, GAP, GAP);
    for (index, (picture, label)) in (0..).zip(pictures().zip(&labels)) {
        let (x, y) = (
            GAP + index % columns * cell[0],
            top + index / columns * cell[1],
        );
        paste(&mut sheet, picture, x, y);
        write_lines(&mut sheet, label, x, y + tallest + GAP / 2);
    }
    sheet
}

/// Takes the parts that all labels have out of them, but for the first of each.
fn take_common<'a>(labels: &mut [Vec<&'a str>]) -> Vec<&'a str> {
    let first = labels.first().cloned().unwrap_or_default();
    let is_common = |part: &&str| labels.iter().all(|label| label[1..].contains(part));
    let common: Vec<&str> = first.into_iter().skip(1).filter(is_common).collect();
    for label in labels {
        let name = label.remove(0);
        label.retain(|part| !common.contains(part));
        label.insert(0, name);
    }
    common
}

/// Parts in lines of at most `width` columns; a part that is wider has a line for itself.
fn wrapped(parts: &[&str], width: u32) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for part in parts {
        let longer = lines.last().map(|line| format!("{line}{BETWEEN}{part}"));
        match (lines.last_mut(), longer) {
            (Some(line), Some(longer)) if lettering::width(&longer) <= width => *line = longer,
            _ => lines.push((*part).to_owned()),
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reducing_keeps_light() {
        let mut picture = RgbImage::plain(64, 32, 0);
        for (index, pixel) in picture.pixels.chunks_mut(3).enumerate() {
            pixel.fill(if index % 2 == 0 { 255 } else { 0 });
        }
        let small = reduced(picture, 16);
        assert_eq!((small.width, small.height), (16, 8));
        // Half the light, not half the code value.
        assert!(small.pixels.iter().all(|&v| v == 188));
        assert_eq!(reduced(small.clone(), 100), small);
    }

    #[test]
    fn sheets_hold_every_picture_and_its_label() {
        let pictures: Vec<_> = (0..5)
            .map(|k| {
                (
                    RgbImage::plain(80, 20, 50 + k),
                    format!("{k}  light {}°  view 0°", 10 * k),
                )
            })
            .collect();
        let sheet = contact_sheet(&pictures, "azimuths");
        for k in 0..5 {
            let found = sheet.pixels.chunks(3).filter(|p| p[0] == 50 + k).count();
            assert!(found >= 80 * 20, "{found}");
        }
        assert!(sheet.pixels.iter().any(|&value| value > 200));
        // Small pictures leave their labels whole.
        assert!(sheet.width > 3 * lettering::width("light 10°"));
    }

    #[test]
    fn what_labels_have_in_common_is_said_once() {
        let mut labels = vec![
            vec!["1", "light 10° 45°", "view 0° 15°"],
            vec!["2", "light 20° 45°", "view 0° 15°"],
        ];
        assert_eq!(take_common(&mut labels), ["view 0° 15°"]);
        assert_eq!(labels, [["1", "light 10° 45°"], ["2", "light 20° 45°"]]);
        let letter = lettering::width("1");
        assert_eq!(wrapped(&labels[0], 16 * letter), ["1  light 10° 45°"]);
        assert_eq!(wrapped(&labels[0], 15 * letter), ["1", "light 10° 45°"]);
        let mut alone = vec![vec!["1", "1", "light"]];
        assert_eq!(take_common(&mut alone), ["1", "light"]);
        assert_eq!(alone, [["1"]]);
    }
}
