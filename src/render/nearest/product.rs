//! Views or lights of a product sample: a set of directions weighted by angle.

use glam::DVec3;

use super::bins::{Bins, LANES};
use super::{
    LARGEST_RATIO, REACH, Weight, angle, below_lowest, distinct, inverse_weights, keep_nearest,
};
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
    angles: Vec<[f32; LANES]>,
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
        let angles = &mut scratch.angles;
        angles.resize(blocks.len(), [0.0; LANES]);
        let mut nearest = f32::INFINITY;
        for (block, angles) in blocks.iter().zip(angles.iter_mut()) {
            for (lane, angle) in angles.iter_mut().enumerate() {
                let (dx, dy, dz) = (x - block.x[lane], y - block.y[lane], z - block.z[lane]);
                *angle = angle::of_squared_chord(dx * dx + dy * dy + dz * dz);
            }
            for &angle in angles.iter() {
                nearest = nearest.min(angle);
            }
        }
        let reach = if self.len() < COUNTED {
            std::f32::consts::PI
        } else {
            (REACH as f32 * counted_smallest(angles)).min(std::f32::consts::PI)
        };
        let takes_all = nearest < SAME_DIRECTION as f32;
        let mut sum = 0.0;
        let mut count = 0;
        out.resize(blocks.len() * LANES, Weight::default());
        for (block, angles) in blocks.iter().zip(angles.iter()) {
            let mut weights = [0.0; LANES];
            for lane in 0..LANES {
                let d = angles[lane];
                let fading = (reach - d) / (reach * d.max(1e-12));
                let blended = if d < reach { fading * fading } else { 0.0 };
                let alone = if d == nearest { 1.0 } else { 0.0 };
                weights[lane] = if takes_all { alone } else { blended };
            }
            for (lane, &weight) in weights.iter().enumerate() {
                sum += weight;
                out[count] = Weight {
                    index: block.index[lane],
                    weight: if AS_LIGHTS {
                        let ratio = (z / block.z[lane].max(1e-9)).min(LARGEST_RATIO as f32);
                        weight * ratio
                    } else {
                        weight
                    },
                };
                count += usize::from(weight > 0.0);
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

/// The [`COUNTED`]th smallest of the angles: the smallest one that so many do not exceed.
#[inline(always)]
fn counted_smallest(angles: &[[f32; LANES]]) -> f32 {
    let mut found = f32::INFINITY;
    for mine in angles {
        let mut not_above = [0i32; LANES];
        for others in angles {
            for &other in others {
                for lane in 0..LANES {
                    not_above[lane] += i32::from(other <= mine[lane]);
                }
            }
        }
        for lane in 0..LANES {
            if not_above[lane] >= COUNTED as i32 {
                found = found.min(mine[lane]);
            }
        }
    }
    found
}
