//! How many levels of an exemplar the windows fit.

use crate::error::Result;
use crate::exemplar::space::Space;
use crate::synthesis::check::levels::{asked_or, fitting, too_wide};
use crate::synthesis::check::space_level;
use crate::synthesis::metric::of_level::gram;
use crate::synthesis::options::{MetricKind, SynthesisOptions};

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
    // Take the levels that were asked for, else those that the windows fit.
    let most = space.levels.len();
    let widest = |level: usize| options.multiscale.widest_on(level);
    let fitting = fitting(space, most, widest);
    let levels = asked_or(most, options.levels, fitting.max(1))?;
    if levels <= fitting {
        return Ok(levels);
    }
    // Name the window that is too wide.
    let width = widest(fitting);
    let option = match width == options.multiscale.window {
        true => "window",
        false => "parent-window",
    };
    Err(too_wide(option, width, space, fitting))
}
