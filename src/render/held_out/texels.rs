//! The texels that are compared, and their values in every image.

use std::f32::consts::PI;
use std::ops::Range;

use rand::Rng;
use rayon::prelude::*;

use crate::btf::sample::{Pixels, Sample};
use crate::error::Result;
use crate::progress::Progress;
use crate::random;

/// Texels that are compared at most.
pub const MOST_TEXELS: usize = 256;
/// Runs of neighbouring texels that they are read in.
const RUNS: usize = 16;

/// The values of the compared texels, 1 for white facing the light.
pub(super) struct ComparedTexels {
    /// `[image][texel][colour]`.
    values: Vec<f32>,
    count: usize,
}

impl ComparedTexels {
    /// Reads the texels of every image.
    pub(super) fn read(sample: &Sample, seed: u64, progress: Progress<'_>) -> Result<Self> {
        let runs = runs(sample.grid().len(), seed);
        let count: usize = runs.iter().map(Range::len).sum();
        let images = sample.image_count();
        let mut values = vec![0.0; images * count * 3];
        progress.begin("reading images", images as u64);
        values
            .par_chunks_mut(count * 3)
            .enumerate()
            .try_for_each(|(image, mut out)| {
                let mut pixels = Pixels::of_type(sample.description().dtype);
                for run in &runs {
                    sample.read_texels(image, run.clone(), &mut pixels)?;
                    let (these, rest) = out.split_at_mut(3 * run.len());
                    pixels.copy_to(these);
                    sample.check_image(image, these)?;
                    these.iter_mut().for_each(|value| *value *= PI);
                    out = rest;
                }
                progress.advance(1)
            })?;
        progress.end();
        Ok(Self { values, count })
    }

    /// How many texels.
    pub(super) fn count(&self) -> usize {
        self.count
    }

    /// The values of an image: `[texel][colour]`.
    pub(super) fn of_image(&self, image: usize) -> &[f32] {
        &self.values[image * self.count * 3..][..self.count * 3]
    }
}

/// All texels, or runs of them in equal parts of the grid, each at a random place of its part.
fn runs(texels: usize, seed: u64) -> Vec<Range<usize>> {
    if texels <= MOST_TEXELS {
        return std::iter::once(0..texels).collect();
    }
    let length = MOST_TEXELS / RUNS;
    let mut stream = random::stream(seed, "held-out texels", 0, 0);
    let run = |part: usize| {
        let (from, to) = (part * texels / RUNS, (part + 1) * texels / RUNS);
        let first = stream.gen_range(from..=to - length);
        first..first + length
    };
    (0..RUNS).map(run).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_lie_apart_on_the_grid() {
        assert_eq!(runs(200, 0).first(), Some(&(0..200)));
        for texels in [257, 1000, 70_001] {
            let runs = runs(texels, 5);
            assert_eq!(runs.iter().map(Range::len).sum::<usize>(), MOST_TEXELS);
            assert!(runs.windows(2).all(|pair| pair[0].end <= pair[1].start));
            assert!(runs[RUNS - 1].end <= texels);
        }
    }
}
