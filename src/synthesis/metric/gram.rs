//! The reference metric: distances through the Gram matrix Φ in double precision, as Tong 2002 §5.1
//! has them. With a sample s = Σ wᵢ tᵢ, ‖s − tⱼ‖² = Σᵢₖ wᵢ wₖ Φᵢₖ − 2 Σᵢ wᵢ Φᵢⱼ + Φⱼⱼ.

use ndarray::Array2;

use crate::exemplar::level::ExemplarLevel;
use crate::sites::level::{MOST_BLENDED, Sites};
use crate::synthesis::keep::Keep;
use crate::synthesis::metric::Metric;
use crate::synthesis::metric::site_values::{SampleValue, SiteNeighborhood};

/// The metric of one level.
#[derive(Clone, Copy, Debug)]
pub struct GramMetric<'a> {
    exemplar: &'a ExemplarLevel<'a>,
    fine: &'a Array2<f32>,
    coarse: Option<&'a Array2<f32>>,
}

/// What a site's neighbourhood holds, as textons and weights.
#[derive(Clone, Debug, Default)]
pub struct GramPattern {
    fine: Vec<BlendedTexton>,
    coarse: Vec<BlendedTexton>,
    /// Distances of every sample to every texton, [samples, textons], for a search of all texels.
    fine_table: Vec<f64>,
    coarse_table: Vec<f64>,
}

/// One sample that counts: a surface texton.
#[derive(Clone, Copy, Debug)]
struct BlendedTexton {
    /// Where a texel's window holds the same sample.
    delta: u32,
    /// The sample's weight in the distance.
    weight: f64,
    /// How many textons it blends, those and their weights.
    count: usize,
    textons: [u32; MOST_BLENDED],
    blend: [f64; MOST_BLENDED],
    /// Σᵢₖ wᵢ wₖ Φᵢₖ.
    square: f64,
}

impl<'a> GramMetric<'a> {
    /// The metric of a level, from its Φ; `coarse` is the parent level's where two levels are compared.
    pub fn new(
        exemplar: &'a ExemplarLevel<'a>,
        fine: &'a Array2<f32>,
        coarse: Option<&'a Array2<f32>>,
    ) -> Self {
        Self {
            exemplar,
            fine,
            coarse: coarse.filter(|_| exemplar.coarse.is_some()),
        }
    }

    /// The distances of a pattern to whole texels, each with its texel, in their order. A distance is infinite once it
    /// exceeds the limit that `visit` returned last; the first limit is `limit`.
    pub fn visit_all(
        &self,
        pattern: &mut GramPattern,
        mut limit: f64,
        mut visit: impl FnMut(u32, f64) -> f64,
    ) {
        let fine = Tabulated::new(&mut pattern.fine_table, &pattern.fine, self.fine);
        let coarse = match (&self.exemplar.coarse, self.coarse) {
            (Some(coarse), Some(gram)) => {
                let table = Tabulated::new(&mut pattern.coarse_table, &pattern.coarse, gram);
                Some((table, &coarse.windows, &coarse.parents))
            }
            _ => None,
        };
        for &texel in &self.exemplar.whole_texels {
            let mut distance = fine.distance(self.exemplar.fine.window(texel), limit);
            if let Some((coarse, windows, parents)) = &coarse
                && distance <= limit
            {
                let window = windows.window(parents[texel as usize]);
                distance += coarse.distance(window, limit);
            }
            limit = visit(texel, distance);
        }
    }
}

/// The weighted distances of some samples to every texton: a search of all texels only adds them up.
struct Tabulated<'a> {
    /// [samples, textons].
    distances: &'a [f64],
    textons: usize,
    samples: &'a [BlendedTexton],
}

impl<'a> Tabulated<'a> {
    fn new(table: &'a mut Vec<f64>, samples: &'a [BlendedTexton], gram: &Array2<f32>) -> Self {
        table.clear();
        for sample in samples {
            let textons = 0..gram.nrows() as u32;
            table.extend(textons.map(|texton| sample.distance(gram, texton)));
        }
        Self {
            distances: table,
            textons: gram.nrows(),
            samples,
        }
    }

    /// The distance to a window, or infinity once it exceeds `limit`.
    #[inline]
    fn distance(&self, window: &[u32], limit: f64) -> f64 {
        const BETWEEN_CHECKS: usize = 8;
        let rows = self.distances.chunks(BETWEEN_CHECKS * self.textons);
        let mut sum = 0.0;
        for (rows, samples) in rows.zip(self.samples.chunks(BETWEEN_CHECKS)) {
            for (row, sample) in rows.chunks_exact(self.textons).zip(samples) {
                sum += row[window[sample.delta as usize] as usize];
            }
            if sum > limit {
                return f64::INFINITY;
            }
        }
        sum
    }
}

impl BlendedTexton {
    fn new<const N: usize>(
        gram: &Array2<f32>,
        delta: u32,
        weight: f32,
        value: SampleValue<N>,
    ) -> Self {
        let (mut textons, mut blend) = ([0; MOST_BLENDED], [0.0; MOST_BLENDED]);
        let count = match value {
            SampleValue::Default => {
                (textons[0], blend[0]) = (gram.nrows() as u32 - 1, 1.0);
                1
            }
            SampleValue::One(texton) => {
                (textons[0], blend[0]) = (texton, 1.0);
                1
            }
            SampleValue::Blend(rows, weights) => {
                textons[..N].copy_from_slice(&rows);
                for (blend, weight) in blend.iter_mut().zip(weights) {
                    *blend = f64::from(weight);
                }
                N
            }
        };
        // Weights in single precision sum to 1 but for their rounding.
        let sum: f64 = blend.iter().sum();
        blend.iter_mut().for_each(|weight| *weight /= sum);
        let mut square = 0.0;
        for (&i, wi) in textons[..count].iter().zip(blend) {
            for (&k, wk) in textons[..count].iter().zip(blend) {
                square += wi * wk * f64::from(gram[(i as usize, k as usize)]);
            }
        }
        Self {
            delta,
            weight: f64::from(weight),
            count,
            textons,
            blend,
            square,
        }
    }

    /// The weighted squared distance to a texton.
    #[inline]
    fn distance(&self, gram: &Array2<f32>, texton: u32) -> f64 {
        let row = gram.row(texton as usize);
        let mut dot = 0.0;
        for (&i, weight) in self.textons[..self.count].iter().zip(self.blend) {
            dot += weight * f64::from(row[i as usize]);
        }
        let own = f64::from(row[texton as usize]);
        self.weight * (self.square - 2.0 * dot + own).max(0.0)
    }
}

impl Metric for GramMetric<'_> {
    type Pattern = GramPattern;

    fn read<const N: usize, S: Sites<N>>(
        &self,
        site: &SiteNeighborhood<'_, S>,
        pattern: &mut GramPattern,
    ) {
        let neighborhood = self.exemplar.neighborhood;
        let (deltas, weights) = (self.exemplar.fine.deltas(), &neighborhood.weights);
        pattern.fine.clear();
        let own = site.own().take_while(|&(place, _)| place < deltas.len());
        pattern.fine.extend(own.map(|(place, value)| {
            BlendedTexton::new(self.fine, deltas[place], weights[place], value)
        }));
        pattern.coarse.clear();
        if let (Some(gram), Some(coarse)) = (self.coarse, &self.exemplar.coarse) {
            let samples = coarse.windows.deltas().iter();
            let samples = samples.zip(&neighborhood.coarse_weights).zip(site.parent());
            pattern.coarse.extend(
                samples.map(|((&delta, &weight), value)| {
                    BlendedTexton::new(gram, delta, weight, value)
                }),
            );
        }
    }

    fn distance(&self, pattern: &GramPattern, texel: u32, limit: f64) -> f64 {
        let part = |samples: &[BlendedTexton], gram: &Array2<f32>, window: &[u32]| {
            let distances = samples.iter();
            distances
                .map(|sample| sample.distance(gram, window[sample.delta as usize]))
                .sum::<f64>()
        };
        let window = self.exemplar.fine.window(texel);
        let fine = part(&pattern.fine, self.fine, window);
        match (&self.exemplar.coarse, self.coarse) {
            (Some(coarse), Some(gram)) if fine <= limit => {
                let window = coarse.windows.window(coarse.parents[texel as usize]);
                fine + part(&pattern.coarse, gram, window)
            }
            (Some(_), Some(_)) => f64::INFINITY,
            _ => fine,
        }
    }

    fn search(&self, pattern: &mut GramPattern, keep: &mut impl Keep) {
        self.visit_all(pattern, keep.limit(), |texel, distance| {
            keep.offer(texel, distance);
            keep.limit()
        });
    }
}
