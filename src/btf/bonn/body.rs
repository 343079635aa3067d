//! What the four formats have in common behind their headers: images that can be read in runs.

use std::ops::Range;

use crate::error::Result;

/// The images of a file.
pub(super) trait Body: Send + Sync {
    /// Fills `out` with a run of images, [images, texels, RGB], as the file's numbers have them.
    fn read(&self, images: Range<usize>, out: &mut [f32]) -> Result<()>;

    /// How many bytes of images are best read in one run.
    fn run_bytes(&self) -> usize {
        64 << 20
    }
}
