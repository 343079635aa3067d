//! An image to look at: 8-bit sRGB, from and to files.

use std::path::Path;

use crate::error::Result;
use crate::format::image::{read, write_png};

/// An image of 8-bit sRGB numbers.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RgbImage {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// height × width × 3 numbers: R, G, B of every pixel, row by row.
    pub pixels: Vec<u8>,
}

impl RgbImage {
    /// An image of one grey.
    pub fn plain(width: u32, height: u32, grey: u8) -> Self {
        Self {
            width,
            height,
            pixels: vec![grey; 3 * width as usize * height as usize],
        }
    }

    /// Reads an image file of any kind.
    pub fn read(path: &Path) -> Result<Self> {
        let image = read(path)?.into_rgb();
        let byte = |value: &f32| (value * 255.0 + 0.5) as u8;
        Ok(Self {
            width: image.width,
            height: image.height,
            pixels: image.data.iter().map(byte).collect(),
        })
    }

    /// Writes it as PNG.
    pub fn write(&self, path: &Path) -> Result<()> {
        write_png(path, self.width, self.height, &self.pixels)
    }

    /// Sets pixels of a row, beginning with the one in this column, all to one colour.
    pub fn set_run(&mut self, row: u32, column: u32, count: u32, color: [u8; 3]) {
        let first = 3 * (row as usize * self.width as usize + column as usize);
        let pixels = self.pixels[first..][..3 * count as usize].chunks_mut(3);
        pixels.for_each(|pixel| pixel.copy_from_slice(&color));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn images_come_back_from_files() {
        let mut image = RgbImage::plain(5, 3, 24);
        image.set_run(1, 2, 2, [1, 2, 255]);
        assert_eq!(image.pixels[3 * 7..][..6], [1, 2, 255, 1, 2, 255]);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        image.write(&path).unwrap();
        assert_eq!(RgbImage::read(&path).unwrap(), image);
    }
}
