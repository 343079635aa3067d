//! The reference metric: distances through the Gram matrix Φ in double precision, as Tong 2002 §5.1
//! has them. With a sample s = Σ wᵢ tᵢ, ‖s − tⱼ‖² = Σᵢₖ wᵢ wₖ Φᵢₖ − 2 Σᵢ wᵢ Φᵢⱼ + Φⱼⱼ.

use ndarray::Array2;

use crate::synthesis::candidates::Candidate;
use crate::synthesis::choice::{Pick, Preference, smallest};
use crate::synthesis::exemplar_level::ExemplarLevel;
use crate::synthesis::metric::Metric;
use crate::synthesis::site_samples::{Held, SampledSites, SiteNeighborhood};

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
    to_textons: Vec<f64>,
}

/// One sample that counts: a surface texton.
#[derive(Clone, Copy, Debug)]
struct BlendedTexton {
    /// Where a texel's window holds the same sample.
    delta: u32,
    /// The sample's weight in the distance.
    weight: f64,
    textons: [u32; 3],
    blend: [f64; 3],
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

    /// The distances of a pattern to every whole texel, in their order.
    pub fn distances_to_all(&self, pattern: &mut GramPattern) -> Vec<f64> {
        let texels = &self.exemplar.whole_texels;
        let mut distances = vec![0.0; texels.len()];
        let windows = &self.exemplar.fine;
        let mut table = std::mem::take(&mut pattern.to_textons);
        tabulate(&mut table, &pattern.fine, self.fine);
        let textons = self.fine.nrows();
        for (sum, &texel) in distances.iter_mut().zip(texels) {
            *sum = tabulated(&table, textons, &pattern.fine, windows.window(texel));
        }
        if let (Some(coarse), Some(gram)) = (&self.exemplar.coarse, self.coarse) {
            tabulate(&mut table, &pattern.coarse, gram);
            for (sum, &texel) in distances.iter_mut().zip(texels) {
                let window = coarse.windows.window(coarse.parents[texel as usize]);
                *sum += tabulated(&table, gram.nrows(), &pattern.coarse, window);
            }
        }
        pattern.to_textons = table;
        distances
    }
}

/// Weighted distances of every sample to every texton.
fn tabulate(table: &mut Vec<f64>, samples: &[BlendedTexton], gram: &Array2<f32>) {
    table.clear();
    for sample in samples {
        let textons = 0..gram.nrows() as u32;
        table.extend(textons.map(|texton| sample.distance(gram, texton)));
    }
}

fn tabulated(table: &[f64], textons: usize, samples: &[BlendedTexton], window: &[u32]) -> f64 {
    let rows = table.chunks_exact(textons).zip(samples);
    rows.map(|(row, sample)| row[window[sample.delta as usize] as usize])
        .sum()
}

impl BlendedTexton {
    fn new(gram: &Array2<f32>, delta: u32, weight: f32, held: Held) -> Self {
        let (textons, blend) = match held {
            Held::Default => ([gram.nrows() as u32 - 1; 3], [1.0, 0.0, 0.0]),
            Held::One(texton) => ([texton; 3], [1.0, 0.0, 0.0]),
            Held::Blend(textons, blend) => (textons, blend.map(f64::from)),
        };
        // Three weights in single precision sum to 1 but for their rounding.
        let sum: f64 = blend.iter().sum();
        let blend = blend.map(|weight| weight / sum);
        let mut square = 0.0;
        for (&i, wi) in textons.iter().zip(blend) {
            for (&k, wk) in textons.iter().zip(blend) {
                square += wi * wk * f64::from(gram[(i as usize, k as usize)]);
            }
        }
        Self {
            delta,
            weight: f64::from(weight),
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
        for (&i, weight) in self.textons.iter().zip(self.blend) {
            dot += weight * f64::from(row[i as usize]);
        }
        let own = f64::from(row[texton as usize]);
        self.weight * (self.square - 2.0 * dot + own).max(0.0)
    }
}

fn read(
    samples: &mut Vec<BlendedTexton>,
    sites: &SampledSites<'_>,
    site: usize,
    gram: &Array2<f32>,
    deltas: &[u32],
    weights: &[f32],
) {
    samples.clear();
    samples.extend(
        sites
            .of_site(site)
            .map(|(place, held)| BlendedTexton::new(gram, deltas[place], weights[place], held)),
    );
}

impl Metric for GramMetric<'_> {
    type Pattern = GramPattern;

    fn read(&self, site: &SiteNeighborhood<'_>, pattern: &mut GramPattern) {
        let neighborhood = self.exemplar.neighborhood;
        let deltas = self.exemplar.fine.deltas();
        let (samples, weights) = (&mut pattern.fine, &neighborhood.weights);
        read(samples, &site.fine, site.site, self.fine, deltas, weights);
        pattern.coarse.clear();
        let coarse = (site.coarse, self.coarse, &self.exemplar.coarse);
        if let (Some(sites), Some(gram), Some(coarse)) = coarse {
            let deltas = coarse.windows.deltas();
            let (samples, weights) = (&mut pattern.coarse, &neighborhood.coarse_weights);
            read(samples, &sites, site.site, gram, deltas, weights);
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

    fn best_of_all(
        &self,
        pattern: &mut GramPattern,
        coherent: &[Candidate],
        preference: Preference,
    ) -> Option<Pick> {
        let Preference { coherence, noise } = preference;
        let mut best = smallest(coherent, None, noise, |texel, limit| {
            self.distance(pattern, texel, limit)
        });
        let distances = self.distances_to_all(pattern);
        for (&texel, distance) in self.exemplar.whole_texels.iter().zip(distances) {
            let pick = Pick::new(texel, distance, coherence, noise);
            if best.is_none_or(|best| pick.beats(&best)) {
                best = Some(pick);
            }
        }
        best
    }
}
