//! Nearest images (Tong 2002 §6): which of the sample's directions stand for a wanted one, and
//! with which weights.
//!
//! Directions within [`SAME_DIRECTION`](crate::btf::direction::SAME_DIRECTION) of each other count as one, the first; a wanted direction
//! that close to a sampled one gives it all the weight. Two weightings:
//!
//! - `inverse-angle`, the paper's: the 4 nearest by angle d, w = 1/d. A change of the nearest four
//!   is a jump.
//! - `continuous`: all with d < R = 1.05 · d₅ (the 5th nearest), w = ((R − d)/(R d))²: a direction
//!   enters and leaves with weight 0.
//!
//! Deviation: `continuous` is not the paper's; it is what a sweep without popping needs. The
//! measured effect is in docs/rendering.md.

mod angle;
mod bins;
mod pairs;
mod product;
mod weights;

pub use pairs::PairSet;
pub use product::{DirectionSet, Scratch};
pub use weights::Weight;

use glam::DVec3;
use serde::{Deserialize, Serialize};

/// How the nearest images are weighted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Weighting {
    /// Every direction nearer than 1.05 times the 5th nearest, fading in and out; values are
    /// scaled by the ratio of the lights' cosines, at most 2. A sweep does not pop.
    #[default]
    Continuous,
    /// The 4 nearest views and the 4 nearest lights by inverse angle: Tong et al. 2002, literally.
    InverseAngle,
}

/// A view below the horizon is lifted to this angle above it, in radians.
pub const LIFT: f64 = 1e-3;
/// A view direction in a vertex's frame, lifted above the horizon where it lies below it.
#[inline]
pub fn lifted(view: DVec3) -> DVec3 {
    if view.z >= 0.0 {
        return view;
    }
    let level = glam::DVec2::new(view.x, view.y)
        .try_normalize()
        .unwrap_or(glam::DVec2::X);
    (level * LIFT.cos()).extend(LIFT.sin())
}

#[cfg(test)]
mod tests;
