//! The embedded metric: neighbourhoods as short dense vectors, a distance as one loop over lanes.
//!
//! A site's samples are blended once into its pattern; a texel's samples are read from the level's
//! table of feature vectors, which stays in the cache, so no neighbourhood is ever stored. Sums run
//! over fixed lanes in fixed order, whatever the processor: the same distances everywhere.

use macro_rules_attribute::apply;

use crate::exemplar::embedding::Embedding;
use crate::exemplar::level::ExemplarLevel;
use crate::lanes::{LANES, LaneBlock, sum_apart, vectorized};
use crate::sites::level::{MOST_BLENDED, Sites};
use crate::synthesis::metric::lower_bounds::ProjectedWindows;
use crate::synthesis::metric::site_values::{SampleValue, SiteNeighborhood};
use crate::synthesis::metric::window_metric::WindowMetric;

/// Samples after which a growing distance is compared with the best so far.
const RUN: u32 = 24;

/// The metric of one level.
#[derive(Debug)]
pub struct EmbeddedMetric<'a> {
    exemplar: &'a ExemplarLevel<'a>,
    fine: &'a Embedding,
    coarse: Option<&'a Embedding>,
    projected: Option<ProjectedWindows>,
}

/// What a site's neighbourhood holds, embedded.
#[derive(Clone, Debug, Default)]
pub struct EmbeddedPattern {
    /// Samples on the site's own level.
    fine: PatternPart,
    /// Samples on the coarser level.
    coarse: PatternPart,
    /// Whether every sample of the windows counts.
    complete: bool,
}

/// The samples of one window that count.
#[derive(Clone, Debug, Default)]
struct PatternPart {
    /// Their feature vectors: the first blocks of all samples, then their second ones, and so on.
    values: Vec<LaneBlock>,
    /// Where a texel's window holds the same samples.
    deltas: Vec<u32>,
    /// Where runs of samples of one weight end, and the weight.
    runs: Vec<(u32, f32)>,
    /// Feature rows that each sample blends, and their weights.
    blends: Vec<([u32; MOST_BLENDED], [f32; MOST_BLENDED])>,
}

impl<'a> EmbeddedMetric<'a> {
    /// The metric of a level. `coarse` is the parent level's embedding where two levels are compared.
    pub fn new(
        exemplar: &'a ExemplarLevel<'a>,
        fine: &'a Embedding,
        coarse: Option<&'a Embedding>,
    ) -> Self {
        Self {
            exemplar,
            fine,
            coarse: coarse.filter(|_| exemplar.coarse.is_some()),
            projected: None,
        }
    }

    /// Prepares the bounds that spare a full search most of its distances.
    #[must_use]
    pub fn with_projected_windows(mut self, seed: u64, level: u32) -> Self {
        let texels = &self.exemplar.whole_texels;
        let mut pattern = EmbeddedPattern::default();
        self.pattern_of_texel(texels[0], &mut pattern);
        let weights = [&pattern.fine, &pattern.coarse].map(PatternPart::number_weights);
        let window = |texel: u32, numbers: &mut Vec<f32>| {
            let mut pattern = EmbeddedPattern::default();
            self.pattern_of_texel(texel, &mut pattern);
            pattern
                .parts()
                .into_iter()
                .for_each(|part| numbers.extend(part));
        };
        let weights = weights.concat();
        let projected = ProjectedWindows::new(weights, texels, window, (seed, level), false);
        self.projected = Some(projected);
        self
    }

    /// The pattern a texel's own window would be.
    pub fn pattern_of_texel(&self, texel: u32, pattern: &mut EmbeddedPattern) {
        let neighborhood = self.exemplar.neighborhood;
        let (window, windows) = (self.exemplar.fine.window(texel), &self.exemplar.fine);
        let part = &mut pattern.fine;
        part.read_window(self.fine, window, windows.deltas(), &neighborhood.weights);
        pattern.coarse.clear();
        if let (Some(coarse), Some(embedding)) = (&self.exemplar.coarse, self.coarse) {
            let window = coarse.windows.window(coarse.parents[texel as usize]);
            let (part, weights) = (&mut pattern.coarse, &neighborhood.coarse_weights);
            part.read_window(embedding, window, coarse.windows.deltas(), weights);
        }
    }
}

impl EmbeddedPattern {
    /// All numbers, fine samples first.
    fn parts(&self) -> [&[f32]; 2] {
        [&self.fine, &self.coarse].map(|part| part.values.as_flattened())
    }
}

impl PatternPart {
    fn clear(&mut self) {
        self.values.clear();
        self.deltas.clear();
        self.runs.clear();
        self.blends.clear();
    }

    /// Counts one more sample, at `delta` in a texel's window.
    #[inline(always)]
    fn count(&mut self, delta: u32, weight: f32) {
        let begin = match self.runs.len() {
            0 | 1 => 0,
            runs => self.runs[runs - 2].0,
        };
        self.deltas.push(delta);
        let end = self.deltas.len() as u32;
        match self.runs.last_mut() {
            Some(run) if run.1 == weight && end - begin <= RUN => run.0 = end,
            _ => self.runs.push((end, weight)),
        }
    }

    /// Holds what a texel's window does.
    fn read_window(
        &mut self,
        embedding: &Embedding,
        window: &[u32],
        deltas: &[u32],
        weights: &[f32],
    ) {
        self.clear();
        for (&delta, &weight) in deltas.iter().zip(weights) {
            self.hold(SampleValue::<1>::One(window[delta as usize]), 0);
            self.count(delta, weight);
        }
        self.blend::<1>(embedding);
    }

    /// The weight of every number of [`values`](Self::values) in turn.
    fn number_weights(&self) -> Vec<f32> {
        let mut begin = 0;
        let samples = self.runs.iter().flat_map(move |&(end, weight)| {
            let run = std::mem::replace(&mut begin, end)..end;
            run.map(move |_| weight)
        });
        let blocks = samples.cycle().take(self.values.len());
        blocks.flat_map(|weight| [weight; LANES]).collect()
    }

    /// Notes which rows one more sample blends; every sample blends N of them.
    #[inline(always)]
    fn hold<const N: usize>(&mut self, value: SampleValue<N>, default: u32) {
        let (mut rows, mut blend) = ([default; MOST_BLENDED], [0.0; MOST_BLENDED]);
        blend[0] = 1.0;
        match value {
            SampleValue::Default => {}
            SampleValue::One(row) => rows = [row; MOST_BLENDED],
            SampleValue::Blend(several, weights) => {
                rows[..N].copy_from_slice(&several);
                blend[..N].copy_from_slice(&weights);
            }
        }
        self.blends.push((rows, blend));
    }

    /// Fills in the samples' vectors.
    #[inline(always)]
    fn blend<const N: usize>(&mut self, embedding: &Embedding) {
        for block in 0..embedding.blocks {
            let plane = embedding.plane(block);
            self.values.extend(self.blends.iter().map(|(rows, blend)| {
                let blocks: [&LaneBlock; N] = std::array::from_fn(|at| &plane[rows[at] as usize]);
                blended_block(blocks, blend)
            }));
        }
    }

    /// `sum` and the distance to a texel's window in some blocks of the vectors; infinity once they
    /// exceed `limit`.
    #[inline(always)]
    fn distance(
        &self,
        embedding: &Embedding,
        blocks: std::ops::Range<usize>,
        window: &[u32],
        mut sum: f32,
        limit: f32,
    ) -> f32 {
        let samples = self.deltas.len();
        for block in blocks {
            let (plane, values) = (embedding.plane(block), &self.values[block * samples..]);
            let mut begin = 0;
            for &(end, weight) in &self.runs {
                let end = end as usize;
                let (values, deltas) = (&values[begin..end], &self.deltas[begin..end]);
                sum += weight * run_distance(values, plane, window, deltas);
                if sum > limit {
                    return f32::INFINITY;
                }
                begin = end;
            }
        }
        sum
    }
}

#[inline(always)]
fn blended_block<const N: usize>(
    blocks: [&LaneBlock; N],
    blend: &[f32; MOST_BLENDED],
) -> LaneBlock {
    let mut block = [0.0; LANES];
    for lane in 0..LANES {
        let mut sum = blend[0] * blocks[0][lane];
        for at in 1..N {
            sum += blend[at] * blocks[at][lane];
        }
        block[lane] = sum;
    }
    block
}

/// Σ ‖value − vector‖² over a run of samples in one block, even and odd samples summed apart.
#[inline(always)]
fn run_distance(values: &[LaneBlock], plane: &[LaneBlock], window: &[u32], deltas: &[u32]) -> f32 {
    let (mut even, mut odd) = ([0.0; LANES], [0.0; LANES]);
    let vector = |delta: u32| &plane[window[delta as usize] as usize];
    for (values, deltas) in values.chunks(2).zip(deltas.chunks(2)) {
        add_squares(&mut even, &values[0], vector(deltas[0]));
        if let (Some(value), Some(&delta)) = (values.get(1), deltas.get(1)) {
            add_squares(&mut odd, value, vector(delta));
        }
    }
    for lane in 0..LANES {
        even[lane] += odd[lane];
    }
    sum_apart(&even)
}

#[inline(always)]
fn add_squares(sums: &mut LaneBlock, a: &LaneBlock, b: &LaneBlock) {
    for lane in 0..LANES {
        let difference = a[lane] - b[lane];
        sums[lane] += difference * difference;
    }
}

impl WindowMetric for EmbeddedMetric<'_> {
    type Pattern = EmbeddedPattern;

    /// A few distances are as fast as their bounds.
    const BOUNDS_CANDIDATES: bool = false;

    /// The distance, or infinity once it exceeds `limit`: the first blocks of the vectors, which say
    /// most, on both levels before the others.
    #[inline(always)]
    fn distance_inline(&self, pattern: &EmbeddedPattern, texel: u32, limit: f32) -> f32 {
        let window = self.exemplar.fine.window(texel);
        let part = &pattern.fine;
        let mut sum = part.distance(self.fine, 0..1, window, 0.0, limit);
        if let (Some(coarse), Some(embedding)) = (&self.exemplar.coarse, self.coarse)
            && sum <= limit
        {
            let parents = coarse.windows.window(coarse.parents[texel as usize]);
            let blocks = 0..embedding.blocks;
            sum = pattern
                .coarse
                .distance(embedding, blocks, parents, sum, limit);
        }
        if sum > limit {
            return sum;
        }
        part.distance(self.fine, 1..self.fine.blocks, window, sum, limit)
    }

    fn parts(pattern: &EmbeddedPattern) -> [&[f32]; 2] {
        pattern.parts()
    }

    fn whole_texels(&self) -> &[u32] {
        &self.exemplar.whole_texels
    }

    fn bounds(&self, pattern: &EmbeddedPattern) -> Option<&ProjectedWindows> {
        self.projected.as_ref().filter(|_| pattern.complete)
    }

    fn read_windows<const N: usize, S: Sites<N>>(
        &self,
        site: &SiteNeighborhood<'_, S>,
        pattern: &mut EmbeddedPattern,
    ) {
        read_pattern(self, site, pattern);
    }
}

#[apply(vectorized!)]
fn read_pattern<const N: usize, S: Sites<N>>(
    metric: &EmbeddedMetric<'_>,
    site: &SiteNeighborhood<'_, S>,
    pattern: &mut EmbeddedPattern,
) {
    let neighborhood = metric.exemplar.neighborhood;
    let (deltas, weights) = (metric.exemplar.fine.deltas(), &neighborhood.weights);
    let default = metric.fine.rows as u32 - 1;
    let part = &mut pattern.fine;
    part.clear();
    // A filtered iterator would be a function of its own, called for every sample.
    let samples = site.sites.samples(site.site).zip(deltas).zip(weights);
    for ((sample, &delta), &weight) in samples {
        if let Some(value) = site.value(sample) {
            part.hold(value, default);
            part.count(delta, weight);
        }
    }
    part.blend::<N>(metric.fine);
    pattern.coarse.clear();
    if let (Some(embedding), Some(coarse)) = (metric.coarse, &metric.exemplar.coarse) {
        let (part, default) = (&mut pattern.coarse, embedding.rows as u32 - 1);
        let samples = coarse.windows.deltas().iter();
        let samples = samples.zip(&neighborhood.coarse_weights).zip(site.parent());
        for ((&delta, &weight), value) in samples {
            part.hold(value, default);
            part.count(delta, weight);
        }
        part.blend::<N>(embedding);
    }
    pattern.complete = pattern.fine.deltas.len() == neighborhood.offsets.len();
}
