//! The representative images, panel by panel: the way from the sample to every stage.
//!
//! In: an image stack and the numbers of the chosen images. Out: pass after pass, for each panel of
//! images their planes at every level. A panel bounds the memory; where there is memory for all
//! planes they are read once and kept.

use crate::error::Result;
use crate::progress::Progress;
use crate::texton::image_stack::ImageStack;

/// The chosen images of a stack.
pub struct Panels<'a> {
    stack: &'a ImageStack<'a>,
    images: &'a [u32],
    /// Planes of every panel at every level, once read, where they are to be kept.
    kept: Option<Vec<Vec<Vec<f32>>>>,
    /// How often the images were read.
    passes: u32,
}

impl<'a> Panels<'a> {
    /// Nothing read yet; `keep` the planes once they are.
    pub fn new(stack: &'a ImageStack<'a>, images: &'a [u32], keep: bool) -> Self {
        Self {
            stack,
            images,
            kept: keep.then(Vec::new),
            passes: 0,
        }
    }

    /// Planes of all images.
    pub fn planes(&self) -> usize {
        self.images.len() * self.stack.channels.count()
    }

    /// How often the images were read so far.
    pub fn passes(&self) -> u32 {
        self.passes
    }

    /// Hands every panel to `take`: its first plane's number, and for each level the planes, one
    /// after another.
    pub fn each(
        &mut self,
        stage: &str,
        progress: Progress<'_>,
        mut take: impl FnMut(usize, &[Vec<f32>]),
    ) -> Result<()> {
        let (panel, channels) = (self.stack.panel(), self.stack.channels.count());
        let read_before = self.kept.as_ref().is_some_and(|kept| !kept.is_empty());
        self.passes += u32::from(!read_before);
        progress.begin(stage, self.images.len() as u64);
        for (at, images) in self.images.chunks(panel).enumerate() {
            let first = at * panel * channels;
            match &mut self.kept {
                Some(kept) if read_before => take(first, &kept[at]),
                kept => {
                    let planes = self.stack.read(images)?;
                    take(first, &planes);
                    if let Some(kept) = kept {
                        kept.push(planes);
                    }
                }
            }
            progress.advance(images.len() as u64)?;
        }
        progress.end();
        Ok(())
    }
}
