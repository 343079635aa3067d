//! A sample and options, and the routes that follow: what an analysis in one run and one in parts have in common.

use ndarray::Array3;
use serde_json::Value;

use crate::btf::factored::Factors;
use crate::btf::sample::Sample;
use crate::byte_size::ByteSize;
use crate::error::{Error, Result};
use crate::random::{Stream, stream};
use crate::texton::eigenplanes::Eigenplanes;
use crate::texton::filter_bank::FILTERS;
use crate::texton::image_batches::PlaneSource;
use crate::texton::image_blocks::ImageBlocks;
use crate::texton::image_stack::{Channels, ImageStack};
use crate::texton::options::TextonOptions;
use crate::texton::plan::{Plan, Sizes};
use crate::texton::point_filters::PointFilters;
use crate::texton::representatives::{ImageAppearance, ImageVectors};

/// What is analysed, how, and by which routes.
pub struct Study<'a> {
    /// The sample's images.
    pub stack: ImageStack<'a>,
    /// What the user chose.
    pub options: &'a TextonOptions,
    /// The routes, and what they take.
    pub plan: Plan,
    /// Bytes that a part of the study takes at most.
    pub part_bytes: u64,
}

impl<'a> Study<'a> {
    /// The study by the routes that fit the memory of `options`.
    pub fn new(sample: &'a Sample, options: &'a TextonOptions) -> Result<Self> {
        Self::with(sample, options, |sizes| Plan::new(sizes, options.memory))
    }

    /// The study by decided routes: how many of the finest levels are sketched, and how image appearance vectors
    /// are held. `memory` bounds what is kept to save reading.
    pub fn decided(
        sample: &'a Sample,
        options: &'a TextonOptions,
        (sketched, image_vectors): (usize, ImageVectors),
        memory: Option<ByteSize>,
    ) -> Result<Self> {
        let limit = memory.map_or(u64::MAX, |size| size.0);
        Self::with(sample, options, |sizes| {
            Ok(Plan::decided(sizes, sketched, image_vectors, limit))
        })
    }

    fn with(
        sample: &'a Sample,
        options: &'a TextonOptions,
        plan: impl FnOnce(&Sizes<'_>) -> Result<Plan>,
    ) -> Result<Self> {
        options.validate()?;
        let stack = ImageStack {
            sample,
            channels: match options.luminance {
                true => Channels::Luminance,
                false => Channels::Rgb,
            },
            grids: options.grids(sample)?,
        };
        let sizes = sizes(&stack, options)?;
        let plan = plan(&sizes)?;
        let part_bytes = plan.part_bytes(&sizes);
        Ok(Self {
            stack,
            options,
            plan,
            part_bytes,
        })
    }

    /// How many images are chosen; `None` where all are taken.
    pub fn chosen(&self) -> Result<Option<usize>> {
        let count = self.options.image_count(self.stack.sample)?;
        Ok((count < self.stack.sample.image_count()).then_some(count))
    }

    /// The blocks in which planes are summed: several where they are those of all images of a sample.
    pub fn blocks_of(&self, source: PlaneSource<'_>) -> ImageBlocks {
        match source {
            PlaneSource::Images(images) if images.len() == self.stack.sample.image_count() => {
                ImageBlocks::of_all(images.len())
            }
            other => ImageBlocks::single(other.count()),
        }
    }

    /// The images' appearance vectors.
    pub fn appearance(&self, bank: &Array3<f64>, random: &mut Stream) -> ImageAppearance<'_> {
        let points = self.options.image_grid as usize;
        let point_filters = PointFilters::new(self.stack.grids[0], bank, points);
        ImageAppearance::new(&self.stack, point_filters, self.plan.image_vectors, random)
    }
}

/// What is drawn to choose images.
pub fn random_of_images(options: &TextonOptions) -> Stream {
    stream(options.seed, "representative images", 0, 0)
}

/// The factors whose planes take the place of this many images: where they are no more than the images'.
pub fn standing_for(sample: &Sample, images: usize, channels: Channels) -> Option<&Factors> {
    let factors = sample.factors()?;
    (Eigenplanes::count_of(factors) <= images * channels.count()).then_some(factors)
}

fn sizes<'s>(stack: &'s ImageStack<'_>, options: &TextonOptions) -> Result<Sizes<'s>> {
    let points = |side: u32| options.image_grid.min(side) as usize;
    let point_filters = points(stack.grids[0].height) * points(stack.grids[0].width);
    let images = stack.sample.image_count();
    let representatives = options.image_count(stack.sample)?;
    let factors = standing_for(stack.sample, representatives, stack.channels);
    let takes_images = factors.is_none() && representatives == images;
    Ok(Sizes {
        grids: &stack.grids,
        textons: (0..stack.grids.len())
            .map(|level| options.textons_at(level))
            .collect(),
        channels: stack.channels.count(),
        images,
        representatives,
        eigenplanes: factors.map(Eigenplanes::count_of),
        blocks: match takes_images {
            true => ImageBlocks::of_all(images).count(),
            false => 1,
        },
        factor_bytes: stack.sample.factors().map_or(0, Factors::bytes),
        image_components: stack.channels.count() * point_filters * FILTERS,
    })
}

/// The options as a file keeps them: without the memory, which is the machine's affair.
pub fn recorded(options: &TextonOptions) -> Result<Value> {
    let mut value =
        serde_json::to_value(options).map_err(|error| Error::data("options", error.to_string()))?;
    if let Value::Object(map) = &mut value {
        map.remove("memory");
    }
    Ok(value)
}
