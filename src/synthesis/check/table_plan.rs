//! Options of methods that compare the neighbour table's windows, completed by space and table.

use crate::error::{Error, Result};
use crate::exemplar::neighbor_table::NeighborTable;
use crate::exemplar::space::Space;
use crate::neighborhood::{Neighborhood, window_width};
use crate::synthesis::check::exemplar::check_exemplar;
use crate::synthesis::check::levels::{asked_or, fitting, shorter_side, wide_on};
use crate::synthesis::metric::of_level::gram;
use crate::synthesis::options::{MetricKind, SynthesisOptions};

/// Options as the inputs complete them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Plan {
    /// Levels that are synthesized.
    pub levels: usize,
    /// Neighbours per texel that are used.
    pub k: usize,
}

impl Plan {
    /// The plan of a method that takes nothing but levels from the exemplar.
    pub fn of_levels(levels: usize) -> Self {
        Self { levels, k: 1 }
    }
}

/// The table's windows on the levels of a plan, finest first.
pub fn table_windows(table: &NeighborTable, plan: &Plan) -> Vec<Neighborhood> {
    let levels = table.levels[..plan.levels].iter();
    levels.map(|level| level.neighborhood.clone()).collect()
}

/// Checks everything that a method of the table's windows needs of exemplar and options, and completes the options.
pub fn plan(space: &Space, table: &NeighborTable, options: &SynthesisOptions) -> Result<Plan> {
    check_exemplar(space, table)?;
    let plan = complete(space, table, options)?;
    if options.metric == MetricKind::Gram {
        let mut levels = space.levels.iter();
        levels.try_for_each(|level| gram(level).map(drop))?;
    }
    Ok(plan)
}

/// Checks options against the windows of a sound exemplar: k, levels, neighbourhood.
pub fn complete(space: &Space, table: &NeighborTable, options: &SynthesisOptions) -> Result<Plan> {
    options.validate()?;
    let k = options.k_coherence.k.unwrap_or(table.k);
    if k > table.k {
        return Err(Error::option(
            "k",
            format!("{k} neighbours per texel, but the table lists {}", table.k),
            format!("at most {}, or a table made with knn --k {k}", table.k),
        ));
    }
    let most = space.levels.len().min(table.levels.len());
    let levels = asked_or(most, options.levels, fitting_levels(space, table).max(1))?;
    neighborhood_width(table, options)?;
    template_fits_the_sample(space, table, levels)?;
    Ok(Plan { levels, k })
}

fn neighborhood_width(table: &NeighborTable, options: &SynthesisOptions) -> Result<()> {
    let Some(asked) = options.neighborhood else {
        return Ok(());
    };
    let width = window_width(&table.levels[0].neighborhood.offsets);
    if asked == width {
        return Ok(());
    }
    Err(Error::option(
        "neighborhood",
        format!("{asked}, but the table's is {width}"),
        format!("{width}, or a table made with knn --neighborhood {asked}"),
    ))
}

fn template_fits_the_sample(space: &Space, table: &NeighborTable, levels: usize) -> Result<()> {
    let fitting = fitting_levels(space, table).min(levels);
    if fitting == levels {
        return (1..levels).try_for_each(|level| {
            let offsets = &table.levels[level - 1].neighborhood.coarse_offsets;
            coarse_window_fits(offsets, level, shorter_side(space, level))
        });
    }
    let width = window_width(&table.levels[fitting].neighborhood.offsets);
    let found = format!("a neighbourhood {}", wide_on(space, fitting, width));
    Err(match fitting {
        0 => Error::data("neighbour table", found)
            .advice("make it with a smaller knn --neighborhood"),
        count => Error::option(
            "levels",
            format!("{levels}: {found}"),
            format!("at most {count}, or a smaller knn --neighborhood"),
        ),
    })
}

/// The finest levels of a sample that are no narrower than the table's windows.
pub fn fitting_levels(space: &Space, table: &NeighborTable) -> usize {
    fitting(space, table.levels.len(), |level| {
        window_width(&table.levels[level].neighborhood.offsets)
    })
}

/// Refuses a window on the parent level `level` that reaches beyond the level's shorter side: every sample
/// would lie off the grid, or be one that the window holds already.
fn coarse_window_fits(offsets: &[[i32; 2]], level: usize, side: u32) -> Result<()> {
    let reach = window_width(offsets) / 2;
    if reach < side {
        return Ok(());
    }
    let place = format!("neighbour table, L{}: coarse_offsets", level - 1);
    Err(Error::data(place, format!("steps of {reach} texels"))
        .expected(format!("below {side}, the shorter side of level {level}"))
        .advice("make it with a smaller knn --coarse-neighborhood"))
}
