//! Neighbourhoods ring by ring: a smaller window is a prefix of a larger one, so that windows can grow with the
//! scale of the texture (Zhang 2003 §5.2).

use glam::Vec2;
use macro_rules_attribute::apply;

use crate::exemplar::dense_windows::{DenseFeatures, DenseWindows};
use crate::lanes::{LANES, sum_apart, vectorized};
use crate::neighborhood::{Template, square_window};
use crate::sites::level::Sites;
use crate::synthesis::metric::site_values::{SampleValue, SiteNeighborhood};

/// Numbers summed between two looks at the limit.
const RUN: usize = 128;
/// A sample that the windows do not reach.
const NOWHERE: u32 = u32::MAX;

/// The windows of a level in one kind of numbers.
#[derive(Clone, Debug)]
pub struct RingMetric {
    windows: DenseWindows,
    dimensions: usize,
    /// The vectors of all rows, the default's last.
    vectors: Vec<f32>,
    default: u32,
    /// By sample of the sites' square window: its place ring by ring.
    places: Vec<u32>,
}

/// What the samples of a site's neighbourhood hold.
#[derive(Clone, Debug, Default)]
pub struct RingPattern {
    values: Vec<f32>,
    /// Which samples count: 1 or 0 for each.
    counts: Vec<f32>,
    complete: bool,
}

/// The square window of odd width with its samples ring by ring, the centre first.
pub fn by_rings(width: u32) -> Template {
    let square = Template::square(width);
    let mut positions = square.positions;
    positions.sort_by_key(|at| at.abs().max_element() as u32);
    Template {
        positions,
        ring_ends: (0..=width as usize / 2)
            .map(|ring| samples_within(ring as u32))
            .collect(),
    }
}

/// Samples of the square window of this many rings.
pub fn samples_within(rings: u32) -> usize {
    (2 * rings as usize + 1).pow(2)
}

impl RingMetric {
    /// Resamples the windows of features, `width` wide. Sites have square windows `site_width` wide.
    pub fn new(
        features: DenseFeatures<'_>,
        width: u32,
        site_width: u32,
        turns: Option<&[Vec2]>,
    ) -> Self {
        let rings = width / 2;
        let ring = |[row, col]: &[i32; 2]| row.unsigned_abs().max(col.unsigned_abs());
        let site_window = square_window(site_width);
        let mut order: Vec<u32> = (0..site_window.len() as u32).collect();
        order.sort_by_key(|&sample| ring(&site_window[sample as usize]));
        let mut places = vec![NOWHERE; order.len()];
        for (place, &sample) in (0..).zip(&order) {
            if ring(&site_window[sample as usize]) <= rings {
                places[sample as usize] = place;
            }
        }
        Self {
            windows: DenseWindows::of_features(features, &by_rings(width), turns),
            dimensions: features.dimensions,
            vectors: features.vectors.to_vec(),
            default: features.default,
            places,
        }
    }

    /// Reads what the samples of a site hold, as far as `rings` rings; samples without a value do not count.
    #[inline(always)]
    pub fn read<const N: usize, S: Sites<N>>(
        &self,
        site: &SiteNeighborhood<'_, S>,
        rings: u32,
        pattern: &mut RingPattern,
    ) {
        let wanted = samples_within(rings);
        pattern.begin(wanted, self.dimensions);
        for (sample, &place) in site.sites.samples(site.site).zip(&self.places) {
            if (place as usize) < wanted {
                self.hold(place as usize, site.value(sample), pattern);
            }
        }
    }

    /// Reads what the samples round a site's parent point hold.
    #[inline(always)]
    pub fn read_parent<const N: usize, S: Sites<N>>(
        &self,
        site: &SiteNeighborhood<'_, S>,
        pattern: &mut RingPattern,
    ) {
        pattern.begin(self.places.len(), self.dimensions);
        for (value, &place) in site.parent().zip(&self.places) {
            self.hold(place as usize, Some(value), pattern);
        }
    }

    #[inline(always)]
    fn hold<const N: usize>(
        &self,
        place: usize,
        value: Option<SampleValue<N>>,
        pattern: &mut RingPattern,
    ) {
        let numbers = &mut pattern.values[place * self.dimensions..][..self.dimensions];
        match value {
            None => {
                pattern.counts[place] = 0.0;
                pattern.complete = false;
            }
            Some(SampleValue::Default) => numbers.copy_from_slice(self.vector(self.default)),
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

    /// Lets the centre hold a row.
    pub fn set_centre(&self, pattern: &mut RingPattern, row: u32) {
        pattern.values[..self.dimensions].copy_from_slice(self.vector(row));
        pattern.counts[0] = 1.0;
    }

    /// `sum` and the distance of a pattern to a texel's window, of whose samples the first `without` are left out;
    /// infinity once it exceeds `limit`.
    #[inline(always)]
    pub fn distance(
        &self,
        pattern: &RingPattern,
        texel: u32,
        without: usize,
        (sum, limit): (f32, f32),
    ) -> f32 {
        let numbers = without * self.dimensions..pattern.values.len();
        let window = &self.windows.window(texel)[numbers.clone()];
        let values = &pattern.values[numbers];
        match pattern.complete {
            true => squares(values, window, (sum, limit)),
            false => {
                let counts = &pattern.counts[without..];
                sum + counted_squares(values, window, counts, self.dimensions)
            }
        }
    }

    #[inline(always)]
    fn vector(&self, row: u32) -> &[f32] {
        &self.vectors[row as usize * self.dimensions..][..self.dimensions]
    }
}

impl RingPattern {
    fn begin(&mut self, samples: usize, dimensions: usize) {
        self.values.clear();
        self.values.resize(samples * dimensions, 0.0);
        self.counts.clear();
        self.counts.resize(samples, 1.0);
        self.complete = true;
    }
}

/// `sum` and the squared differences of two lists; infinity once they exceed `limit`.
#[apply(vectorized!)]
fn squares(values: &[f32], window: &[f32], (mut sum, limit): (f32, f32)) -> f32 {
    for (values, window) in values.chunks(RUN).zip(window.chunks(RUN)) {
        let (lanes, rest) = values.as_chunks::<LANES>();
        let (others, other_rest) = window.as_chunks::<LANES>();
        let mut sums = [0.0; LANES];
        for (values, window) in lanes.iter().zip(others) {
            for lane in 0..LANES {
                let apart = values[lane] - window[lane];
                sums[lane] += apart * apart;
            }
        }
        sum += sum_apart(&sums);
        sum += squares_of_pairs(rest, other_rest);
        if sum > limit {
            return f32::INFINITY;
        }
    }
    sum
}

/// The squared differences of the samples that count.
fn counted_squares(values: &[f32], window: &[f32], counts: &[f32], dimensions: usize) -> f32 {
    let samples = values
        .chunks_exact(dimensions)
        .zip(window.chunks_exact(dimensions));
    let counted = samples.zip(counts).filter(|(_, counts)| **counts > 0.0);
    counted.map(|((a, b), _)| squares_of_pairs(a, b)).sum()
}

#[inline(always)]
fn squares_of_pairs(a: &[f32], b: &[f32]) -> f32 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::TexelGrid;
    use crate::neighborhood::Neighborhood;
    use crate::sites::grid::window::SiteGrid;
    use crate::synthesis::metric::site_values::Unfinished;

    #[test]
    fn rings_are_prefixes_of_the_window() {
        let template = by_rings(7);
        assert_eq!(template.ring_ends, [1, 9, 25, 49]);
        for (ring, &end) in template.ring_ends.iter().enumerate() {
            let inside = |at: &&glam::Vec2| at.abs().max_element() as usize <= ring;
            assert_eq!(template.positions[..end].iter().filter(inside).count(), end);
        }
    }

    #[test]
    fn a_patch_of_the_features_is_its_own_window() {
        let grid = TexelGrid {
            width: 9,
            height: 9,
            tileable: true,
        };
        let rows: Vec<u32> = (0..81).collect();
        let vectors: Vec<f32> = (0..2 * 82).map(|at| ((at * 29) % 83) as f32).collect();
        let features = DenseFeatures {
            grid,
            rows: &rows,
            default: 81,
            vectors: &vectors,
            dimensions: 2,
        };
        let target = SiteGrid {
            width: 9,
            height: 9,
            toroidal: true,
        };
        let sites = target.hierarchy(&[Neighborhood::square(5, 0)]).unwrap();
        let metric = RingMetric::new(features, 3, 5, None);
        let mut pattern = RingPattern::default();
        for site in [0, 31, 80] {
            let done: Vec<bool> = (0..81).map(|other| other != 30).collect();
            for done in [None, Some(&done[..])] {
                let neighborhood = SiteNeighborhood {
                    site,
                    sites: &sites.levels[0],
                    rows: &rows,
                    done,
                    unfinished: Unfinished::LeftOut,
                    coarser: None,
                };
                metric.read(&neighborhood, 1, &mut pattern);
                let distance = |texel, limit| metric.distance(&pattern, texel, 0, (0.5, limit));
                assert_eq!(distance(site as u32, f32::INFINITY), 0.5);
                assert!(distance(40, f32::INFINITY) > 100.0);
            }
        }
    }
}
