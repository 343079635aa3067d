//! How far a sample can be trusted between its directions: each is left out, predicted from the others as the
//! renderer would blend them, and compared with what was measured there.
//!
//! A product of views and lights is tried in its lights, every view at its own, and in its views, every light at its
//! own. A scattered sample is tried pair by pair. The cost is bounded: at most [`MOST_TEXELS`] texels are compared, in
//! runs spread over the grid, and at most [`MOST_HELD`] directions are left out, both drawn by the seed.
//!
//! | file | what it does |
//! | --- | --- |
//! | [`texels`] | which texels are compared, and their values in every image |
//! | [`mod@groups`] | which directions are left out together |
//! | [`prediction`] | predictions from the rest, and their errors |
//! | [`errors`] | errors, whole and by angle |

mod errors;
mod groups;
mod prediction;
mod texels;

pub use crate::render::held_out::errors::{AngleError, ErrorSum, HeldOutErrors};
pub use crate::render::held_out::groups::{LeaveOut, MOST_HELD};
pub use crate::render::held_out::texels::MOST_TEXELS;

use crate::btf::sample::Sample;
use crate::error::Result;
use crate::progress::Progress;
use crate::render::held_out::groups::groups;
use crate::render::held_out::prediction::{Held, Trial};
use crate::render::held_out::texels::ComparedTexels;
use crate::render::nearest::Weighting;

/// What was left out, how it was predicted, and the errors.
#[derive(Clone, Debug)]
pub struct HeldOutPart {
    /// `lights`, `views` or `pairs`.
    pub held: &'static str,
    /// How the rest was weighted.
    pub weighting: Weighting,
    /// How many were left out, and of how many.
    pub directions: (usize, usize),
    /// The errors, by the angle of what was left out; of a pair, its light.
    pub errors: HeldOutErrors,
}

/// The outcome of all trials.
#[derive(Clone, Debug)]
pub struct HeldOutReport {
    /// Texels compared, and texels in all.
    pub texels: (usize, usize),
    /// One part for each way of leaving out and each weighting; none where there is nothing to predict from.
    pub parts: Vec<HeldOutPart>,
}

/// Leaves directions of a sample out and measures how well the others predict them.
pub fn measure(
    sample: &Sample,
    leave_out: LeaveOut,
    seed: u64,
    progress: Progress<'_>,
) -> Result<HeldOutReport> {
    // Read the texels that are compared.
    let texels = ComparedTexels::read(sample, seed, progress)?;
    let mut parts = Vec::new();
    // Leave views out, then lights.
    for &held in Held::of(sample.description()) {
        let distinct = held.distinct(sample.description())?;
        if distinct.len() < 2 {
            continue;
        }
        let groups = groups(&distinct, leave_out, held.name(), seed);
        let trial = Trial {
            description: sample.description(),
            texels: &texels,
            held,
            distinct: &distinct,
        };
        let left_out = groups.iter().map(Vec::len).sum();
        let part = |(weighting, errors)| HeldOutPart {
            held: held.name(),
            weighting,
            directions: (left_out, distinct.len()),
            errors,
        };
        parts.extend(trial.run(&groups, progress)?.into_iter().map(part));
    }
    Ok(HeldOutReport {
        texels: (texels.count(), sample.grid().len()),
        parts,
    })
}

#[cfg(test)]
mod tests;
