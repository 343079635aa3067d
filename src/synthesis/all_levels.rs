//! All levels of a map, by the method that the options name.

use crate::error::{Error, Result};
use crate::progress::Progress;
use crate::sites::level::{SiteHierarchy, Sites};
use crate::synthesis::check::{Plan, complete_for};
use crate::synthesis::inputs::{Inputs, LevelMap};
use crate::synthesis::options::SynthesisOptions;

/// Synthesizes all levels and returns the finest.
///
/// `finished` is handed every level when it is done; `begun` is one that an earlier run of the same
/// inputs and options finished. Errors: inputs and options that do not fit
/// ([`check`](crate::synthesis::check)), and [`Error::Interrupted`].
pub fn synthesize<const N: usize, S: Sites<N>>(
    inputs: Inputs<'_, S>,
    options: &SynthesisOptions,
    begun: Option<LevelMap>,
    finished: &mut dyn FnMut(&LevelMap) -> Result<()>,
    progress: Progress<'_>,
) -> Result<LevelMap> {
    let plan = complete_for(inputs.space, inputs.table, options)?;
    synthesize_planned(inputs, (options, &plan), begun, finished, progress)
}

/// The same by a plan, which [`complete_for`] made of this exemplar and these options.
pub(crate) fn synthesize_planned<const N: usize, S: Sites<N>>(
    inputs: Inputs<'_, S>,
    (options, plan): (&SynthesisOptions, &Plan),
    begun: Option<LevelMap>,
    finished: &mut dyn FnMut(&LevelMap) -> Result<()>,
    progress: Progress<'_>,
) -> Result<LevelMap> {
    if let Some(map) = &begun {
        check_begun(inputs.sites, map)?;
    }
    let method = options.method;
    method.synthesize(inputs, (options, plan), begun, finished, progress)
}

/// Refuses a finished level that these sites do not have.
fn check_begun<const N: usize, S: Sites<N>>(
    sites: &SiteHierarchy<S>,
    map: &LevelMap,
) -> Result<()> {
    let level = map.level.index();
    let wanted = sites.levels.get(level).map(Sites::count);
    if wanted == Some(map.coords.len()) {
        return Ok(());
    }
    let expected = wanted.map_or("a level of the target".into(), |count| {
        format!("{count} sites")
    });
    let found = format!("{} coordinates", map.coords.len());
    Err(Error::data(format!("finished level {level}"), found).expected(expected))
}
