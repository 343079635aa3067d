//! Whether exemplar, sites and options fit together, before any work is done; and what follows
//! from them.

mod exemplar;
pub(super) mod levels;
mod site_levels;
mod space_level;
pub(super) mod table_plan;

use crate::error::Result;
use crate::exemplar::neighbor_table::NeighborTable;
use crate::exemplar::space::Space;
use crate::neighborhood::Neighborhood;
pub use crate::synthesis::check::exemplar::check_exemplar;
pub use crate::synthesis::check::site_levels::check_sites;
pub use crate::synthesis::check::space_level::space_level;
pub use crate::synthesis::check::table_plan::{Plan, complete, fitting_levels, table_windows};
use crate::synthesis::method::MethodSites;
use crate::synthesis::options::SynthesisOptions;

/// Checks that an exemplar and the options of any method fit together, and completes the options: what `synth` must
/// know before it prepares a target, and what the engine works by.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::neighborhood::{square_window, window_width};
    use crate::synthesis::check::table_plan::plan;
    use crate::synthesis::options::Method;
    use crate::synthesis::tests::fixtures;

    /// What becomes of a table of 2 levels, 16×16 and 8×8, windows 5 and 3, with something altered.
    fn refused(change: impl FnOnce(&mut NeighborTable)) -> String {
        let (space, mut table) = fixtures::random_exemplar(1, 16, 2, true);
        change(&mut table);
        let options = SynthesisOptions {
            levels: Some(2),
            ..SynthesisOptions::default()
        };
        let refused = plan(&space, &table, &options).unwrap_err();
        refused.to_string()
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
    fn a_table_of_other_levels_is_refused() {
        let (mut space, table) = fixtures::random_exemplar(1, 16, 2, true);
        space.levels.truncate(1);
        let refused = neighborhoods(&space, &table, &SynthesisOptions::default());
        let text = refused.unwrap_err().to_string();
        assert!(text.contains("neighbour table: 2 levels"), "{text}");
        space.levels.clear();
        for method in [Method::KCoherence, Method::Multiscale, Method::Adaptive] {
            let options = SynthesisOptions {
                method,
                ..SynthesisOptions::default()
            };
            complete_for(&space, &table, &options).unwrap_err();
        }
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
        plan(&space, &table, &SynthesisOptions::default()).unwrap();
    }
}
