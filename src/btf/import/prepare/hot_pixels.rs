//! Hot pixels: places of a camera's sensor that are bright in every picture, whatever is in front.
//!
//! A pixel is hot where it is several times as bright as each of its neighbours, in at least three of four
//! pictures. It becomes the mean of its neighbours that are not hot. Glints move from picture to picture and
//! stay.

use crate::format::image::FloatImage;

/// The fewest pictures in which hot pixels can be told from glints.
pub(super) const FEWEST_PICTURES: usize = 4;
/// The most pictures that are looked at.
pub(super) const MOST_PICTURES: usize = 64;
/// Light that a neighbour has at least, for the comparison.
const DARK: f32 = 1.0 / 255.0;

/// Counts, for each pixel of pictures of one size, how often it stands out.
#[derive(Debug)]
pub(super) struct Counts {
    width: usize,
    factor: f32,
    pictures: usize,
    counts: Vec<u16>,
}

impl Counts {
    pub(super) fn new(width: u32, height: u32, factor: f32) -> Self {
        Self {
            width: width as usize,
            factor,
            pictures: 0,
            counts: vec![0; width as usize * height as usize],
        }
    }

    /// Looks at one picture.
    pub(super) fn add(&mut self, image: &FloatImage) {
        self.pictures += 1;
        for texel in 0..self.counts.len() {
            let stands_out = (0..3).any(|channel| {
                let light = |texel: usize| image.data[texel * 3 + channel];
                let brightest = neighbors(texel, self.width, self.counts.len())
                    .map(light)
                    .fold(DARK, f32::max);
                light(texel) > self.factor * brightest
            });
            self.counts[texel] += u16::from(stands_out);
        }
    }

    /// The pixels that are hot.
    pub(super) fn hot(&self) -> HotPixels {
        let is_hot = |texel: &usize| usize::from(self.counts[*texel]) * 4 >= self.pictures * 3;
        HotPixels {
            texels: (0..self.counts.len()).filter(is_hot).collect(),
        }
    }
}

/// The hot pixels of a camera, sorted.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct HotPixels {
    pub(super) texels: Vec<usize>,
}

impl HotPixels {
    /// Puts the mean of their neighbours in place of hot pixels.
    pub(super) fn mend(&self, image: &mut FloatImage) {
        let (width, texels) = (image.width as usize, image.data.len() / 3);
        for &texel in &self.texels {
            let sound: Vec<usize> = neighbors(texel, width, texels)
                .filter(|neighbor| self.texels.binary_search(neighbor).is_err())
                .collect();
            for channel in 0..3 {
                let light = sound.iter().map(|&n| image.data[n * 3 + channel]);
                if !sound.is_empty() {
                    image.data[texel * 3 + channel] = light.sum::<f32>() / sound.len() as f32;
                }
            }
        }
    }
}

/// The up to eight texels round one, row by row.
fn neighbors(texel: usize, width: usize, texels: usize) -> impl Iterator<Item = usize> {
    let (row, col) = (texel / width, texel % width);
    let (last_row, last_col) = (texels / width - 1, width - 1);
    let rows = row.saturating_sub(1)..=(row + 1).min(last_row);
    let around = move |row: usize| {
        let cols = col.saturating_sub(1)..=(col + 1).min(last_col);
        cols.map(move |col| row * width + col)
    };
    rows.flat_map(around).filter(move |&other| other != texel)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::format::image::{Encoding, Precision};

    fn picture(bright: &[usize]) -> FloatImage {
        let light = |texel: usize| if bright.contains(&texel) { 0.9 } else { 0.1 };
        FloatImage {
            width: 5,
            height: 4,
            channels: 3,
            data: (0..20).flat_map(|texel| [light(texel); 3]).collect(),
            encoding: Encoding::Linear,
            precision: Precision::Bits8,
        }
    }

    #[test]
    fn what_stays_bright_is_hot_and_what_moves_is_not() {
        let mut counts = Counts::new(5, 4, 3.0);
        for glint in [2, 9, 14, 16] {
            counts.add(&picture(&[0, 12, glint]));
        }
        let hot = counts.hot();
        assert_eq!(hot.texels, [0, 12]);
        let mut image = picture(&[0, 12, 2]);
        hot.mend(&mut image);
        assert!((image.get(0, 0, 1) - 0.1).abs() < 1e-6);
        assert!((image.get(2, 2, 0) - 0.1).abs() < 1e-6);
        assert_eq!(image.get(0, 2, 0), 0.9);
    }
}
