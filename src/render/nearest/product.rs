//! Views or lights of a product sample: a set of directions weighted by angle.

use glam::{DVec3, Vec3};

use super::angle;
use super::bins::{Bins, DIRECTION_LANES, DirectionLanes};
use super::lanes::{LINEAR, Moments, Near, QUADRATIC, TangentPlane};
use super::weights::{
    REACH, Weight, Weighting, below_lowest, distinct, inverse_weights, keep_nearest,
};
use crate::btf::direction::{Direction, SAME_DIRECTION};

/// The directions that `inverse-angle` takes.
const NEAREST: usize = 4;
/// How fast negative weights come in below the lowest sampled light: all of them from ¾ of its cosine on.
const EXTRAPOLATION: f32 = 4.0;
/// Distinct directions, ready to be weighted.
#[derive(Clone, Debug)]
pub struct DirectionSet {
    /// Index of each kept direction in the sample.
    kept: Vec<u32>,
    directions: Vec<Direction>,
    /// Cosine of the lowest direction's polar angle.
    lowest: f64,
    weighting: Weighting,
    bins: Bins,
}

/// Working memory of a weighting, one per task.
#[derive(Clone, Debug, Default)]
pub struct Scratch {
    /// Squared lengths of the chords to the candidates.
    chords: Vec<[f32; DIRECTION_LANES]>,
    near: Vec<Near>,
    pub(super) distances: Vec<(f64, u32)>,
}

impl DirectionSet {
    /// Keeps the first of directions that are the same.
    pub fn new(directions: &[Direction], weighting: Weighting) -> Self {
        let kept = distinct(directions);
        let directions: Vec<_> = kept.iter().map(|&i| directions[i as usize]).collect();
        let vectors: Vec<DVec3> = directions.iter().map(|d| d.0.normalize()).collect();
        let lowest = vectors.iter().map(|d| d.z).fold(1.0, f64::min);
        Self {
            bins: Bins::new(&vectors, counted(weighting)),
            kept,
            directions,
            lowest,
            weighting,
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

    /// The weights of a unit direction above the horizon, into `out`: they sum to 1. With `AS_LIGHTS`
    /// each is then scaled to the wanted light, by min(cos θ / cos θᵢ, 2); those of `inverse-angle` are
    /// scaled together below the lowest sampled direction.
    #[inline(always)]
    pub fn weigh<const AS_LIGHTS: bool>(
        &self,
        wanted: DVec3,
        scratch: &mut Scratch,
        out: &mut Vec<Weight>,
    ) {
        match self.weighting {
            Weighting::Continuous => self.fit::<LINEAR, AS_LIGHTS>(wanted.as_vec3(), scratch, out),
            Weighting::Quadratic => {
                self.fit::<QUADRATIC, AS_LIGHTS>(wanted.as_vec3(), scratch, out);
            }
            Weighting::InverseAngle => self.inverse_angle::<AS_LIGHTS>(wanted, scratch, out),
        }
    }

    /// The weights of a local [fit](super::fit) with `N` terms beside the constant.
    #[inline(always)]
    fn fit<const N: usize, const AS_LIGHTS: bool>(
        &self,
        wanted: Vec3,
        scratch: &mut Scratch,
        out: &mut Vec<Weight>,
    ) {
        // Measure all distances.
        let Scratch { chords, near, .. } = scratch;
        let blocks = self.bins.of_direction(wanted.x, wanted.y, wanted.z);
        chords.resize(blocks.len(), [0.0; DIRECTION_LANES]);
        for (block, chords) in blocks.iter().zip(chords.iter_mut()) {
            *chords = block.squared_chords(wanted);
        }
        // Let an equal direction take all the weight.
        let nearest = smallest(chords);
        if angle::of_squared_chord(nearest) < SAME_DIRECTION as f32 {
            out.clear();
            out.extend(only::<AS_LIGHTS>(wanted.z, nearest, blocks, chords));
            return;
        }
        // Sum the moments of the fit over those within reach.
        let reach = self.reach(chords);
        let plane = TangentPlane::at(wanted);
        let mut moments = Moments::<N>::new();
        near.resize(blocks.len(), Near::NONE);
        for ((block, chords), near) in blocks.iter().zip(chords.iter()).zip(near.iter_mut()) {
            *near = plane.near(block, chords, reach);
            moments.add(near);
        }
        // Weight each by the fitted surface.
        let tilt = moments.tilt();
        let negative = self.share_of_negative::<N, AS_LIGHTS>(wanted.z);
        out.resize(blocks.len() * DIRECTION_LANES, Weight::default());
        let (mut sum, mut count) = (0.0, 0);
        for (block, near) in blocks.iter().zip(near.iter()) {
            let weights = near.tilted(tilt, negative);
            let scales = match AS_LIGHTS {
                true => block.cosine_ratios(wanted.z),
                false => [1.0; DIRECTION_LANES],
            };
            for lane in 0..DIRECTION_LANES {
                out[count] = Weight {
                    index: block.index[lane],
                    weight: weights[lane] * scales[lane],
                };
                count += usize::from(weights[lane] != 0.0);
                sum += weights[lane];
            }
        }
        // Normalize.
        out.truncate(count);
        let scale = 1.0 / sum;
        for weight in out {
            weight.weight *= scale;
        }
    }

    /// The share of negative weights that a fit keeps: all of a quadratic one and none of a linear one, but for
    /// lights below the lowest sampled one, where shadows continue growing as they grow above it.
    #[inline(always)]
    fn share_of_negative<const N: usize, const AS_LIGHTS: bool>(&self, cosine: f32) -> f32 {
        match (N, AS_LIGHTS) {
            (LINEAR, false) => 0.0,
            (LINEAR, true) => {
                let below = 1.0 - cosine / self.lowest as f32;
                (EXTRAPOLATION * below).clamp(0.0, 1.0)
            }
            _ => 1.0,
        }
    }

    /// R: 1.05 times the angle to the direction that decides it, π where there are fewer.
    #[inline(always)]
    fn reach(&self, chords: &[[f32; DIRECTION_LANES]]) -> f32 {
        let counted = counted(self.weighting);
        if self.len() < counted {
            return std::f32::consts::PI;
        }
        let angle = angle::of_squared_chord(counted_smallest(chords, counted as i32));
        (REACH as f32 * angle).min(std::f32::consts::PI)
    }

    /// The `inverse-angle` weights.
    fn inverse_angle<const AS_LIGHTS: bool>(
        &self,
        wanted: DVec3,
        scratch: &mut Scratch,
        out: &mut Vec<Weight>,
    ) {
        let [x, y, z] = wanted.as_vec3().to_array();
        let distances = &mut scratch.distances;
        distances.clear();
        for block in self.bins.of_direction(x, y, z) {
            for lane in 0..DIRECTION_LANES {
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

/// The direction whose angle sets the reach of a fit.
#[inline(always)]
fn counted(weighting: Weighting) -> usize {
    match weighting {
        Weighting::Quadratic => 10,
        Weighting::Continuous | Weighting::InverseAngle => 5,
    }
}

/// All the weight for the first direction at the chord `nearest`.
#[inline(always)]
fn only<const AS_LIGHTS: bool>(
    cosine: f32,
    nearest: f32,
    blocks: &[DirectionLanes],
    chords: &[[f32; DIRECTION_LANES]],
) -> Option<Weight> {
    let lane = chords
        .as_flattened()
        .iter()
        .position(|&chord| chord == nearest)?;
    let (block, lane) = (&blocks[lane / DIRECTION_LANES], lane % DIRECTION_LANES);
    let weight = match AS_LIGHTS {
        true => block.cosine_ratios(cosine)[lane],
        false => 1.0,
    };
    let index = block.index[lane];
    Some(Weight { index, weight })
}

#[inline(always)]
fn smallest(chords: &[[f32; DIRECTION_LANES]]) -> f32 {
    let mut found = [f32::INFINITY; DIRECTION_LANES];
    for chords in chords {
        for lane in 0..DIRECTION_LANES {
            found[lane] = lesser(found[lane], chords[lane]);
        }
    }
    found.into_iter().fold(f32::INFINITY, lesser)
}

/// The `counted`th smallest of the numbers: the smallest one that so many do not exceed.
#[inline(always)]
fn counted_smallest(numbers: &[[f32; DIRECTION_LANES]], counted: i32) -> f32 {
    let mut found = [f32::INFINITY; DIRECTION_LANES];
    for mine in numbers {
        let mut not_above = [0i32; DIRECTION_LANES];
        for &other in numbers.as_flattened() {
            for lane in 0..DIRECTION_LANES {
                not_above[lane] += i32::from(other <= mine[lane]);
            }
        }
        for lane in 0..DIRECTION_LANES {
            let candidate = if not_above[lane] >= counted {
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
