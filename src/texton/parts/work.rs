//! What the runs of a shared analysis share, and what their parts hold.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};
use crate::shard::Shard;
use crate::texton::filter_bank::leung_malik;
use crate::texton::image_blocks::ImageBlocks;
use crate::texton::image_products::ImageProducts;
use crate::texton::study::{Study, random_of_images, standing_for};

/// The array of image appearance vectors.
pub(super) const VECTORS: &str = "image_vectors";

/// What parts of an analysis hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Holds {
    /// Appearance vectors of images, from which some are chosen.
    ImageVectors,
    /// Dot products of blocks of images.
    ImageProducts,
}

/// What is shared among shards.
pub(super) enum Work {
    /// So many images, one by one.
    Vectors(usize),
    /// Blocks of images.
    Products(ImageBlocks),
}

impl Work {
    /// What the parts of a study hold; refuses studies that cannot be shared.
    pub(super) fn of(study: &Study<'_>) -> Result<Self> {
        let sample = study.stack.sample;
        let images = sample.image_count();
        if study.chosen()?.is_some() {
            return Ok(Self::Vectors(images));
        }
        if let Some(factors) = standing_for(sample, images, study.stack.channels) {
            return Err(Error::option(
                "shard",
                format!("given for a sample of rank {}", factors.rank()),
                "one run without --shard: it reads eigentextures in place of images",
            ));
        }
        match study.plan.sketched() {
            0 => Ok(Self::Products(ImageBlocks::of_all(images))),
            levels => Err(Error::option(
                "shard",
                format!(
                    "with all images, the finest {levels} of {} levels would be sketched for want of memory",
                    study.plan.routes.len()
                ),
                "--images N, a larger --memory (for the reduction), or one run without --shard",
            )),
        }
    }

    pub(super) fn holds(&self) -> Holds {
        match self {
            Self::Vectors(_) => Holds::ImageVectors,
            Self::Products(_) => Holds::ImageProducts,
        }
    }

    /// Shards at most.
    pub(super) fn units(&self) -> usize {
        match self {
            Self::Vectors(images) => *images,
            Self::Products(blocks) => blocks.count(),
        }
    }

    pub(super) fn name_of_units(&self) -> &'static str {
        match self {
            Self::Vectors(_) => "images",
            Self::Products(_) => "blocks of images that are summed",
        }
    }

    /// The images of a shard.
    pub(super) fn images(&self, shard: Shard) -> Range<usize> {
        let units = shard.range(self.units());
        match self {
            Self::Vectors(_) => units,
            Self::Products(blocks) => {
                blocks.images(units.start).start..blocks.images(units.end - 1).end
            }
        }
    }

    /// Names and shapes of the arrays of a shard's part.
    pub(super) fn arrays(&self, study: &Study<'_>, shard: Shard) -> Vec<(String, Vec<usize>)> {
        match self {
            Self::Vectors(images) => {
                let bank = leung_malik();
                let appearance = study.appearance(&bank, &mut random_of_images(study.options));
                let shape = vec![shard.range(*images).len(), appearance.columns()];
                vec![(VECTORS.into(), shape)]
            }
            Self::Products(blocks) => {
                let lengths = ImageProducts::stored_lengths(&study.stack.grids);
                let of_block = |block: usize| {
                    let levels = lengths.iter().enumerate();
                    levels.map(move |(level, &length)| (products_of(level, block), vec![length]))
                };
                shard.range(blocks.count()).flat_map(of_block).collect()
            }
        }
    }
}

/// The array of a block's dot products on a level.
pub(super) fn products_of(level: usize, block: usize) -> String {
    format!("L{level}/products{block}")
}
