//! How many levels the windows fit and what memory they take, and whether surface and exemplar have the same controls.

use crate::error::{Error, Result};
use crate::exemplar::controls::{ControlKind, MASK_LABELS};
use crate::exemplar::neighbor_table::NeighborTable;
use crate::exemplar::space::{Features, Space, SpaceLevel};
use crate::neighborhood::{Neighborhood, window_width};
use crate::sites::level::Sites;
use crate::synthesis::check::levels::{fitting, too_wide};
use crate::synthesis::check::{Plan, check_exemplar, check_sites, complete};
use crate::synthesis::inputs::Inputs;
use crate::synthesis::options::SynthesisOptions;

/// Checks that surface and sites have what the exemplar and a plan need.
pub fn check_surface<const N: usize, S: Sites<N>>(
    inputs: Inputs<'_, S>,
    (options, plan): (&SynthesisOptions, &Plan),
) -> Result<()> {
    check_controls(inputs)?;
    check_sites(inputs.sites, &windows(inputs.table, plan, options))
}

/// The levels: those asked for, else all of the table that the windows fit.
pub fn plan(space: &Space, table: &NeighborTable, options: &SynthesisOptions) -> Result<Plan> {
    check_exemplar(space, table)?;
    let plan = complete(space, table, options)?;
    // Check that a table for a transition knows its tolerance.
    let controls = space.controls.first();
    let varies = controls.is_some_and(|controls| controls.has(ControlKind::Transition));
    if varies && table.transition_tolerance.is_none() {
        return Err(Error::data("neighbour table", "no transition tolerance")
            .expected("one, as the exemplar has a transition")
            .advice("build it with knn --transition-tolerance 0.1"));
    }
    // Count the levels that the windows fit.
    let widest = options.progressive.widest();
    let fitting = fitting(space, plan.levels, |_| widest);
    if fitting == plan.levels || (options.levels.is_none() && fitting > 0) {
        return Ok(Plan {
            levels: fitting,
            ..plan
        });
    }
    // Name the window that is too wide.
    let option = match options.progressive.mask_window.widest() == widest {
        true => "mask-window",
        false => "color-window",
    };
    Err(too_wide(option, widest, space, fitting))
}

/// The square windows that sites need on each level, finest first.
pub fn windows(
    table: &NeighborTable,
    plan: &Plan,
    options: &SynthesisOptions,
) -> Vec<Neighborhood> {
    let of_level = |level: usize| {
        let coarse = &table.levels[level].neighborhood.coarse_offsets;
        let coarse = match level + 1 == plan.levels {
            true => 0,
            false => window_width(coarse),
        };
        Neighborhood::square(options.progressive.widest(), coarse)
    };
    (0..plan.levels).map(of_level).collect()
}

/// Whether the surface has what the exemplar has, as far as one is nothing without the other.
fn check_controls<const N: usize, S: Sites<N>>(inputs: Inputs<'_, S>) -> Result<()> {
    let of_exemplar = inputs.space.controls.first();
    let has = |kind| of_exemplar.is_some_and(|controls| controls.has(kind));
    let sites = inputs.sites.levels.first().map_or(0, Sites::count);
    // Check the transition: both have one, or neither.
    let Some(controls) = inputs.controls else {
        return match has(ControlKind::Transition) {
            false => Ok(()),
            true => Err(
                Error::data("transition", "of the exemplar, none of the surface")
                    .expected("both")
                    .advice("give --keys FILE.json, or a mesh with the property `transition`"),
            ),
        };
    };
    if controls.transition.len() != sites {
        let found = format!("{} values", controls.transition.len());
        return Err(Error::data("transition of the surface", found)
            .expected(format!("one for each of {sites} sites")));
    }
    if !has(ControlKind::Transition) && controls.transition.iter().any(|&value| value != 0.0) {
        return Err(
            Error::data("transition", "of the surface, none of the exemplar")
                .expected("both")
                .advice("make the exemplar with vary, or exemplar --transition FILE"),
        );
    }
    // Check the painted labels.
    let Some(painted) = &controls.mask else {
        return Ok(());
    };
    let Some(mask) = of_exemplar.and_then(|controls| controls.mask.as_ref()) else {
        return Err(Error::data("mask", "of the surface, none of the exemplar")
            .expected("both")
            .advice("make the exemplar with exemplar --mask FILE"));
    };
    let largest = mask.iter().max().copied().unwrap_or_default();
    match painted.iter().position(|&label| label > largest) {
        None => Ok(()),
        Some(site) => Err(Error::data(
            format!("mask of the surface, site {site}"),
            format!("label {}", painted[site]),
        )
        .expected(format!("a label of the exemplar, 0 to {largest}"))),
    }
}

/// Bytes of the windows that are resampled.
pub fn window_bytes(space: &Space, options: &SynthesisOptions) -> u64 {
    let levels = space.levels.iter();
    levels.map(|level| level_bytes(level, options)).sum()
}

/// Bytes of the windows of a level: its colours at most twice, for the
/// level itself and for the one below.
fn level_bytes(level: &SpaceLevel, options: &SynthesisOptions) -> u64 {
    let dimensions = match &level.features {
        Features::Textons { gram, .. } => gram.nrows(),
        Features::Plain(vectors) => vectors.dim().2,
    };
    let samples = |width: u32| u64::from(width).pow(2);
    let asked = &options.progressive;
    let numbers = dimensions as u64 * samples(asked.color_window.widest())
        + u64::from(MASK_LABELS) * samples(asked.widest());
    2 * 4 * level.grid.len() as u64 * numbers
}
