//! Blocks of images. Sums over all images of a sample run block by block, so that several runs can share
//! them: the last bits of a sum depend on the blocks, and these depend on the number of images alone.

use std::ops::Range;

/// Blocks at most: each adds a matrix of a level's dot products to the parts of a shared analysis.
const MOST: usize = 16;
/// Images of a block, where there are as many: fewer cost more to add up than to multiply.
const LEAST_IMAGES: usize = 8;

/// Consecutive images, cut into blocks of nearly equal length.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ImageBlocks {
    images: usize,
    count: usize,
}

impl ImageBlocks {
    /// The blocks of all images of a sample.
    pub fn of_all(images: usize) -> Self {
        let count = (images / LEAST_IMAGES).clamp(1, MOST);
        Self { images, count }
    }

    /// A single block, of images that one run takes.
    pub fn single(images: usize) -> Self {
        Self { images, count: 1 }
    }

    /// How many blocks there are.
    pub fn count(self) -> usize {
        self.count
    }

    /// The images of a block.
    pub fn images(self, block: usize) -> Range<usize> {
        let start = |block: usize| block * self.images / self.count;
        start(block)..start(block + 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_cover_all_images_once() {
        for (images, count) in [(1, 1), (15, 1), (16, 2), (60, 7), (3600, 16), (20_801, 16)] {
            let blocks = ImageBlocks::of_all(images);
            assert_eq!(blocks.count(), count);
            let all = (0..count).flat_map(|block| blocks.images(block));
            assert!(all.eq(0..images));
        }
        assert_eq!(ImageBlocks::single(100).images(0), 0..100);
    }
}
