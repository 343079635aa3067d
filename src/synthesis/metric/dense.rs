//! The dense metric: neighbourhoods resampled at any positions, as one run of numbers.
//!
//! A site's pattern holds the blended features of its samples in the order of the template; a texel's window is
//! read from [`DenseWindows`]. Samples stored ring by ring make a smaller neighbourhood a prefix. On the square
//! template this is what [`FeatureMetric`](super::feature_metric::FeatureMetric) computes faster.

use crate::exemplar::dense_windows::{DenseWindows, flat_vectors};
use crate::exemplar::embedding::Embedding;
use crate::lanes::LANES;
use crate::sites::level::{SampleLocation, Sites};
use crate::synthesis::metric::site_values::{SampleValue, SiteNeighborhood};

/// The metric of one level.
#[derive(Debug)]
pub struct DenseMetric {
    windows: DenseWindows,
    dimensions: usize,
    /// The vectors of all feature rows.
    vectors: Vec<f32>,
}

/// What a site's neighbourhood holds.
#[derive(Clone, Debug, Default)]
pub struct DensePattern {
    /// The numbers of all samples; 0 for those that do not count.
    values: Vec<f32>,
    /// Which samples count: 1 or 0 for each.
    pub counts: Vec<f32>,
}

impl DenseMetric {
    /// The metric of a level from its resampled windows.
    pub fn new(windows: DenseWindows, embedding: &Embedding) -> Self {
        Self {
            dimensions: windows.dimensions,
            windows,
            vectors: flat_vectors(embedding),
        }
    }

    /// Reads what a site's samples hold. Those outside the surface do not count (Chen 2008 §4.3), nor do those
    /// that blend a site without a value.
    #[inline(always)]
    pub fn read<const N: usize, S: Sites<N>>(
        &self,
        site: &SiteNeighborhood<'_, S>,
        pattern: &mut DensePattern,
    ) {
        let samples = site.sites.samples_per_site();
        pattern.counts.clear();
        pattern.values.clear();
        pattern.values.resize(samples * self.dimensions, 0.0);
        let numbers = pattern.values.chunks_exact_mut(self.dimensions);
        for (location, numbers) in site.sites.samples(site.site).zip(numbers) {
            let value = match location {
                SampleLocation::Outside => None,
                _ => site.value(location),
            };
            pattern.counts.push(f32::from(u8::from(value.is_some())));
            match value {
                None | Some(SampleValue::Default) => {}
                Some(SampleValue::One(row)) => numbers.copy_from_slice(self.vector(row)),
                Some(SampleValue::Blend(rows, weights)) => {
                    for (row, weight) in rows.into_iter().zip(weights) {
                        for (number, value) in numbers.iter_mut().zip(self.vector(row)) {
                            *number += weight * value;
                        }
                    }
                }
            }
        }
    }

    #[inline(always)]
    fn vector(&self, row: u32) -> &[f32] {
        &self.vectors[row as usize * self.dimensions..][..self.dimensions]
    }

    /// The squared differences of every sample that counts, 0 for the others.
    #[inline(always)]
    pub fn differences(&self, pattern: &DensePattern, texel: u32, differences: &mut Vec<f32>) {
        let window = self.windows.window(texel).chunks_exact(self.dimensions);
        let values = pattern.values.chunks_exact(self.dimensions);
        differences.clear();
        let squares = values.zip(window).zip(&pattern.counts);
        differences.extend(squares.map(|((values, window), counts)| {
            let pairs = values.iter().zip(window);
            counts * pairs.map(|(a, b)| (a - b) * (a - b)).sum::<f32>()
        }));
    }

    /// The distance over all samples that count.
    #[inline(always)]
    pub fn distance(&self, pattern: &DensePattern, texel: u32) -> f32 {
        let window = self.windows.window(texel);
        let mut sums = [0.0; LANES];
        let dimensions = self.dimensions;
        let (values, value_rest) = pattern.values.as_chunks::<LANES>();
        let (numbers, number_rest) = window.as_chunks::<LANES>();
        if pattern.counts.iter().all(|&counts| counts == 1.0) {
            for (values, numbers) in values.iter().zip(numbers) {
                for lane in 0..LANES {
                    let apart = values[lane] - numbers[lane];
                    sums[lane] += apart * apart;
                }
            }
            // One lane after another: the tree of `sum_of_lanes` rounds differently, and would change maps.
            let rest = value_rest.iter().zip(number_rest);
            return sums.iter().sum::<f32>() + rest.map(|(a, b)| (a - b) * (a - b)).sum::<f32>();
        }
        let samples = pattern.values.chunks_exact(dimensions);
        let samples = samples
            .zip(window.chunks_exact(dimensions))
            .zip(&pattern.counts);
        samples
            .filter(|(_, counts)| **counts > 0.0)
            .map(|((a, b), _)| a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f32>())
            .sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exemplar::level::ExemplarLevel;
    use crate::exemplar::neighbor_table::build;
    use crate::exemplar::space::{Features, Space, SpaceLevel};
    use crate::exemplar::{Channels, KnnOptions};
    use crate::format::id::ContentId;
    use crate::grid::TexelGrid;
    use crate::neighborhood::Template;
    use crate::progress::Progress;
    use crate::random;
    use crate::synthesis::metric::Metric;
    use crate::synthesis::metric::feature_metric::{FeatureMetric, FeaturePattern};
    use crate::synthesis::metric::site_values::Unfinished;
    use crate::synthesis::tests::fixtures;
    use ndarray::Array3;
    use rand::Rng;

    #[test]
    fn on_the_square_template_it_is_the_metric_of_features() {
        let mut stream = random::stream(11, "picture", 0, 0);
        let grid = TexelGrid {
            width: 12,
            height: 10,
            tileable: true,
        };
        let features = Array3::from_shape_fn((10, 12, 3), |_| stream.gen_range(0.0..1.0));
        let space = Space {
            levels: vec![SpaceLevel {
                grid,
                features: Features::Plain(features),
            }],
            channels: Channels::default(),
            controls: Vec::new(),
            id: ContentId::of_bytes(b"space"),
            texel_mm: None,
            sample: ContentId::of_bytes(b"sample"),
        };
        let options = KnnOptions {
            k: 3,
            neighborhood: 5,
            ..KnnOptions::default()
        };
        let table = build(&space, &options, Progress::silent()).unwrap();
        let exemplar = ExemplarLevel::new(&space, &table, 0, 3, false);
        let embedding = Embedding::new(&space.levels[0], 1.0);
        let fast = FeatureMetric::new(&exemplar, &embedding, None);
        let windows = DenseWindows::new(&space.levels[0], &embedding, &Template::square(5));
        let dense = DenseMetric::new(windows, &embedding);
        let sites = fixtures::random_sites(3, 400, 6);
        let rows: Vec<u32> = (0..400).map(|_| stream.gen_range(0..120)).collect();
        let (mut of_fast, mut of_dense) = (FeaturePattern::default(), DensePattern::default());
        let mut compared = 0;
        for site in 0..400 {
            // Samples outside the surface hold the mean there, and do not count here.
            if sites
                .samples(site)
                .any(|sample| sample == SampleLocation::Outside)
            {
                continue;
            }
            compared += 1;
            let neighborhood = SiteNeighborhood {
                site,
                sites: &sites,
                rows: &rows,
                done: None,
                unfinished: Unfinished::LeftOut,
                coarser: None,
            };
            fast.read(&neighborhood, &mut of_fast);
            dense.read(&neighborhood, &mut of_dense);
            for texel in (0..120).step_by(7) {
                let expected = fast.distance(&of_fast, texel, f64::INFINITY) as f32;
                let found = dense.distance(&of_dense, texel);
                assert!(
                    (found - expected).abs() < 1e-4 * expected,
                    "{found} {expected}"
                );
                let mut apart = Vec::new();
                dense.differences(&of_dense, texel, &mut apart);
                let sum: f32 = apart.iter().sum();
                assert!((sum - expected).abs() < 1e-4 * expected, "{sum} {expected}");
            }
        }
        assert!(compared > 5, "{compared}");
    }
}
