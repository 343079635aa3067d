//! What product and scattered samples share: directions that are the same, the nearest of a list, and
//! weights by inverse distance.

use serde::Serialize;

use crate::btf::direction::{Direction, SAME_DIRECTION};

/// How images of nearby directions are weighted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Weighting {
    /// A linear fit to the directions within 1.05 times the angle of the 5th nearest; values are scaled by the ratio of
    /// the lights' cosines, at most 2. Sweeps are smooth.
    #[default]
    Continuous,
    /// A quadratic fit to the directions within 1.05 times the angle of the 10th nearest: more accurate between the
    /// directions, with about six times as many reads. Not for scattered pairs.
    Quadratic,
    /// The 4 nearest views and the 4 nearest lights by inverse angle, exactly as in Tong et al. 2002.
    InverseAngle,
}

/// A sampled direction (or pair) and its share.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Weight {
    /// Index among the kept directions, or pairs.
    pub index: u32,
    /// Its share of the blend; for lights, times what its values are scaled by.
    pub weight: f32,
}

/// R is this many times the angle to the first direction that is left out.
pub(super) const REACH: f64 = 1.05;
/// The most by which `continuous` scales a value to another light's cosine.
pub(super) const LARGEST_RATIO: f64 = 2.0;
/// Angles that differ by less are ties, which go to the smaller index.
const TIE: f64 = 1e-9;

/// The first of each cluster of directions that are the same, as indices.
pub(super) fn distinct(directions: &[Direction]) -> Vec<u32> {
    let mut kept: Vec<u32> = Vec::new();
    for (index, direction) in directions.iter().enumerate() {
        let known = |&other: &u32| directions[other as usize].angle_to(*direction) < SAME_DIRECTION;
        if !kept.iter().any(known) {
            kept.push(index as u32);
        }
    }
    kept
}

/// The kept direction that each direction stands under, as indices into the kept ones.
pub(super) fn representative(directions: &[Direction], kept: &[u32]) -> Vec<u32> {
    let of = |direction: &Direction| {
        let same = |&index: &u32| directions[index as usize].angle_to(*direction) < SAME_DIRECTION;
        kept.iter().position(same).unwrap_or(0) as u32
    };
    directions.iter().map(of).collect()
}

/// Puts the `count` smallest distances first, equal ones by index, and cuts the list to them.
pub(super) fn keep_nearest(distances: &mut Vec<(f64, u32)>, count: usize) {
    distances.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    if distances.len() <= count {
        return;
    }
    // Those tied with the last one that fits compete by index.
    let last = distances[count - 1].0;
    let first_tied = distances.partition_point(|&(d, _)| d < last - TIE);
    let end_tied = distances.partition_point(|&(d, _)| d <= last + TIE);
    distances[first_tied..end_tied].sort_unstable_by_key(|&(_, index)| index);
    distances.truncate(count);
}

/// Inverse-distance weights that sum to 1; a distance below [`SAME_DIRECTION`] takes all.
pub(super) fn inverse_weights(distances: &[(f64, u32)], out: &mut Vec<Weight>) {
    out.clear();
    if let Some(index) = same_direction(distances) {
        out.push(Weight { index, weight: 1.0 });
        return;
    }
    let sum: f64 = distances.iter().map(|(d, _)| 1.0 / d).sum();
    out.extend(distances.iter().map(|&(d, index)| Weight {
        index,
        weight: (1.0 / d / sum) as f32,
    }));
}

/// The nearest direction when it is the wanted one.
pub(super) fn same_direction(distances: &[(f64, u32)]) -> Option<u32> {
    let nearest = distances
        .iter()
        .min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    nearest
        .filter(|(d, _)| *d < SAME_DIRECTION)
        .map(|&(_, index)| index)
}

/// By how much `inverse-angle` scales values for a light at `cosine`, given that of the lowest
/// sampled light.
#[inline]
pub(super) fn below_lowest(cosine: f64, lowest: f64) -> f32 {
    if cosine < lowest {
        (cosine / lowest) as f32
    } else {
        1.0
    }
}
