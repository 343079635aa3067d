//! Images that are read again and again, in runs: what a factorization is made from.

use std::ops::Range;

use crate::btf::description::Description;
use crate::btf::height_map::HeightMap;
use crate::error::Result;

/// Images of one patch, never all in memory.
pub trait ImageSource: Sync {
    /// What the images show: grid, directions, pairs. Layout, number type, factors and id say nothing of
    /// the images' values.
    fn description(&self) -> &Description;

    /// How high the surface lies at every texel, where that is known.
    fn heights(&self) -> Result<Option<HeightMap>>;

    /// Reads a run of images, one after another, each row-major (height, width, RGB): linear radiance,
    /// finite. The same numbers come at every reading, at any number of threads.
    fn read_images(&self, images: Range<usize>, out: &mut [f32]) -> Result<()>;
}
