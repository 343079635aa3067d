//! Nearest images (Tong 2002 §6): which of the sample's directions stand for a wanted one, and
//! with which weights.
//!
//! Directions within [`SAME_DIRECTION`](crate::btf::direction::SAME_DIRECTION) of each other count as one, the first; a
//! wanted direction that close to a sampled one gives it all the weight. Two weightings:
//!
//! - `inverse-angle`, the paper's: the 4 nearest by angle d, w = 1/d. The blend jumps where the nearest four change.
//! - `continuous`: all with d < R = 1.05 · d₅ (the 5th nearest), with the nearness
//!   b = ((R − d)/(R d))² and the weights of a linear [`fit`], none below 0: what changes linearly from
//!   direction to direction is reproduced, and a direction enters and leaves with weight 0. Lights
//!   below the lowest sampled one are extrapolated: there negative weights come in.
//! - `quadratic`: the same with d₁₀ and a quadratic fit, whose weights may be negative.
//!
//! Deviation: the last two are not the paper's; they are what a sweep without popping needs. The
//! measured effect is in docs/rendering.md and docs/fidelity.md.
//!
//! | file | what it does |
//! | --- | --- |
//! | [`product`] | weights of views, or of lights |
//! | [`lanes`] | its fits in vector code: nearness, coordinates, moments |
//! | [`bins`], [`angle`] | lists of candidates; angles from chords |
//! | [`pairs`] | weights of scattered pairs |
//! | [`fit`] | the small systems of both |
//! | [`weights`] | what both share |

mod angle;
mod bins;
mod fit;
mod lanes;
mod pairs;
mod product;
mod weights;

pub use pairs::PairSet;
pub use product::{DirectionSet, Scratch};
pub use weights::{Weight, Weighting};

use glam::DVec3;

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
