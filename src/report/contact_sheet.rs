//! Many pictures on one: thumbnails in rows, a label under each.

use std::path::Path;

use rayon::prelude::*;

use crate::error::Result;
use crate::format::image::{self, decode_srgb, encode_srgb8};
use crate::report::lettering;

/// An 8-bit sRGB picture, row-major (height, width, RGB).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// height × width × 3 bytes.
    pub pixels: Vec<u8>,
}

impl Picture {
    /// Reads an image file of any kind, as 8-bit sRGB.
    pub fn read(path: &Path) -> Result<Self> {
        let image = image::read(path)?.into_rgb();
        let byte = |value: &f32| (value * 255.0 + 0.5) as u8;
        Ok(Self {
            width: image.width,
            height: image.height,
            pixels: image.data.iter().map(byte).collect(),
        })
    }
}

const BACKGROUND: u8 = 24;
const INK: u8 = 220;
/// Blank pixels round thumbnails and labels.
const GAP: u32 = 6;
/// Pixels a label's dot is wide.
const DOT: u32 = 1;

impl Picture {
    fn blank(width: u32, height: u32) -> Self {
        let pixels = vec![BACKGROUND; width as usize * height as usize * 3];
        Self {
            width,
            height,
            pixels,
        }
    }

    /// The picture at most `width` columns wide, by the mean of linear light in each new pixel.
    #[must_use]
    pub fn reduced_to(&self, width: u32) -> Self {
        if self.width <= width {
            return self.clone();
        }
        let height =
            (u64::from(self.height) * u64::from(width)).div_ceil(u64::from(self.width)) as u32;
        let linear: Vec<f32> = (0..=255u8)
            .map(|v| decode_srgb(f32::from(v) / 255.0))
            .collect();
        let source = |new: u32, old_side: u32, new_side: u32| {
            let scaled = |k: u32| u64::from(k) * u64::from(old_side) / u64::from(new_side);
            let (from, to) = (scaled(new), scaled(new + 1));
            from as usize..to.max(from + 1) as usize
        };
        let row = |row: u32| {
            (0..width)
                .flat_map(move |column| [[row, column, 0], [row, column, 1], [row, column, 2]])
        };
        let mean = |[row, column, channel]: [u32; 3]| {
            let rows = source(row, self.height, height);
            let columns = source(column, self.width, width);
            let count = (rows.len() * columns.len()) as f32;
            let sum: f32 = rows
                .flat_map(|r| columns.clone().map(move |c| (r, c)))
                .map(|(r, c)| (r * self.width as usize + c) * 3 + channel as usize)
                .map(|at| linear[usize::from(self.pixels[at])])
                .sum();
            encode_srgb8(sum / count)
        };
        Self {
            width,
            height,
            pixels: (0..height)
                .into_par_iter()
                .flat_map_iter(row)
                .map(mean)
                .collect(),
        }
    }

    fn paste(&mut self, other: &Self, column: u32, row: u32) {
        let bytes = other.width as usize * 3;
        for (index, line) in other.pixels.chunks(bytes).enumerate() {
            let at = ((row as usize + index) * self.width as usize + column as usize) * 3;
            self.pixels[at..at + bytes].copy_from_slice(line);
        }
    }

    fn write(&mut self, text: &str, column: u32, row: u32) {
        let (width, height) = (self.width, self.height);
        lettering::ink(text, |x, y| {
            for (dx, dy) in (0..DOT).flat_map(|dx| (0..DOT).map(move |dy| (dx, dy))) {
                let (x, y) = (column + x * DOT + dx, row + y * DOT + dy);
                if x < width && y < height {
                    let at = (y as usize * width as usize + x as usize) * 3;
                    self.pixels[at..at + 3].fill(INK);
                }
            }
        });
    }
}

/// Lays thumbnails of equal size out in rows, with a label under each; labels wider than their
/// thumbnail are broken at double spaces.
pub fn contact_sheet(thumbnails: &[(Picture, String)]) -> Picture {
    let widest = thumbnails.iter().map(|(p, _)| p.width).max().unwrap_or(1);
    let tallest = thumbnails.iter().map(|(p, _)| p.height).max().unwrap_or(1);
    let labels: Vec<Vec<String>> = thumbnails.iter().map(|(_, l)| lines(l, widest)).collect();
    let label_lines = labels.iter().map(Vec::len).max().unwrap_or(0) as u32;
    let line_height = lettering::HEIGHT * DOT + 3;
    let cell = [widest + GAP, tallest + 3 + label_lines * line_height + GAP];
    let columns = (thumbnails.len() as f64).sqrt().ceil().max(1.0) as u32;
    let rows = (thumbnails.len() as u32).div_ceil(columns).max(1);
    let mut sheet = Picture::blank(columns * cell[0] + GAP, rows * cell[1] + GAP);
    for (index, ((picture, _), label)) in thumbnails.iter().zip(&labels).enumerate() {
        let (column, row) = (index as u32 % columns, index as u32 / columns);
        let (x, y) = (GAP + column * cell[0], GAP + row * cell[1]);
        sheet.paste(picture, x, y);
        for (line, text) in label.iter().enumerate() {
            sheet.write(text, x, y + tallest + 3 + line as u32 * line_height);
        }
    }
    sheet
}

fn lines(label: &str, width: u32) -> Vec<String> {
    if lettering::width(label.len()) * DOT <= width {
        return vec![label.to_string()];
    }
    label.split("  ").map(str::to_string).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plain(width: u32, height: u32, value: u8) -> Picture {
        let pixels = vec![value; (width * height * 3) as usize];
        Picture {
            width,
            height,
            pixels,
        }
    }

    #[test]
    fn reducing_keeps_light() {
        let mut picture = plain(64, 32, 0);
        for (index, pixel) in picture.pixels.chunks_mut(3).enumerate() {
            pixel.fill(if index % 2 == 0 { 255 } else { 0 });
        }
        let small = picture.reduced_to(16);
        assert_eq!((small.width, small.height), (16, 8));
        // Half the light, not half the code value.
        assert!(small.pixels.iter().all(|&v| v == 188));
        assert_eq!(small.reduced_to(100), small);
    }

    #[test]
    fn sheets_hold_every_picture_and_its_label() {
        let pictures: Vec<_> = (0..5)
            .map(|k| (plain(80, 20, 50 + k), format!("{k}  light 45")))
            .collect();
        let sheet = contact_sheet(&pictures);
        for k in 0..5 {
            let found = sheet.pixels.chunks(3).filter(|p| p[0] == 50 + k).count();
            assert_eq!(found, 80 * 20);
        }
        assert!(sheet.pixels.contains(&INK));
    }
}
