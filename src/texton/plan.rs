//! Which route every level takes, from what it would need and what it may take.
//!
//! In: sizes and a memory limit. Out: one route per level, and how images are held; or the least
//! memory that would do. Figures are of the arrays that dominate, with a margin for the rest.

use crate::byte_size::ByteSize;
use crate::error::{Error, Result};
use crate::grid::TexelGrid;
use crate::texton::fft_filters::FftFilters;
use crate::texton::filter_bank::FILTERS;
use crate::texton::representatives::ImageVectors;
use crate::texton::sketch::COORDINATES;
use crate::texton::texel_gram;

/// ImageBatches, working room of the threads, the program itself.
const MARGIN: u64 = 160 << 20;

/// How a level's textons are found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Route {
    /// Through all pairs of dot products: exact.
    Gram,
    /// Through a projection of the appearance vectors: with a measured distortion.
    Sketch,
}

/// The sizes that decide.
#[derive(Clone, Debug)]
pub struct Sizes<'a> {
    /// Texel grids, finest first.
    pub grids: &'a [TexelGrid],
    /// Textons a level.
    pub textons: Vec<usize>,
    /// Planes of an image.
    pub channels: usize,
    /// Images of the sample.
    pub images: usize,
    /// Images the appearance vectors are made of.
    pub representatives: usize,
    /// Planes of a factored sample that take the images' place.
    pub eigenplanes: Option<usize>,
    /// Blocks of images whose dot products are summed one by one.
    pub blocks: usize,
    /// Bytes of the sample that are in memory throughout: factors.
    pub factor_bytes: u64,
    /// Responses of one image on the sub-grid.
    pub image_components: usize,
}

/// What is done within the memory.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// One route per level.
    pub routes: Vec<Route>,
    /// How image appearance vectors are held.
    pub image_vectors: ImageVectors,
    /// Whether the representative images stay in memory after they were read once.
    pub keep_images: bool,
    /// Bytes the plan expects to take at most.
    pub bytes: u64,
}

impl Plan {
    /// How many of the finest levels are sketched.
    pub fn sketched(&self) -> usize {
        let routes = self.routes.iter();
        routes.filter(|&&route| route == Route::Sketch).count()
    }

    /// The exact routes where they fit `limit`, else the others; an error when nothing fits.
    pub fn new(sizes: &Sizes<'_>, limit: Option<ByteSize>) -> Result<Self> {
        let limit = limit.map_or(u64::MAX, |size| size.0);
        let fits = |first_gram: &usize| sizes.least_bytes(*first_gram) <= limit;
        let Some(first_gram) = (0..=sizes.grids.len()).find(fits) else {
            return Err(too_small(sizes, limit));
        };
        let exact = Self::decided(sizes, first_gram, ImageVectors::Exact, limit);
        match exact.bytes <= limit {
            true => Ok(exact),
            false => Ok(Self::decided(
                sizes,
                first_gram,
                ImageVectors::Folded,
                limit,
            )),
        }
    }

    /// The plan of an analysis whose routes are decided: how many of the finest levels are sketched, and how image
    /// appearance vectors are held. Within `limit`, images are kept where that saves reading them again.
    pub fn decided(
        sizes: &Sizes<'_>,
        sketched: usize,
        image_vectors: ImageVectors,
        limit: u64,
    ) -> Self {
        let route = |level| match level < sketched {
            true => Route::Sketch,
            false => Route::Gram,
        };
        let room_for_images = || sizes.levels_bytes(sketched, ImageVectors::Folded, true) <= limit;
        let keep_images = sizes.must_keep(sketched) || sketched > 0 && room_for_images();
        Self {
            routes: (0..sizes.grids.len()).map(route).collect(),
            image_vectors,
            keep_images,
            bytes: sizes.levels_bytes(sketched, image_vectors, keep_images),
        }
    }

    /// Bytes that a part of the analysis expects to take at most: its image appearance vectors, or its images' dot
    /// products, both written as they are made.
    pub fn part_bytes(&self, sizes: &Sizes<'_>) -> u64 {
        let own = match sizes.representatives < sizes.images {
            true => self.image_vectors.reading_bytes(sizes.image_components),
            false => sizes.covariances(self.sketched()),
        };
        own.saturating_add(sizes.factor_bytes)
            .saturating_add(MARGIN)
    }
}

fn too_small(sizes: &Sizes<'_>, limit: u64) -> Error {
    let least = (0..=sizes.grids.len())
        .map(|first_gram| sizes.least_bytes(first_gram))
        .min()
        .unwrap_or(0);
    Error::option(
        "memory",
        format!(
            "{}, too little for this sample and these options",
            ByteSize(limit)
        ),
        format!(
            "at least {}, or fewer --images or --textons",
            ByteSize(least)
        ),
    )
}

impl Sizes<'_> {
    /// Numbers of an appearance vector.
    fn components(&self) -> u64 {
        (self.planes() * FILTERS) as u64
    }

    /// Planes that appearance vectors are made of.
    fn planes(&self) -> usize {
        self.eigenplanes
            .unwrap_or(self.representatives * self.channels)
    }

    /// Bytes of the representatives' planes at all levels.
    fn kept_bytes(&self) -> u64 {
        let texels: u64 = self.grids.iter().map(|grid| grid.len() as u64).sum();
        4 * self.planes() as u64 * texels
    }

    /// Whether the representatives must stay in memory so that no image is read more than three
    /// times: to choose them is one, and a sketch takes three passes over them.
    fn must_keep(&self, first_gram: usize) -> bool {
        first_gram > 0 && self.representatives < self.images && self.eigenplanes.is_none()
    }

    /// The least memory that does when levels from `first_gram` on take the Gram route.
    fn least_bytes(&self, first_gram: usize) -> u64 {
        let keep = self.must_keep(first_gram);
        self.levels_bytes(first_gram, ImageVectors::Folded, keep)
    }

    /// The largest of the phases when levels from `first_gram` on take the Gram route.
    fn levels_bytes(&self, first_gram: usize, images: ImageVectors, keep: bool) -> u64 {
        let kept = if keep { self.kept_bytes() } else { 0 };
        let filters: u64 = self
            .grids
            .iter()
            .map(|&grid| FftFilters::bytes(grid, FILTERS))
            .sum();
        let choosing = if self.representatives < self.images {
            images.bytes(self.images, self.image_components)
        } else {
            0
        };
        let phases = [
            choosing,
            self.clustering(first_gram).saturating_add(kept),
            self.centring().saturating_add(kept),
        ];
        let largest = phases.into_iter().max().unwrap_or(0);
        let held = filters.saturating_add(self.factor_bytes);
        largest.saturating_add(held).saturating_add(MARGIN)
    }

    fn clustering(&self, first_gram: usize) -> u64 {
        let (sketched, gram) = self.grids.split_at(first_gram);
        let covariances = self.covariances(first_gram);
        // Beside the sums so far, those of the block under way.
        let of_blocks = covariances * self.blocks.min(2) as u64;
        let working = gram.first().map_or(0, |grid| {
            let sums = 8 * (grid.len() * self.textons[first_gram]) as u64;
            let transfer = 16 * (FILTERS * grid.len()) as u64;
            transfer + (texel_gram::bytes(grid.len()) / 2).max(sums)
        });
        let sketches: u64 = sketched
            .iter()
            .map(|grid| {
                let numbers = 2 * grid.len() as u64 + 2 * self.components();
                4 * COORDINATES as u64 * numbers
            })
            .sum();
        let batch = if sketched.is_empty() { 0 } else { 256 << 20 };
        // The sketched levels are done before the others' matrices are made.
        let clustering = covariances + working.max(sketches + batch);
        clustering.max(of_blocks + sketches)
    }

    /// Bytes of the images' dot products on the levels from `first_gram` on.
    fn covariances(&self, first_gram: usize) -> u64 {
        let gram = self.grids.iter().skip(first_gram);
        gram.map(|grid| texel_gram::bytes(grid.len()) / 2).sum()
    }

    fn centring(&self) -> u64 {
        let textons: u64 = self.textons.iter().map(|&n| n as u64).sum();
        4 * textons * self.components()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plan(side: u32, images: usize, limit: Option<u64>) -> Result<Plan> {
        let mut grids = vec![TexelGrid {
            width: side,
            height: side,
            tileable: true,
        }];
        for _ in 1..4 {
            grids.push(grids[grids.len() - 1].coarser());
        }
        let sizes = Sizes {
            grids: &grids,
            textons: vec![400, 100, 25, 6],
            channels: 3,
            images,
            representatives: 400,
            eigenplanes: None,
            blocks: 1,
            factor_bytes: 0,
            image_components: 9216,
        };
        Plan::new(&sizes, limit.map(ByteSize))
    }

    #[test]
    fn what_fits_is_exact() {
        let free = plan(512, 22_801, None).unwrap();
        assert_eq!(
            (free.routes[0], free.image_vectors),
            (Route::Gram, ImageVectors::Exact)
        );
        let small = plan(64, 3600, Some(2 << 30)).unwrap();
        assert_eq!(
            (small.routes, small.image_vectors),
            (vec![Route::Gram; 4], ImageVectors::Exact)
        );
        assert_eq!(
            plan(128, 3600, Some(4 << 30)).unwrap().routes,
            [Route::Gram; 4]
        );
    }

    #[test]
    fn what_does_not_fit_is_sketched_or_refused() {
        let large = plan(256, 22_801, Some(3 << 30)).unwrap();
        assert_eq!(large.routes[0], Route::Sketch);
        assert!(large.bytes <= 3 << 30);
        assert!(
            large.keep_images,
            "else the representatives are read four times"
        );
        let error = plan(256, 22_801, Some(200 << 20)).unwrap_err().to_string();
        assert!(
            error.contains("--memory") && error.contains("at least"),
            "{error}"
        );
    }
}
