//! Rotations into local frames: a texel's values stand for directions in its own frame, not in the patch's.
//!
//! The rows of a rotation are the tangent, the binormal and the normal, in the patch's frame: a direction d of the
//! patch is R d in the local frame. No file with rotations is known; this is how btf.hh lays out the nine numbers.
//!
//! With one rotation for all texels, directions are turned back and no value changes. With one per texel, each value
//! is interpolated at the directions asked for: the 4 nearest views and the 4 nearest lights, weighted by 1/angle. A
//! light below a texel's own horizon gives 0; a view below it is lifted to it.

use std::ops::Range;

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use crate::btf::bonn::header::Header;
use crate::btf::bonn::sampling::Sampling;
use crate::btf::direction::{Direction, SAME_DIRECTION};
use crate::error::{Error, Result};

/// How far R Rᵀ may be from the identity.
const ORTHONORMAL: f64 = 1e-3;
/// Directions that are interpolated.
const NEAREST: usize = 4;
/// The least height of a view above a texel's horizon.
const LIFTED: f64 = 1e-3;

/// The frames of a file.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum LocalFrames {
    /// The patch's.
    None,
    /// One for all texels.
    One(DMat3),
    /// One per texel.
    PerTexel(Vec<DMat3>),
}

impl LocalFrames {
    pub(super) fn of(header: &Header) -> Result<Self> {
        let rotations: Vec<DMat3> = header
            .rotations
            .iter()
            .enumerate()
            .map(|(at, numbers)| rotation(at, numbers))
            .collect::<Result<_>>()?;
        match rotations[..] {
            [] => Ok(Self::None),
            _ if rotations
                .iter()
                .all(|&rotation| rotation == DMat3::IDENTITY) =>
            {
                Ok(Self::None)
            }
            [only] => Ok(Self::One(only)),
            _ if rotations.len() == header.texels() => Ok(Self::PerTexel(rotations)),
            _ => Err(
                Error::data("number of rotations", rotations.len().to_string())
                    .expected(format!("0, 1, or one per texel ({})", header.texels())),
            ),
        }
    }

    /// A direction of the file in the patch's frame.
    pub(super) fn to_patch(&self, direction: Direction) -> Direction {
        match self {
            Self::One(rotation) => Direction(rotation.transpose() * direction.0),
            Self::None | Self::PerTexel(_) => direction,
        }
    }
}

fn rotation(at: usize, numbers: &[f32; 9]) -> Result<DMat3> {
    let rotation = DMat3::from_cols_array(&numbers.map(f64::from)).transpose();
    let rest = rotation * rotation.transpose() - DMat3::IDENTITY;
    let is_near = rest.to_cols_array().iter().all(|v| v.abs() <= ORTHONORMAL);
    match is_near && rotation.determinant() > 0.0 {
        true => Ok(rotation),
        false => Err(
            Error::data(format!("rotation {at}"), format!("{numbers:?}"))
                .expected("a rotation: three unit rows at right angles, right-handed"),
        ),
    }
}

/// Weights of the nearest directions.
type Weights = [(usize, f32); NEAREST];

/// Turns the values of one texel, \[view\]\[light\]\[RGB\], to the patch's frame.
fn turned(
    values: &[f32],
    rotation: &DMat3,
    views: &[Direction],
    lights: &[Direction],
    out: &mut [f32],
) {
    // Weight the directions of the texel's frame.
    let local = |set: &[Direction], lift: bool| -> Vec<Option<Weights>> {
        set.iter()
            .map(|direction| weights(rotation, *direction, set, lift))
            .collect()
    };
    let (view_weights, light_weights) = (local(views, true), local(lights, false));
    // Blend the values of every pair of directions.
    let pairs = view_weights
        .iter()
        .flat_map(|view| light_weights.iter().map(move |light| (view, light)));
    for ((view, light), out) in pairs.zip(out.chunks_mut(3)) {
        out.fill(0.0);
        let (Some(view), Some(light)) = (view, light) else {
            continue;
        };
        for &(v, view_weight) in view {
            for &(l, light_weight) in light {
                let from = (v * lights.len() + l) * 3;
                let weight = view_weight * light_weight;
                let parts = out.iter_mut().zip(&values[from..from + 3]);
                parts.for_each(|(out, value)| *out += weight * value);
            }
        }
    }
}

/// The weights of a direction of the patch among those of a texel's frame; `None` below its horizon.
fn weights(
    rotation: &DMat3,
    direction: Direction,
    set: &[Direction],
    lift: bool,
) -> Option<Weights> {
    // Turn the direction to the texel's frame; lift views that are below its horizon.
    let mut local = *rotation * direction.0;
    if local.z < LIFTED {
        if !lift && local.z <= 0.0 {
            return None;
        }
        if lift {
            local = DVec3::new(local.x, local.y, LIFTED).normalize();
        }
    }
    let local = Direction(local);
    // Sort the set by angle.
    let mut nearest: Vec<(usize, f64)> = set
        .iter()
        .map(|other| other.angle_to(local))
        .enumerate()
        .collect();
    nearest.sort_by(|(i, a), (j, b)| a.total_cmp(b).then(i.cmp(j)));
    // Weight the nearest by their inverse angles; an equal direction takes all the weight.
    let mut weights = [(0, 0.0); NEAREST];
    if nearest[0].1 < SAME_DIRECTION {
        weights[0] = (nearest[0].0, 1.0);
        return Some(weights);
    }
    let sum: f64 = nearest.iter().take(NEAREST).map(|(_, d)| 1.0 / d).sum();
    let pairs = weights.iter_mut().zip(&nearest);
    pairs.for_each(|(weight, &(at, d))| *weight = (at, (1.0 / d / sum) as f32));
    Some(weights)
}

/// A frame per texel, and the directions that values are of in each.
pub(super) struct TexelFrames<'a> {
    pub(super) rotations: &'a [DMat3],
    pub(super) sampling: &'a Sampling,
}

impl TexelFrames<'_> {
    /// Turns a block of texels, \[texel\]\[image\]\[RGB\], in place.
    pub(super) fn turn_block(&self, block: &mut [f32], texels: Range<usize>) {
        let Sampling { views, lights } = self.sampling;
        block
            .par_chunks_mut(self.sampling.images() * 3)
            .zip(&self.rotations[texels])
            .for_each(|(values, rotation)| {
                let mut out = vec![0.0; values.len()];
                turned(values, rotation, views, lights, &mut out);
                values.copy_from_slice(&out);
            });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::btf::DirectionSet;

    #[test]
    fn a_turn_by_a_ring_s_own_step_permutes_it() {
        let set = "rings:0:1,40:4".parse::<DirectionSet>().unwrap();
        let set = set.directions().unwrap();
        // A local frame that stands a quarter turn ahead: patch azimuth φ is φ − 90° in it.
        let quarter = DMat3::from_rotation_z(-std::f64::consts::FRAC_PI_2);
        let values: Vec<f32> = (0..75).map(|at| at as f32).collect();
        let mut out = vec![0.0; 75];
        turned(&values, &quarter, &set, &set, &mut out);
        let number = |v: usize, l: usize| ((v * 5 + l) * 3) as f32;
        let at = |v: usize, l: usize| out[(v * 5 + l) * 3];
        assert_eq!(at(0, 0), number(0, 0));
        assert!((at(1, 0) - number(4, 0)).abs() < 1e-3);
        assert!((at(2, 3) - number(1, 2)).abs() < 1e-3);
    }

    #[test]
    fn what_turns_nothing_changes_nothing() {
        let set = "fibonacci:7".parse::<DirectionSet>().unwrap();
        let set = set.directions().unwrap();
        let values: Vec<f32> = (0..147).map(|at| at as f32).collect();
        let mut out = vec![0.0; 147];
        turned(&values, &DMat3::IDENTITY, &set, &set, &mut out);
        assert_eq!(out, values);
    }

    #[test]
    fn what_is_no_rotation_is_refused() {
        let text = rotation(3, &[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, -1.0]);
        assert!(text.unwrap_err().to_string().contains("rotation 3"));
    }
}
