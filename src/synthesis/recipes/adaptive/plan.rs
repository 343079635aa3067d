//! How many levels the round neighbourhoods fit, and whether the sites have them.

use crate::error::{Error, Result};
use crate::exemplar::space::Space;
use crate::sites::level::Sites;
use crate::synthesis::check::space_level;
use crate::synthesis::inputs::Inputs;
use crate::synthesis::options::SynthesisOptions;

/// Checks the inputs, and says how many levels there are.
pub fn check<const N: usize, S: Sites<N>>(
    inputs: Inputs<'_, S>,
    options: &SynthesisOptions,
) -> Result<usize> {
    for (index, level) in inputs.space.levels.iter().enumerate() {
        space_level(level, index)?;
    }
    let levels = levels(inputs.space, options)?;
    match inputs.sites.levels.len() {
        there if there < levels => Err(Error::option(
            "levels",
            format!("{levels}, but the target has {there}"),
            format!("at most {there}"),
        )),
        _ => Ok(levels),
    }
}

/// The levels, on each of which the neighbourhoods must fit the exemplar: two unless more are asked for, as the circles
/// of coarser levels are wide.
pub fn levels(space: &Space, options: &SynthesisOptions) -> Result<usize> {
    options.validate()?;
    let most = space.levels.len();
    let levels = options.levels.map_or(most.min(2), |levels| levels as usize);
    if levels > most {
        return Err(Error::option(
            "levels",
            format!("{levels}, but the sample has {most}"),
            format!("at most {most}"),
        ));
    }
    let Some(coarsest) = levels.checked_sub(1).map(|level| space.levels[level].grid) else {
        return Err(Error::data("space", "no level").expected("one or more"));
    };
    let rings = options.adaptive.rings;
    let width = 2 * rings + 1;
    if width <= coarsest.width.min(coarsest.height) {
        return Ok(levels);
    }
    Err(Error::option(
        "rings",
        format!(
            "{rings}: {width} texels wide on the sample's coarsest level of {}×{}",
            coarsest.width, coarsest.height
        ),
        "fewer rings, or fewer --levels",
    ))
}
