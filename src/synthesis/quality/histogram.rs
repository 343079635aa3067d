//! Whether every texton covers as much of the surface as of the sample.

use crate::exemplar::space::{Features, Space};
use crate::grid::TexCoord;

/// ½ Σ (a − b)² / (a + b) of the normalised texton histograms, surface by area against sample;
/// `None` for plain images.
pub fn chi2(space: &Space, coords: &[TexCoord], areas: &[f32]) -> Option<f64> {
    let level = &space.levels[0];
    let Features::Textons { labels, gram } = &level.features else {
        return None;
    };
    let label = |texel: usize| usize::from(labels[texel]);
    let (mut sample, mut surface) = (vec![0.0; gram.nrows()], vec![0.0; gram.nrows()]);
    for texel in 0..labels.len() {
        sample[label(texel)] += 1.0;
    }
    for (&at, &area) in coords.iter().zip(areas) {
        surface[label(level.grid.texel_nearest(at).index())] += f64::from(area);
    }
    normalize(&mut sample);
    normalize(&mut surface);
    let terms = sample.iter().zip(&surface).filter(|(a, b)| **a + **b > 0.0);
    Some(0.5 * terms.map(|(a, b)| (a - b).powi(2) / (a + b)).sum::<f64>())
}

fn normalize(histogram: &mut [f64]) {
    let sum: f64 = histogram.iter().sum();
    if sum > 0.0 {
        histogram.iter_mut().for_each(|share| *share /= sum);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::index::TexelIndex;
    use crate::synthesis::tests::fixtures;

    #[test]
    fn a_copy_has_the_samples_histogram_and_one_texton_its_distance() {
        let (space, _) = fixtures::random_exemplar(3, 8, 1, true);
        let level = &space.levels[0];
        let coords: Vec<TexCoord> = (0..64).map(|i| level.grid.centre(TexelIndex(i))).collect();
        assert_eq!(chi2(&space, &coords, &[2.0; 64]), Some(0.0));
        let Features::Textons { labels, .. } = &level.features else {
            panic!("textons expected");
        };
        let share = labels.iter().filter(|&&l| l == labels[0]).count() as f64 / 64.0;
        let expected = 0.5 * ((1.0 - share).powi(2) / (1.0 + share) + (1.0 - share));
        let found = chi2(&space, &[coords[0]; 5], &[1.0; 5]).unwrap();
        assert!((found - expected).abs() < 1e-12);
    }

    #[test]
    fn sites_count_by_their_area() {
        let (space, _) = fixtures::random_exemplar(3, 8, 1, true);
        let grid = space.levels[0].grid;
        let coords: Vec<TexCoord> = (0..65).map(|i| grid.centre(TexelIndex(i % 64))).collect();
        let mut areas = [1.0; 65];
        areas[64] = 0.0;
        assert_eq!(chi2(&space, &coords, &areas), Some(0.0));
    }
}
