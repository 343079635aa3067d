//! Whether exemplar, sites and options fit together, before any work is done; and what follows
//! from them.

pub(super) mod levels;
mod site_levels;
mod space_level;
pub(super) mod table_plan;

use crate::error::{Error, Result};
use crate::exemplar::neighbor_table::NeighborTable;
use crate::exemplar::space::Space;
use crate::exemplar::square_window::check_square;
use crate::neighborhood::Neighborhood;
use crate::sites::level::Sites;
pub use crate::synthesis::check::site_levels::check_sites;
pub use crate::synthesis::check::space_level::space_level;
use crate::synthesis::check::table_plan::table_windows;
pub use crate::synthesis::check::table_plan::{Plan, complete, fitting_levels};
use crate::synthesis::inputs::Inputs;
use crate::synthesis::method::MethodSites;
use crate::synthesis::metric::of_level::gram;
use crate::synthesis::options::{MetricKind, SynthesisOptions};

/// Checks everything that a method of the table's windows needs, and completes the options.
pub fn plan<const N: usize, S: Sites<N>>(
    inputs: Inputs<'_, S>,
    options: &SynthesisOptions,
) -> Result<Plan> {
    exemplar(inputs.space, inputs.table)?;
    let plan = complete(inputs.space, inputs.table, options)?;
    if options.metric == MetricKind::Gram {
        inputs
            .space
            .levels
            .iter()
            .try_for_each(|level| gram(level).map(drop))?;
    }
    check_sites(inputs.sites, &table_windows(inputs.table, &plan))?;
    Ok(plan)
}

/// Completes the options of any method. What `synth` must know before it prepares a target.
pub fn complete_for(
    space: &Space,
    table: &NeighborTable,
    options: &SynthesisOptions,
) -> Result<Plan> {
    (options.method.description().plan)(space, table, options)
}

/// The square windows that a method compares on its levels, finest first: what a target is prepared for. None for
/// a method with other neighbourhoods.
pub fn neighborhoods(
    space: &Space,
    table: &NeighborTable,
    options: &SynthesisOptions,
) -> Result<Vec<Neighborhood>> {
    let plan = complete_for(space, table, options)?;
    Ok(planned_neighborhoods(table, &plan, options))
}

/// The same for options that are completed already.
pub fn planned_neighborhoods(
    table: &NeighborTable,
    plan: &Plan,
    options: &SynthesisOptions,
) -> Vec<Neighborhood> {
    match options.method.description().sites {
        MethodSites::Windows(windows) => windows(table, plan, options),
        MethodSites::Circles(_) | MethodSites::Faces => Vec::new(),
    }
}

/// Checks that a space and a table are sound and describe the same texels; ids are for
/// [`NeighborTable::check_belongs_to`].
pub fn exemplar(space: &Space, table: &NeighborTable) -> Result<()> {
    // Check that both have the same levels.
    if space.levels.is_empty() || space.levels.len() != table.levels.len() {
        return Err(differ(
            format!("{} levels", table.levels.len()),
            format!("{} levels, as the space has", space.levels.len()),
        ));
    }
    // Check that they have the same texels.
    for (index, (level, listed)) in space.levels.iter().zip(&table.levels).enumerate() {
        space_level(level, index)?;
        let (texels, k) = listed.neighbors.dim();
        if texels != level.grid.len() || k != table.k || k == 0 {
            return Err(differ(
                format!("L{index}: neighbours of {texels} texels, {k} each"),
                format!(
                    "{} texels, as the space has, {} each",
                    level.grid.len(),
                    table.k.max(1)
                ),
            ));
        }
        if level.grid.tileable != table.tileable {
            return Err(differ(
                format!("tileable: {}", table.tileable),
                format!("{}, as the space is", level.grid.tileable),
            ));
        }
        // Check that the neighbours are texels.
        let out = listed
            .neighbors
            .iter()
            .find(|&&texel| texel as usize >= texels);
        if let Some(texel) = out {
            return Err(differ(
                format!("L{index}: texel {texel} among the neighbours"),
                format!("texels below {texels}"),
            ));
        }
        neighborhood(&listed.neighborhood, index)?;
    }
    Ok(())
}

fn differ(found: String, expected: String) -> Error {
    Error::data("neighbour table", found)
        .expected(expected)
        .advice("space and table are of different runs: make the table anew with knn")
}

fn neighborhood(neighborhood: &Neighborhood, index: usize) -> Result<()> {
    let Neighborhood {
        offsets,
        weights,
        coarse_offsets,
        coarse_weights,
    } = neighborhood;
    let sound = |weight: &f32| *weight > 0.0 && weight.is_finite();
    let matched = offsets.len() == weights.len() && coarse_offsets.len() == coarse_weights.len();
    if !offsets.is_empty() && matched && weights.iter().chain(coarse_weights).all(sound) {
        let named = |field: &str| format!("neighbour table, L{index}: {field}");
        check_square(&named("offsets"), offsets)?;
        return match coarse_offsets.is_empty() {
            true => Ok(()),
            false => check_square(&named("coarse_offsets"), coarse_offsets),
        };
    }
    Err(Error::data(
        format!("neighbour table, L{index}: offsets and weights"),
        format!(
            "{} offsets with {} weights, {} coarse ones with {}",
            offsets.len(),
            weights.len(),
            coarse_offsets.len(),
            coarse_weights.len()
        ),
    )
    .expected("a positive weight per offset"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::neighborhood::{square_window, window_width};
    use crate::synthesis::tests::fixtures;

    /// What becomes of a table of 2 levels, 16×16 and 8×8, windows 5 and 3, with something altered.
    fn refused(change: impl FnOnce(&mut NeighborTable)) -> String {
        let (space, mut table) = fixtures::random_exemplar(1, 16, 2, true);
        change(&mut table);
        let checked = exemplar(&space, &table).and_then(|()| {
            let options = SynthesisOptions {
                levels: Some(2),
                ..SynthesisOptions::default()
            };
            complete(&space, &table, &options).map(drop)
        });
        checked.unwrap_err().to_string()
    }

    #[test]
    fn windows_that_are_no_squares_are_refused_by_name() {
        let text = refused(|table| table.levels[1].neighborhood.offsets.swap(3, 4));
        let expected = "L1: offsets[3]: [-2, 2]; expected [-2, 1]: the square of width 5";
        assert!(text.contains(expected), "{text}");
        let text = refused(|table| table.levels[0].neighborhood.coarse_offsets.swap(0, 8));
        assert!(
            text.contains("L0: coarse_offsets[0]: [1, 1]; expected [-1, -1]"),
            "{text}"
        );
        let text = refused(|table| {
            let neighborhood = &mut table.levels[0].neighborhood;
            neighborhood.offsets.truncate(24);
            neighborhood.weights.truncate(24);
        });
        assert!(
            text.contains("L0: offsets: 24 offsets; expected a square"),
            "{text}"
        );
    }

    #[test]
    fn steps_without_bounds_are_refused_before_they_are_added_up() {
        for step in [i32::MIN, i32::MIN + 1, i32::MAX] {
            let text = refused(|table| table.levels[0].neighborhood.offsets[7] = [step, 0]);
            assert!(text.contains("L0: offsets[7]"), "{text}");
            let text = refused(|table| table.levels[0].neighborhood.coarse_offsets[7] = [0, step]);
            assert!(text.contains("L0: coarse_offsets[7]"), "{text}");
            assert_eq!(window_width(&[[step, 0]]), u32::MAX);
        }
        assert_eq!(window_width(&square_window(7)), 7);
    }

    #[test]
    fn windows_beyond_the_sample_are_refused() {
        let wide = |table: &mut NeighborTable, level: usize, width: u32| {
            let neighborhood = &mut table.levels[level].neighborhood;
            neighborhood.offsets = square_window(width);
            neighborhood.weights = vec![1.0; neighborhood.offsets.len()];
        };
        let text = refused(|table| wide(table, 1, 9));
        assert!(
            text.contains("9 texels wide on the sample's level 1 of 8×8"),
            "{text}"
        );
        let text = refused(|table| wide(table, 0, 17));
        assert!(
            text.contains("17 texels wide on the sample's level 0 of 16×16"),
            "{text}"
        );
        let coarse = |width: u32| {
            move |table: &mut NeighborTable| {
                let neighborhood = &mut table.levels[0].neighborhood;
                neighborhood.coarse_offsets = square_window(width);
                neighborhood.coarse_weights = vec![1.0; neighborhood.coarse_offsets.len()];
            }
        };
        let text = refused(coarse(17));
        assert!(
            text.contains("L0: coarse_offsets: steps of 8 texels; expected below 8"),
            "{text}"
        );
        let (space, mut table) = fixtures::random_exemplar(1, 16, 2, true);
        coarse(15)(&mut table);
        complete(&space, &table, &SynthesisOptions::default()).unwrap();
    }
}
