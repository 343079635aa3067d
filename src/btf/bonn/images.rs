//! The images of a `.btf` file as linear radiance for unit irradiance.
//!
//! A file holds reflectance, with the light's cosine in it where the cosine flag is set. A sample's values have the
//! cosine, and white is 1/π: values are multiplied by 1/π, and by the cosine where the file has it divided out.

use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};

use rayon::prelude::*;

use crate::btf::bonn::body::Body;
use crate::btf::description::Description;
use crate::btf::height_map::HeightMap;
use crate::btf::image_source::ImageSource;
use crate::error::{Error, Result};
use crate::progress::Progress;

/// The images of a file.
pub(super) struct BonnImages {
    /// What they show; views, lights and grid as in the file.
    pub(super) description: Description,
    /// Where they come from.
    pub(super) body: Box<dyn Body>,
    /// How high each texel lies, if the file states it.
    pub(super) heights: Option<HeightMap>,
    /// The factor of each light.
    pub(super) scales: Vec<f32>,
    /// Negative values met so far, which become 0.
    pub(super) negative: AtomicU64,
}

impl BonnImages {
    fn texels(&self) -> usize {
        self.description.grid().len()
    }

    /// How many images are best read in one run.
    pub(super) fn run(&self) -> usize {
        (self.body.run_bytes() / (self.texels() * 12)).max(1)
    }

    /// ‖wanted − these images‖ / ‖wanted‖.
    pub(super) fn relative_error(
        &self,
        wanted: &dyn ImageSource,
        progress: Progress<'_>,
    ) -> Result<f64> {
        let count = self.description.image_count();
        let (run, image) = (self.run().min(count), self.texels() * 3);
        let mut numbers = [vec![0.0; run * image], vec![0.0; run * image]];
        let (mut left, mut all) = (0.0, 0.0);
        progress.begin("measuring the error", count as u64);
        for start in (0..count).step_by(run) {
            progress.check()?;
            let images = start..count.min(start + run);
            let [found, wanted_numbers] = &mut numbers;
            let found = &mut found[..images.len() * image];
            let wanted_numbers = &mut wanted_numbers[..images.len() * image];
            self.read_images(images.clone(), found)?;
            wanted.read_images(images.clone(), wanted_numbers)?;
            for (&found, &wanted) in found.iter().zip(&*wanted_numbers) {
                left += f64::from(found - wanted).powi(2);
                all += f64::from(wanted).powi(2);
            }
            progress.advance(images.len() as u64)?;
        }
        progress.end();
        Ok(if all > 0.0 { (left / all).sqrt() } else { 0.0 })
    }

    fn finish(&self, image: usize, values: &mut [f32]) -> Result<()> {
        let scale = self.scales[image % self.scales.len()];
        let mut negative = 0;
        for value in values.iter_mut() {
            *value *= scale;
            if *value < 0.0 {
                *value = 0.0;
                negative += 1;
            }
        }
        self.negative.fetch_add(negative, Ordering::Relaxed);
        let Some(at) = values.iter().position(|value| !value.is_finite()) else {
            return Ok(());
        };
        let (view, light) = self.description.view_and_light(image);
        let (row, column) = (
            at / 3 / self.description.width as usize,
            at / 3 % self.description.width as usize,
        );
        Err(Error::data(
            format!("view {view}, light {light}, row {row}, column {column}"),
            values[at].to_string(),
        )
        .expected("a finite value"))
    }
}

impl ImageSource for BonnImages {
    fn description(&self) -> &Description {
        &self.description
    }

    fn heights(&self) -> Result<Option<HeightMap>> {
        Ok(self.heights.clone())
    }

    fn read_images(&self, images: Range<usize>, out: &mut [f32]) -> Result<()> {
        let first = images.start;
        self.body.read(images, out)?;
        out.par_chunks_mut(self.texels() * 3)
            .enumerate()
            .try_for_each(|(at, values)| self.finish(first + at, values))
    }
}
