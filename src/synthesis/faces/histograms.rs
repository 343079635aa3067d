//! Whether the numbers of a surface's faces are distributed as those of the sample (Castellanos and Williams, Fig. 13).

use serde::Serialize;

use crate::exemplar::space::Space;
use crate::maps::vertex_map::SurfaceTextonMap;
use crate::synthesis::faces::exemplar::SquareExemplar;
use crate::synthesis::quality::histogram::chi2;
use crate::synthesis::recipes::choosy::FaceValues;

/// Bins of a histogram.
const BINS: usize = 50;

/// How far the histograms of a channel's numbers lie apart.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct HistogramDistances {
    /// The channel's name.
    pub channel: String,
    /// For each of its numbers Σ |a − b| of the normalised histograms, 0 to 2.
    pub l1: Vec<f64>,
}

/// The distances of all channels that count in synthesis; none for textons. Each face counts once, as in the paper. The
/// 50 bins cover the channel's range.
pub fn histogram_distances(
    space: &Space,
    exemplar: &SquareExemplar,
    colors: &FaceValues,
) -> Vec<HistogramDistances> {
    let mut first = 0;
    let channels = space.channels.list().iter();
    let channels = channels.filter(|channel| channel.weight > 0.0);
    let distances = channels.map(|channel| {
        let factor = channel.weight.sqrt();
        let range = [channel.low * factor, channel.high * factor];
        let places = first..first + channel.count as usize;
        first = places.end;
        let distance = |at: usize| {
            let of_sample = exemplar.image().numbers[at..]
                .iter()
                .step_by(exemplar.channels);
            let of_surface = colors.numbers[at..].iter().step_by(exemplar.channels);
            l1_distance(&histogram(of_sample, range), &histogram(of_surface, range))
        };
        HistogramDistances {
            channel: channel.name.clone(),
            l1: places.map(distance).collect(),
        }
    });
    distances.collect()
}

/// The distance of texton histograms, surface by area against sample, of faces whose centres are the vertices of
/// `centers`; `None` for plain images.
pub fn texton_distance(space: &Space, centers: &SurfaceTextonMap, areas: &[f32]) -> Option<f64> {
    chi2(space, &centers.coords, areas)
}

/// Shares of numbers in bins of equal width over a range; what lies beyond counts in the outermost.
fn histogram<'a>(numbers: impl Iterator<Item = &'a f32>, [low, high]: [f64; 2]) -> [f64; BINS] {
    let (mut counts, mut all) = ([0.0; BINS], 0.0);
    for &number in numbers {
        let at = (f64::from(number) - low) / (high - low) * BINS as f64;
        counts[(at as usize).min(BINS - 1)] += 1.0;
        all += 1.0;
    }
    counts.map(|count: f64| if all > 0.0 { count / all } else { 0.0 })
}

fn l1_distance(one: &[f64; BINS], other: &[f64; BINS]) -> f64 {
    let pairs = one.iter().zip(other);
    pairs.map(|(one, other)| (one - other).abs()).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn histograms_lie_apart_by_the_shares_that_differ() {
        let of = |numbers: &[f32]| histogram(numbers.iter(), [0.0, 1.0]);
        let sample = of(&[0.0, 0.1, 0.5, 1.0]);
        assert_eq!(l1_distance(&sample, &of(&[1.0, 0.5, 0.1, 0.0])), 0.0);
        assert_eq!(l1_distance(&sample, &of(&[0.0, 0.1, 0.5, 0.7])), 0.5);
        assert_eq!(l1_distance(&of(&[0.3]), &of(&[0.7, 0.7])), 2.0);
        // Numbers beyond the range count at its ends.
        assert_eq!(of(&[-3.0, 9.0]), of(&[0.0, 1.0]));
        assert_eq!(of(&[]), [0.0; BINS]);
    }
}
