//! Images as matrices, one per channel, [images, texels]: read in panels of rows, never held whole.

use std::ops::Range;

use rayon::prelude::*;

use crate::btf::description::Description;
use crate::btf::factored::factorization::CHANNELS;
use crate::btf::image_source::ImageSource;
use crate::error::Result;
use crate::progress::Progress;

/// Numbers of a panel: enough for products to be quick.
const PANEL_NUMBERS: usize = 1 << 23;

/// The images of a source as three matrices.
pub struct ImageMatrix<'a> {
    source: &'a dyn ImageSource,
    /// Images.
    pub rows: usize,
    /// Texels.
    pub columns: usize,
}

impl<'a> ImageMatrix<'a> {
    /// The images of a source.
    pub fn new(source: &'a dyn ImageSource) -> Self {
        let description = source.description();
        Self {
            source,
            rows: description.image_count(),
            columns: description.grid().len(),
        }
    }

    /// What the images show.
    pub fn description(&self) -> &Description {
        self.source.description()
    }

    /// Images in a panel; of the sides alone, so that sums run in the same order on every machine.
    fn panel(&self) -> usize {
        (PANEL_NUMBERS / (CHANNELS * self.columns)).clamp(1, self.rows)
    }

    /// Bytes that reading takes.
    pub fn bytes(&self) -> u64 {
        2 * 4 * (self.panel() * CHANNELS * self.columns) as u64
    }

    /// Hands on every panel as it is read: its images, and their numbers [images, texels, 3].
    pub fn each_as_read(
        &self,
        stage: &str,
        progress: Progress<'_>,
        mut take: impl FnMut(Range<usize>, &[f32]),
    ) -> Result<()> {
        let mut numbers = Vec::new();
        progress.begin(stage, self.rows as u64);
        for first in (0..self.rows).step_by(self.panel()) {
            let images = first..self.rows.min(first + self.panel());
            numbers.resize(images.len() * CHANNELS * self.columns, 0.0);
            self.source.read_images(images.clone(), &mut numbers)?;
            take(images.clone(), &numbers);
            progress.advance(images.len() as u64)?;
        }
        progress.end();
        Ok(())
    }

    /// Hands on every panel by channels: its images, and for each channel their planes
    /// [images, texels].
    pub fn each(
        &self,
        stage: &str,
        progress: Progress<'_>,
        mut take: impl FnMut(Range<usize>, &[Vec<f32>; CHANNELS]),
    ) -> Result<()> {
        let mut planes = [(); CHANNELS].map(|()| Vec::new());
        self.each_as_read(stage, progress, |images, numbers| {
            for (channel, planes) in planes.iter_mut().enumerate() {
                planes.resize(images.len() * self.columns, 0.0);
                planes
                    .par_chunks_mut(self.columns)
                    .zip(numbers.par_chunks(CHANNELS * self.columns))
                    .for_each(|(plane, image)| {
                        let values = image.iter().skip(channel).step_by(CHANNELS);
                        plane.iter_mut().zip(values).for_each(|(p, &v)| *p = v);
                    });
            }
            take(images, &planes);
        })
    }
}
