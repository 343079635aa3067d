//! The representative images, panel by panel: the way from the sample to every stage.
//!
//! In: an image stack and the numbers of the chosen images, or the planes that stand for them. Out: pass
//! after pass, for each panel its planes at every level. A panel bounds the memory; where there is memory
//! for all planes they are read once and kept.

use std::ops::Range;

use crate::error::Result;
use crate::progress::Progress;
use crate::texton::eigenplanes::Eigenplanes;
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
    fn count(self) -> usize {
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
}

/// The chosen images of a stack.
pub struct Panels<'a> {
    stack: &'a ImageStack<'a>,
    source: PlaneSource<'a>,
    /// Planes of every panel at every level, once read, where they are to be kept.
    kept: Option<Vec<Vec<Vec<f32>>>>,
    /// How often the planes were made.
    passes: u32,
}

impl<'a> Panels<'a> {
    /// Nothing read yet; `keep` the planes once they are.
    pub fn new(stack: &'a ImageStack<'a>, source: PlaneSource<'a>, keep: bool) -> Self {
        Self {
            stack,
            source,
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

    /// Hands every panel to `take`: its first plane's number, and for each level the planes, one
    /// after another.
    pub fn each(
        &mut self,
        stage: &str,
        progress: Progress<'_>,
        mut take: impl FnMut(usize, &[Vec<f32>]),
    ) -> Result<()> {
        let channels = self.source.channels(self.stack);
        let panel = self.stack.panel_of(channels);
        let read_before = self.kept.as_ref().is_some_and(|kept| !kept.is_empty());
        self.passes += u32::from(!read_before);
        let count = self.source.count();
        progress.begin(stage, count as u64);
        for (at, start) in (0..count).step_by(panel).enumerate() {
            let (range, first) = (start..count.min(start + panel), start * channels);
            match &mut self.kept {
                Some(kept) if read_before => take(first, &kept[at]),
                kept => {
                    let planes = self.source.read(self.stack, range.clone())?;
                    take(first, &planes);
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
}
