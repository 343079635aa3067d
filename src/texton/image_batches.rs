//! The representative images, batch by batch: the way from the sample to every stage.
//!
//! In: an image stack and the numbers of the chosen images, or the planes that stand for them. Out: pass
//! after pass, for each batch its planes at every level. A batch bounds the memory; where there is memory
//! for all planes they are read once and kept. No batch crosses the border of two blocks of images.

use std::ops::Range;

use crate::error::Result;
use crate::progress::Progress;
use crate::texton::eigenplanes::Eigenplanes;
use crate::texton::image_blocks::ImageBlocks;
use crate::texton::image_stack::ImageStack;

/// What gives the planes.
#[derive(Clone, Copy)]
pub enum PlaneSource<'a> {
    /// Images of the stack.
    Images(&'a [u32]),
    /// What stands for images of a factored sample.
    Eigenplanes(&'a Eigenplanes<'a>),
}

impl PlaneSource<'_> {
    /// Images or planes.
    pub fn count(self) -> usize {
        match self {
            Self::Images(images) => images.len(),
            Self::Eigenplanes(planes) => planes.count(),
        }
    }

    /// Planes of one image or plane.
    fn channels(self, stack: &ImageStack<'_>) -> usize {
        match self {
            Self::Images(_) => stack.channels.count(),
            Self::Eigenplanes(_) => 1,
        }
    }

    /// Planes of some images or planes, at every level.
    fn read(self, stack: &ImageStack<'_>, range: Range<usize>) -> Result<Vec<Vec<f32>>> {
        match self {
            Self::Images(images) => stack.read(&images[range]),
            Self::Eigenplanes(planes) => Ok(stack.pyramid(planes.planes(range))),
        }
    }

    /// Has the system fetch images that are read soon.
    fn announce(self, stack: &ImageStack<'_>, range: Range<usize>) {
        match self {
            Self::Images(images) => stack.announce(&images[range]),
            // Factors are in memory.
            Self::Eigenplanes(_) => {}
        }
    }
}

/// Some images that are read together.
pub struct ImageBatch<'p> {
    /// The number of the first plane.
    pub first: usize,
    /// For each level the planes, one after another.
    pub planes: &'p [Vec<f32>],
    /// Whether they are a whole block of images.
    pub is_block: bool,
    /// Whether a block of images ends here.
    pub ends_block: bool,
}

/// The chosen images of a stack.
pub struct ImageBatches<'a> {
    stack: &'a ImageStack<'a>,
    source: PlaneSource<'a>,
    blocks: ImageBlocks,
    /// Planes of every batch at every level, once read, where they are to be kept.
    kept: Option<Vec<Vec<Vec<f32>>>>,
    /// How often the planes were made.
    passes: u32,
}

impl<'a> ImageBatches<'a> {
    /// Nothing read yet, in `blocks`; `keep` the planes once they are.
    pub fn new(
        stack: &'a ImageStack<'a>,
        source: PlaneSource<'a>,
        blocks: ImageBlocks,
        keep: bool,
    ) -> Self {
        Self {
            stack,
            source,
            blocks,
            kept: keep.then(Vec::new),
            passes: 0,
        }
    }

    /// Planes in all.
    pub fn planes(&self) -> usize {
        self.source.count() * self.source.channels(self.stack)
    }

    /// How often the images were read so far.
    pub fn passes(&self) -> u32 {
        match self.source {
            PlaneSource::Images(_) => self.passes,
            PlaneSource::Eigenplanes(_) => 0,
        }
    }

    /// Hands every batch to `take`.
    pub fn each(
        &mut self,
        stage: &str,
        progress: Progress<'_>,
        mut take: impl FnMut(&ImageBatch<'_>),
    ) -> Result<()> {
        // Note whether the planes are read or at hand.
        let channels = self.source.channels(self.stack);
        let read_before = self.kept.as_ref().is_some_and(|kept| !kept.is_empty());
        self.passes += u32::from(!read_before);
        progress.begin(stage, self.source.count() as u64);
        // Hand batch after batch over.
        let mut after_block = true;
        let ranges = (0..self.blocks.count()).flat_map(|block| self.ranges_of(block));
        let mut ranges = ranges
            .collect::<Vec<_>>()
            .into_iter()
            .enumerate()
            .peekable();
        while let Some((at, (range, ends_block))) = ranges.next() {
            let first = range.start * channels;
            let begins_block = std::mem::replace(&mut after_block, ends_block);
            let mut hand_over = |planes: &[Vec<f32>]| {
                take(&ImageBatch {
                    first,
                    planes,
                    is_block: ends_block && begins_block,
                    ends_block,
                })
            };
            match &mut self.kept {
                Some(kept) if read_before => hand_over(&kept[at]),
                kept => {
                    if let Some((_, (next, _))) = ranges.peek() {
                        self.source.announce(self.stack, next.clone());
                    }
                    let planes = self.source.read(self.stack, range.clone())?;
                    hand_over(&planes);
                    if let Some(kept) = kept {
                        kept.push(planes);
                    }
                }
            }
            progress.advance(range.len() as u64)?;
        }
        progress.end();
        Ok(())
    }

    /// Hands the batches of one block to `take`: the planes of each at every level.
    pub fn each_of_block(
        &self,
        block: usize,
        progress: Progress<'_>,
        mut take: impl FnMut(&[Vec<f32>]),
    ) -> Result<()> {
        let mut ranges = self.ranges_of(block).peekable();
        while let Some((range, _)) = ranges.next() {
            if let Some((next, _)) = ranges.peek() {
                self.source.announce(self.stack, next.clone());
            }
            take(&self.source.read(self.stack, range.clone())?);
            progress.advance(range.len() as u64)?;
        }
        Ok(())
    }

    /// The images of every batch of a block, and whether it is the block's last.
    fn ranges_of(&self, block: usize) -> impl Iterator<Item = (Range<usize>, bool)> + use<> {
        let batch = self.stack.batch_of(self.source.channels(self.stack));
        let Range { start, end } = self.blocks.images(block);
        let starts = (start..end).step_by(batch);
        starts.map(move |first| (first..end.min(first + batch), first + batch >= end))
    }
}
