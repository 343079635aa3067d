//! The metric of features: the neighbourhoods of plain images, a line of a window as one run of numbers.
//!
//! A plain image has a short vector per texel, three numbers of colour mostly. They are kept side by side
//! as the texels are, on an image with a border as wide as the windows reach, so that a line of a
//! window is a run of numbers: of 7 texels in colour two blocks of lanes, where one block per texel would be
//! seven, mostly empty. A site's pattern has the same blocks, and a weight for each number, 0 where none
//! belongs to a sample that counts. Sums run over fixed lanes in fixed order: the same distances
//! everywhere.

use std::ops::Range;

use bytemuck::{Pod, Zeroable};
use macro_rules_attribute::apply;

use crate::exemplar::embedding::Embedding;
use crate::exemplar::level::ExemplarLevel;
use crate::exemplar::windows::Windows;
use crate::lanes::{LANES, LaneBlock, sum_of_lanes, vectorized};
use crate::sites::level::Sites;
use crate::synthesis::metric::lower_bounds::ProjectedWindows;
use crate::synthesis::metric::site_values::{SampleValue, SiteNeighborhood};
use crate::synthesis::metric::window_metric::WindowMetric;

/// Numbers of a vector that are copied at once.
const STEP: usize = 4;
/// Pairs of blocks after which a growing distance is compared with the best so far: the windows of an
/// image in colour have fewer, and are sooner compared whole than a branch is guessed wrong.
const RUN: usize = 8;

/// The metric of one level of a plain image.
#[derive(Debug)]
pub struct FeatureMetric<'a> {
    exemplar: &'a ExemplarLevel<'a>,
    fine: BorderedImage,
    coarse: Option<BorderedImage>,
    /// Where the numbers of each texel's windows begin, of the fine one and the coarse one.
    corners: Vec<[u32; 2]>,
    projected: Option<ProjectedWindows>,
}

/// A level's image, and how a window lies in it.
#[derive(Debug)]
struct BorderedImage {
    /// Steps a vector.
    steps: usize,
    /// The vector of every feature row, filled up to whole steps; the default's last.
    vectors: Vec<[f32; STEP]>,
    /// The bordered image, `depth` numbers per texel.
    numbers: Vec<f32>,
    depth: usize,
    /// Where a window's blocks begin, behind its first number; two and two, which are summed apart.
    blocks: Vec<[u32; 2]>,
    /// Where each sample's numbers begin among those of the blocks.
    places: Vec<u32>,
    /// The weight of every number of the blocks; 0 of those behind the end of a line.
    weights: Vec<Pair>,
}

/// A pair of blocks, aligned as processors load them fastest.
#[repr(C, align(64))]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
struct Pair([LaneBlock; 2]);

/// What a site's neighbourhood holds, on its own level and on the coarser one.
#[derive(Clone, Debug, Default)]
pub struct FeaturePattern {
    fine: PatternPart,
    coarse: PatternPart,
    /// Whether every sample of both windows counts.
    complete: bool,
}

/// The samples of one window.
#[derive(Clone, Debug, Default)]
struct PatternPart {
    /// The numbers of the blocks, and a pair more.
    values: Vec<Pair>,
    /// What each weighs, where some samples hold nothing; empty for the weights of the whole window.
    weights: Vec<Pair>,
}

impl<'a> FeatureMetric<'a> {
    /// The metric of a level from its vectors. `coarse` are the parent level's where two levels are
    /// compared.
    pub fn new(
        exemplar: &'a ExemplarLevel<'a>,
        fine: &Embedding,
        coarse: Option<&Embedding>,
    ) -> Self {
        let neighborhood = exemplar.neighborhood;
        let coarse = coarse.zip(exemplar.coarse.as_ref());
        Self {
            exemplar,
            fine: BorderedImage::new(fine, &exemplar.fine, &neighborhood.weights),
            coarse: coarse.map(|(embedding, coarse)| {
                BorderedImage::new(embedding, &coarse.windows, &neighborhood.coarse_weights)
            }),
            corners: corners(exemplar, fine.dimensions),
            projected: None,
        }
    }

    /// Prepares the bounds that spare a search most of its distances, with finer ones for a full search.
    #[must_use]
    pub fn with_projected_windows(mut self, draw: (u64, u32), searches_all: bool) -> Self {
        let texels = &self.exemplar.whole_texels;
        let images = std::iter::once(&self.fine).chain(&self.coarse);
        let weights = images.map(|bordered| &bordered.weights[..]);
        let weights: Vec<f32> = bytemuck::pod_collect_to_vec(&weights.collect::<Vec<_>>().concat());
        let window = |texel: u32, numbers: &mut Vec<f32>| {
            let mut pattern = FeaturePattern::default();
            self.pattern_of_texel(texel, &mut pattern);
            let parts = pattern.parts().into_iter();
            parts.for_each(|part| numbers.extend(part));
        };
        let projected = ProjectedWindows::new(weights, texels, window, draw, searches_all);
        self.projected = Some(projected);
        self
    }

    /// The pattern a texel's own window would be.
    pub fn pattern_of_texel(&self, texel: u32, pattern: &mut FeaturePattern) {
        let corners = self.corners[texel as usize];
        self.fine.read_window(corners[0], &mut pattern.fine);
        if let Some(coarse) = &self.coarse {
            coarse.read_window(corners[1], &mut pattern.coarse);
        }
    }
}

/// Where the numbers of each texel's windows begin on the bordered images, `depth` numbers per texel.
fn corners(exemplar: &ExemplarLevel<'_>, depth: usize) -> Vec<[u32; 2]> {
    let begins = |texel: u32| {
        let coarse = exemplar.coarse.as_ref().map_or(0, |coarse| {
            coarse.windows.corner(coarse.parents[texel as usize])
        });
        [exemplar.fine.corner(texel), coarse].map(|corner| (corner * depth) as u32)
    };
    (0..exemplar.grid.len() as u32).map(begins).collect()
}

impl FeaturePattern {
    /// All numbers of the blocks, the fine window's first.
    fn parts(&self) -> [&[f32]; 2] {
        let counted = [&self.fine, &self.coarse].map(|part| match &part.values[..] {
            [] => &[],
            [counted @ .., _] => counted,
        });
        counted.map(bytemuck::cast_slice)
    }
}

impl BorderedImage {
    fn new(embedding: &Embedding, windows: &Windows, weights: &[f32]) -> Self {
        let depth = embedding.dimensions;
        let vector = |row: usize| -> Vec<f32> {
            let blocks = (0..embedding.blocks).map(|block| embedding.plane(block)[row]);
            blocks.flatten().take(depth).collect()
        };
        let vectors: Vec<Vec<f32>> = (0..embedding.rows).map(vector).collect();
        let image = windows.rows().iter().map(|&row| &vectors[row as usize]);
        let mut numbers: Vec<f32> = image.flatten().copied().collect();
        // The last window's last block may reach beyond the image.
        numbers.resize(numbers.len() + LANES, 0.0);
        let steps = depth.div_ceil(STEP);
        let filled_up = vectors.into_iter().flat_map(|mut vector| {
            vector.resize(steps * STEP, 0.0);
            vector.as_chunks().0.to_vec()
        });
        let mut bordered = Self {
            steps,
            vectors: filled_up.collect(),
            numbers,
            depth,
            blocks: Vec::new(),
            places: Vec::new(),
            weights: Vec::new(),
        };
        let (mut before, mut laid) = (None, Vec::new());
        for (&delta, &weight) in windows.deltas().iter().zip(weights) {
            bordered.lay_sample(delta, weight, before == Some(delta), &mut laid);
            before = Some(delta + 1);
        }
        // The second block of the last pair may be none: it weighs nothing.
        laid.resize(2 * LANES * bordered.blocks.len(), 0.0);
        bordered.weights = bytemuck::pod_collect_to_vec(&laid);
        bordered
    }

    /// Finds place for a sample's numbers, whose weights are laid there: behind the last one's if it
    /// continues its line, else in new blocks.
    fn lay_sample(&mut self, delta: u32, weight: f32, continues: bool, laid: &mut Vec<f32>) {
        let begin = (delta as usize * self.depth) as u32;
        let place = match self.places.last() {
            Some(&last) if continues => last as usize + self.depth,
            _ => laid.len(),
        };
        self.places.push(place as u32);
        while laid.len() < place + self.depth {
            let block = begin + (laid.len() - place) as u32;
            match self.blocks.last_mut() {
                Some(pair) if !laid.len().is_multiple_of(2 * LANES) => pair[1] = block,
                _ => self.blocks.push([block; 2]),
            }
            laid.resize(laid.len() + LANES, 0.0);
        }
        laid[place..][..self.depth].fill(weight);
    }

    /// Reads the window that begins at a number of the bordered image.
    fn read_window(&self, corner: u32, part: &mut PatternPart) {
        let window = &self.numbers[corner as usize..];
        part.weights.clear();
        part.values.resize(self.weights.len() + 1, Pair::zeroed());
        for (values, begins) in part.values.iter_mut().zip(&self.blocks) {
            for (values, &begin) in values.0.iter_mut().zip(begins) {
                values.copy_from_slice(&window[begin as usize..][..LANES]);
            }
        }
    }

    /// Reads what the samples of a site's window hold, in their order; those that hold nothing weigh nothing.
    #[inline(always)]
    fn read<const N: usize>(
        &self,
        samples: impl Iterator<Item = Option<SampleValue<N>>>,
        part: &mut PatternPart,
    ) {
        part.weights.clear();
        // The last sample's last step may reach beyond the last block.
        part.values.resize(self.weights.len() + 1, Pair::zeroed());
        let default = self.vectors.len() / self.steps - 1;
        let values: &mut [f32] = bytemuck::cast_slice_mut(&mut part.values);
        for (value, &place) in samples.zip(&self.places) {
            let place = place as usize;
            let values = &mut values[place..][..self.steps * STEP];
            match value {
                None => self.leave_out(place, &mut part.weights),
                Some(SampleValue::Default) => self.copy(default, values),
                Some(SampleValue::One(row)) => self.copy(row as usize, values),
                Some(SampleValue::Blend(rows, blend)) => self.blend(rows, blend, values),
            }
        }
    }

    /// Lets the sample at a place weigh nothing.
    fn leave_out(&self, place: usize, weights: &mut Vec<Pair>) {
        if weights.is_empty() {
            weights.clone_from(&self.weights);
        }
        let weights: &mut [f32] = bytemuck::cast_slice_mut(weights);
        weights[place..][..self.depth].fill(0.0);
    }

    /// The vector of a feature row. What fills it up is overwritten by the next sample, or weighs nothing.
    #[inline(always)]
    fn copy(&self, row: usize, values: &mut [f32]) {
        let vector = &self.vectors[row * self.steps..][..self.steps];
        for (values, vector) in values.as_chunks_mut().0.iter_mut().zip(vector) {
            *values = *vector;
        }
    }

    #[inline(always)]
    fn blend<const N: usize>(&self, rows: [u32; N], blend: [f32; N], values: &mut [f32]) {
        let vector = |row: u32| &self.vectors[row as usize * self.steps..][..self.steps];
        let vectors = rows.map(vector);
        for (step, values) in values.as_chunks_mut::<STEP>().0.iter_mut().enumerate() {
            for at in 0..STEP {
                let mut sum = blend[0] * vectors[0][step][at];
                for of in 1..N {
                    sum += blend[of] * vectors[of][step][at];
                }
                values[at] = sum;
            }
        }
    }

    /// Adds to `sums` what some pairs of blocks are apart from the window that begins at a number of the
    /// bordered image.
    #[inline(always)]
    fn add_squares(
        &self,
        part: &PatternPart,
        pairs: Range<usize>,
        corner: u32,
        sums: &mut [LaneBlock; 2],
    ) {
        let numbers = &self.numbers[corner as usize..];
        let pattern = part.values[pairs.clone()].iter();
        let weights = match part.weights.is_empty() {
            true => &self.weights,
            false => &part.weights,
        };
        let pattern = pattern.zip(&weights[pairs.clone()]);
        for (begins, (Pair(value), Pair(weight))) in self.blocks[pairs].iter().zip(pattern) {
            for half in 0..2 {
                let window = &numbers[begins[half] as usize..][..LANES];
                for lane in 0..LANES {
                    let apart = value[half][lane] - window[lane];
                    sums[half][lane] += weight[half][lane] * (apart * apart);
                }
            }
        }
    }
}

/// The sum of both blocks.
#[inline(always)]
fn sum_of_both(sums: &[LaneBlock; 2]) -> f32 {
    let mut both = [0.0; LANES];
    for lane in 0..LANES {
        both[lane] = sums[0][lane] + sums[1][lane];
    }
    sum_of_lanes(both)
}

impl WindowMetric for FeatureMetric<'_> {
    type Pattern = FeaturePattern;

    const BOUNDS_CANDIDATES: bool = true;

    /// The distance, or infinity once it exceeds `limit`; both windows are summed together.
    #[inline(always)]
    fn distance_inline(&self, pattern: &FeaturePattern, texel: u32, limit: f32) -> f32 {
        let corners = self.corners[texel as usize];
        let mut sums = [[0.0; LANES]; 2];
        if let Some(coarse) = &self.coarse {
            let pairs = 0..coarse.blocks.len();
            coarse.add_squares(&pattern.coarse, pairs, corners[1], &mut sums);
        }
        let (mut done, all) = (0, self.fine.blocks.len());
        loop {
            let pairs = done..(done + RUN).min(all);
            done = pairs.end;
            self.fine
                .add_squares(&pattern.fine, pairs, corners[0], &mut sums);
            let sum = sum_of_both(&sums);
            if sum > limit {
                return f32::INFINITY;
            }
            if done == all {
                return sum;
            }
        }
    }

    fn parts(pattern: &FeaturePattern) -> [&[f32]; 2] {
        pattern.parts()
    }

    fn whole_texels(&self) -> &[u32] {
        &self.exemplar.whole_texels
    }

    fn bounds(&self, pattern: &FeaturePattern) -> Option<&ProjectedWindows> {
        self.projected.as_ref().filter(|_| pattern.complete)
    }

    fn read_windows<const N: usize, S: Sites<N>>(
        &self,
        site: &SiteNeighborhood<'_, S>,
        pattern: &mut FeaturePattern,
    ) {
        read_pattern(self, site, pattern);
    }
}

#[apply(vectorized!)]
fn read_pattern<const N: usize, S: Sites<N>>(
    metric: &FeatureMetric<'_>,
    site: &SiteNeighborhood<'_, S>,
    pattern: &mut FeaturePattern,
) {
    let own = site.sites.samples(site.site);
    metric
        .fine
        .read(own.map(|sample| site.value(sample)), &mut pattern.fine);
    if let Some(bordered) = &metric.coarse {
        bordered.read(site.parent().map(Some), &mut pattern.coarse);
    }
    pattern.complete = site.done.is_none();
}

#[cfg(test)]
mod tests;
