//! How many levels the round neighbourhoods fit, and whether the sites have them.

use crate::error::{Error, Result};
use crate::exemplar::space::Space;
use crate::sites::level::SiteHierarchy;
use crate::synthesis::check::levels::{asked_or, at_most, fitting, shorter_side, wide_on};
use crate::synthesis::check::{Plan, space_level};
use crate::synthesis::options::SynthesisOptions;

/// The levels, on each of which the neighbourhoods must fit the exemplar: two unless more are asked for, as the circles
/// of coarser levels are wide.
pub fn levels(space: &Space, options: &SynthesisOptions) -> Result<usize> {
    options.validate()?;
    for (index, level) in space.levels.iter().enumerate() {
        space_level(level, index)?;
    }
    let most = space.levels.len();
    let levels = asked_or(most, options.levels, most.min(2))?;
    let rings = options.adaptive.rings;
    let width = 2 * rings + 1;
    let fitting = fitting(space, levels, |_| width);
    if fitting == levels {
        return Ok(levels);
    }
    let most = shorter_side(space, fitting).saturating_sub(1) / 2;
    Err(Error::option(
        "rings",
        format!("{rings}: {}", wide_on(space, fitting, width)),
        at_most(most, fitting),
    ))
}

/// Checks that there are sites on the levels of a plan.
pub fn check_levels<S>(sites: &SiteHierarchy<S>, plan: &Plan) -> Result<()> {
    let (levels, there) = (plan.levels, sites.levels.len());
    match levels <= there {
        true => Ok(()),
        false => Err(Error::option(
            "levels",
            format!("{levels}, but the target has {there}"),
            format!("at most {there}"),
        )),
    }
}
