//! How many levels of an exemplar the windows fit, and whether the sites have them.

use crate::error::{Error, Result};
use crate::exemplar::space::Space;
use crate::neighborhood::Neighborhood;
use crate::sites::level::Sites;
use crate::synthesis::check::{check_sites, space_level};
use crate::synthesis::inputs::Inputs;
use crate::synthesis::metric::of_level::gram;
use crate::synthesis::options::{MetricKind, SynthesisOptions};

/// Checks the inputs, and says what windows are compared on each level.
pub fn check<const N: usize, S: Sites<N>>(
    inputs: Inputs<'_, S>,
    options: &SynthesisOptions,
) -> Result<Vec<Neighborhood>> {
    let levels = levels(inputs.space, options)?;
    let neighborhoods = options.multiscale.neighborhoods(levels);
    check_sites(inputs.sites, &neighborhoods)?;
    Ok(neighborhoods)
}

/// The levels: those asked for, else all that its windows fit.
pub fn levels(space: &Space, options: &SynthesisOptions) -> Result<usize> {
    options.validate()?;
    // Check each level.
    for (index, level) in space.levels.iter().enumerate() {
        space_level(level, index)?;
        if options.metric == MetricKind::Gram {
            gram(level)?;
        }
    }
    // Count the levels that the windows fit.
    let side = |level: usize| {
        let grid = space.levels[level].grid;
        grid.width.min(grid.height)
    };
    let widest = |level: usize| options.multiscale.widest_on(level);
    let all = 0..space.levels.len();
    let fitting = all
        .take_while(|&level| widest(level) <= side(level))
        .count();
    // Take the levels that were asked for.
    let asked = options.levels.map(|levels| levels as usize);
    if let Some(levels) = asked.filter(|&levels| levels > space.levels.len()) {
        return Err(Error::option(
            "levels",
            format!("{levels}, but the sample has {}", space.levels.len()),
            format!("at most {}", space.levels.len()),
        ));
    }
    let levels = asked.unwrap_or(fitting.max(1));
    if levels <= fitting {
        return Ok(levels);
    }
    // Name the window that is too wide.
    let Some(grid) = space.levels.get(fitting).map(|level| level.grid) else {
        return Err(Error::data("space", "no level").expected("one or more"));
    };
    let option = match widest(fitting) == options.multiscale.window {
        true => "window",
        false => "parent-window",
    };
    Err(Error::option(
        option,
        format!(
            "{} texels on the sample's level {fitting} of {}×{}",
            widest(fitting),
            grid.width,
            grid.height
        ),
        match fitting {
            0 => format!("at most {}", side(0)),
            _ => format!("at most {}, or --levels {fitting}", side(fitting)),
        },
    ))
}
