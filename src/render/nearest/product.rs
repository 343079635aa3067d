//! Views or lights of a product sample: a set of directions weighted by angle.

use glam::DVec3;

use super::angle;
use super::bins::{Bins, LANES};
use super::weights::{REACH, Weight, below_lowest, distinct, inverse_weights, keep_nearest};
use crate::btf::direction::{Direction, SAME_DIRECTION};

/// The directions that `inverse-angle` takes.
const NEAREST: usize = 4;
/// The direction whose angle sets the reach of `continuous`.
const COUNTED: usize = 5;

/// Distinct directions, ready to be weighted.
#[derive(Clone, Debug)]
pub struct DirectionSet {
    /// Index of each kept direction in the sample.
    kept: Vec<u32>,
    directions: Vec<Direction>,
    /// Cosine of the lowest direction's polar angle.
    lowest: f64,
    bins: Bins,
}

/// Working memory of a weighting, one a task.
#[derive(Clone, Debug, Default)]
pub struct Scratch {
    /// Squared lengths of the chords to the candidates.
    chords: Vec<[f32; LANES]>,
    distances: Vec<(f64, u32)>,
}

impl DirectionSet {
    /// Keeps the first of directions that are the same.
    pub fn new(directions: &[Direction]) -> Self {
        let kept = distinct(directions);
        let directions: Vec<_> = kept.iter().map(|&i| directions[i as usize]).collect();
        let vectors: Vec<DVec3> = directions.iter().map(|d| d.0.normalize()).collect();
        let lowest = vectors.iter().map(|d| d.z).fold(1.0, f64::min);
        Self {
            bins: Bins::new(&vectors, COUNTED),
            kept,
            directions,
            lowest,
        }
    }

    /// How many distinct directions there are.
    pub fn len(&self) -> usize {
        self.kept.len()
    }

    /// The distinct directions.
    pub fn directions(&self) -> &[Direction] {
        &self.directions
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.kept.is_empty()
    }

    /// The index in the sample of each distinct direction.
    pub fn kept(&self) -> &[u32] {
        &self.kept
    }

    /// Whether a direction lies lower than every sampled one.
    #[inline]
    pub fn is_below_all(&self, cosine: f32) -> bool {
        f64::from(cosine) < self.lowest - 1e-6
    }

    /// The `continuous` weights of a unit direction above the horizon, into `out`; they sum to 1.
    /// With `AS_LIGHTS` each is scaled by min(cos θ / cos θᵢ, 2).
    #[inline(always)]
    pub fn continuous<const AS_LIGHTS: bool>(
        &self,
        wanted: [f32; 3],
        scratch: &mut Scratch,
        out: &mut Vec<Weight>,
    ) {
        let [x, y, z] = wanted;
        let blocks = self.bins.of_direction(x, y, z);
        let chords = &mut scratch.chords;
        chords.clear();
        chords.extend(blocks.iter().map(|block| block.squared_chords(wanted)));
        let nearest = smallest(chords);
        let takes_all = angle::of_squared_chord(nearest) < SAME_DIRECTION as f32;
        let reach = if self.len() < COUNTED {
            std::f32::consts::PI
        } else {
            let counted = angle::of_squared_chord(counted_smallest(chords));
            (REACH as f32 * counted).min(std::f32::consts::PI)
        };
        out.resize(blocks.len() * LANES, Weight::default());
        let (mut sum, mut count) = (0.0, 0);
        for (block, chords) in blocks.iter().zip(chords.iter()) {
            let weights = if takes_all {
                all_for(nearest, chords)
            } else {
                fading(chords, reach)
            };
            let scales = if AS_LIGHTS {
                block.cosine_ratios(z)
            } else {
                [1.0; LANES]
            };
            for lane in 0..LANES {
                out[count] = Weight {
                    index: block.index[lane],
                    weight: weights[lane] * scales[lane],
                };
                count += usize::from(weights[lane] > 0.0);
                sum += weights[lane];
            }
        }
        out.truncate(count);
        let scale = 1.0 / sum;
        for weight in out {
            weight.weight *= scale;
        }
    }

    /// The `inverse-angle` weights of a unit direction, into `out`; they sum to 1. With
    /// `AS_LIGHTS` they are scaled down below the lowest sampled direction.
    pub fn inverse_angle<const AS_LIGHTS: bool>(
        &self,
        wanted: DVec3,
        scratch: &mut Scratch,
        out: &mut Vec<Weight>,
    ) {
        let [x, y, z] = wanted.as_vec3().to_array();
        let distances = &mut scratch.distances;
        distances.clear();
        for block in self.bins.of_direction(x, y, z) {
            for lane in 0..LANES {
                if block.z[lane] >= -1.0 {
                    let index = block.index[lane];
                    let angle = self.directions[index as usize].angle_to(Direction(wanted));
                    distances.push((angle, index));
                }
            }
        }
        keep_nearest(distances, NEAREST);
        inverse_weights(distances, out);
        if AS_LIGHTS {
            let scale = below_lowest(wanted.z, self.lowest);
            for weight in out {
                weight.weight *= scale;
            }
        }
    }
}

/// The weights ((R − d)/(R d))² of directions at squared chords, 0 from R on. Directions as near
/// as [`SAME_DIRECTION`] are not among them.
#[inline(always)]
fn fading(chords: &[f32; LANES], reach: f32) -> [f32; LANES] {
    let mut weights = [0.0; LANES];
    for (weight, &chord) in weights.iter_mut().zip(chords) {
        let d = angle::of_squared_chord(chord);
        let fading = (reach - d) / (reach * d);
        *weight = if d < reach { fading * fading } else { 0.0 };
    }
    weights
}

/// The weights where the direction at the chord `nearest` takes all.
fn all_for(nearest: f32, chords: &[f32; LANES]) -> [f32; LANES] {
    chords.map(|chord| if chord == nearest { 1.0 } else { 0.0 })
}

#[inline(always)]
fn smallest(chords: &[[f32; LANES]]) -> f32 {
    let mut found = [f32::INFINITY; LANES];
    for chords in chords {
        for lane in 0..LANES {
            found[lane] = lesser(found[lane], chords[lane]);
        }
    }
    found.into_iter().fold(f32::INFINITY, lesser)
}

/// The [`COUNTED`]th smallest of the numbers: the smallest one that so many do not exceed.
#[inline(always)]
fn counted_smallest(numbers: &[[f32; LANES]]) -> f32 {
    let mut found = [f32::INFINITY; LANES];
    for mine in numbers {
        let mut not_above = [0i32; LANES];
        for &other in numbers.as_flattened() {
            for lane in 0..LANES {
                not_above[lane] += i32::from(other <= mine[lane]);
            }
        }
        for lane in 0..LANES {
            let candidate = if not_above[lane] >= COUNTED as i32 {
                mine[lane]
            } else {
                f32::INFINITY
            };
            found[lane] = lesser(found[lane], candidate);
        }
    }
    found.into_iter().fold(f32::INFINITY, lesser)
}

/// The smaller of two numbers that are not NaN, in one instruction.
#[inline(always)]
fn lesser(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}
