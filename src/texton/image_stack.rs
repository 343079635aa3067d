//! The sample's images as planes of every pyramid level.
//!
//! In: image numbers. Out: for each level the images' planes (R, G, B or Rec. 709 luminance),
//! H·W `f32` each, their means taken off: filters have zero mean, so a plane's mean has no
//! response, and without it `f32` keeps the digits that matter. A level is the 2×2 means of the
//! one before (Tong 2002 §5.1), an odd last row or column averaged alone.

use rayon::prelude::*;

use crate::btf::sample::{Pixels, Sample};
use crate::error::Result;
use crate::grid::TexelGrid;

/// Rec. 709 luminance of linear R, G, B.
pub const LUMINANCE: [f32; 3] = [0.2126, 0.7152, 0.0722];

/// Numbers read at once: images of a batch times those of a finest image.
const PANEL_NUMBERS: usize = 1 << 22;

/// Which planes an image gives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Channels {
    /// Three planes: R, G, B.
    Rgb,
    /// One plane: Rec. 709 luminance.
    Luminance,
}

impl Channels {
    /// Planes of one image.
    pub fn count(self) -> usize {
        match self {
            Self::Rgb => 3,
            Self::Luminance => 1,
        }
    }
}

/// The images of a sample, on every level.
pub struct ImageStack<'a> {
    /// Where they come from.
    pub sample: &'a Sample,
    /// Which planes they give.
    pub channels: Channels,
    /// The texel grids, finest first.
    pub grids: Vec<TexelGrid>,
}

impl ImageStack<'_> {
    /// Images read at once.
    pub fn batch(&self) -> usize {
        self.batch_of(self.channels.count())
    }

    /// What is read at once of things of this many planes each.
    pub fn batch_of(&self, planes: usize) -> usize {
        (PANEL_NUMBERS / (self.grids[0].len() * planes)).max(1)
    }

    /// Planes of `images` at every level: [level][image · C + channel, texel].
    pub fn read(&self, images: &[u32]) -> Result<Vec<Vec<f32>>> {
        Ok(self.pyramid(self.finest(images)?))
    }

    /// Planes at every level, from those of the finest; all without their means.
    pub fn pyramid(&self, finest: Vec<f32>) -> Vec<Vec<f32>> {
        let mut levels = vec![finest];
        for pair in self.grids.windows(2) {
            let coarser = match levels.last() {
                Some(planes) => halved(planes, pair[0], pair[1]),
                None => Vec::new(),
            };
            levels.push(coarser);
        }
        for (planes, grid) in levels.iter_mut().zip(&self.grids) {
            planes.par_chunks_mut(grid.len()).for_each(take_off_mean);
        }
        levels
    }

    /// Planes of `images` at the finest level alone.
    pub fn read_finest(&self, images: &[u32]) -> Result<Vec<f32>> {
        let mut planes = self.finest(images)?;
        planes
            .par_chunks_mut(self.grids[0].len())
            .for_each(take_off_mean);
        Ok(planes)
    }

    /// Tells the system that these images will be read soon, so that they are fetched while others are worked on.
    pub fn announce(&self, images: &[u32]) {
        let texels = 0..self.grids[0].len();
        self.sample.announce_texels_of(images, texels);
    }

    fn finest(&self, images: &[u32]) -> Result<Vec<f32>> {
        let image_length = self.channels.count() * self.grids[0].len();
        let mut planes = vec![0.0; images.len() * image_length];
        // Images of factored samples are cheaper together, those of others are read one by one.
        let together = match self.sample.factors() {
            Some(_) => images.len().div_ceil(rayon::current_num_threads()).max(1),
            None => 1,
        };
        planes
            .par_chunks_mut(together * image_length)
            .zip(images.par_chunks(together))
            .try_for_each_init(
                || (Vec::new(), Vec::new()),
                |(held, numbers), (planes, images)| {
                    held.resize(
                        images.len(),
                        Pixels::of_type(self.sample.description().dtype),
                    );
                    let texels = 0..self.grids[0].len();
                    self.sample.read_texels_of(images, texels, held)?;
                    let read = images.iter().zip(held);
                    read.zip(planes.chunks_mut(image_length)).try_for_each(
                        |((&image, pixels), planes)| {
                            self.read_image(image as usize, pixels, numbers, planes)
                        },
                    )
                },
            )?;
        Ok(planes)
    }

    fn read_image(
        &self,
        image: usize,
        pixels: &Pixels,
        numbers: &mut Vec<f32>,
        planes: &mut [f32],
    ) -> Result<()> {
        numbers.resize(pixels.len(), 0.0);
        pixels.copy_to(numbers);
        self.sample.check_image(image, numbers)?;
        let texels = self.grids[0].len();
        match self.channels {
            Channels::Rgb => {
                for (channel, plane) in planes.chunks_mut(texels).enumerate() {
                    let values = numbers.iter().skip(channel).step_by(3);
                    plane.iter_mut().zip(values).for_each(|(p, &v)| *p = v);
                }
            }
            Channels::Luminance => {
                for (value, rgb) in planes.iter_mut().zip(numbers.chunks(3)) {
                    *value = rgb.iter().zip(LUMINANCE).map(|(v, w)| v * w).sum();
                }
            }
        }
        Ok(())
    }
}

/// 2×2 means of every plane.
fn halved(planes: &[f32], fine: TexelGrid, coarse: TexelGrid) -> Vec<f32> {
    let mut out = vec![0.0; planes.len() / fine.len() * coarse.len()];
    out.par_chunks_mut(coarse.len())
        .zip(planes.par_chunks(fine.len()))
        .for_each(|(out, plane)| halve(plane, fine, out, coarse));
    out
}

fn halve(plane: &[f32], fine: TexelGrid, out: &mut [f32], coarse: TexelGrid) {
    let (height, width) = (fine.height as usize, fine.width as usize);
    for (row, out) in out.chunks_mut(coarse.width as usize).enumerate() {
        let rows = 2 * row..(2 * row + 2).min(height);
        for (col, out) in out.iter_mut().enumerate() {
            let cols = 2 * col..(2 * col + 2).min(width);
            let (mut sum, count) = (0.0, rows.len() * cols.len());
            for row in rows.clone() {
                sum += plane[row * width + cols.start..row * width + cols.end]
                    .iter()
                    .sum::<f32>();
            }
            *out = sum / count as f32;
        }
    }
}

fn take_off_mean(plane: &mut [f32]) {
    let sum: f64 = plane.iter().map(|&v| f64::from(v)).sum();
    let mean = (sum / plane.len() as f64) as f32;
    plane.iter_mut().for_each(|v| *v -= mean);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_are_means_of_what_exists() {
        let fine = TexelGrid {
            width: 3,
            height: 3,
            tileable: false,
        };
        let plane: Vec<f32> = (1..=9).map(|v| v as f32).collect();
        let coarse = halved(&plane, fine, fine.coarser());
        assert_eq!(coarse, [3.0, 4.5, 7.5, 9.0]);
    }

    #[test]
    fn constant_planes_become_exactly_nothing() {
        let mut plane = vec![0.1_f32; 35];
        take_off_mean(&mut plane);
        assert_eq!(plane, [0.0; 35]);
    }
}
