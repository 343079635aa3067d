//! Whether exemplar, sites and options fit together, before any work is done; and what follows
//! from them.

mod own_windows;
mod site_levels;
mod space_level;
mod table_plan;
mod variant;

use crate::error::{Error, Result};
use crate::exemplar::neighbor_table::NeighborTable;
use crate::exemplar::space::Space;
use crate::exemplar::square_window::check_square;
use crate::neighborhood::Neighborhood;
use crate::sites::level::Sites;
use crate::synthesis::check::own_windows::{COHERENT_WIDTH, multiscale_levels, one_level};
use crate::synthesis::check::site_levels::check_sites;
use crate::synthesis::check::space_level::space_level;
pub use crate::synthesis::check::table_plan::{Plan, complete, fitting_levels};
use crate::synthesis::check::variant::{check_controls, variant_levels, variant_neighborhoods};
use crate::synthesis::inputs::Inputs;
use crate::synthesis::metric::of_level::gram;
use crate::synthesis::options::{Method, MetricKind, SynthesisOptions, needs_faces};

/// Checks everything and completes the options.
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
    check_sites(inputs.sites, &neighborhoods_of(inputs.table, &plan))?;
    Ok(plan)
}

fn neighborhoods_of<'a>(table: &'a NeighborTable, plan: &Plan) -> Vec<&'a Neighborhood> {
    let levels = table.levels[..plan.levels].iter();
    levels.map(|level| &level.neighborhood).collect()
}

/// Completes the options of any method. What `synth` must know before it prepares a target.
pub fn complete_for(
    space: &Space,
    table: &NeighborTable,
    options: &SynthesisOptions,
) -> Result<Plan> {
    let levels = match options.method {
        Method::KCoherence | Method::WeiLevoy => return complete(space, table, options),
        Method::Progressive => return variant_levels(space, table, options),
        Method::Adaptive => round_levels(space, options)?,
        Method::Multiscale => multiscale_levels(space, options)?,
        Method::Coherent => one_level(space, options)?,
        Method::Choosy => return Err(needs_faces()),
    };
    Ok(Plan { levels, k: 1 })
}

/// The square windows that a method compares on its levels, finest first: what a target is prepared for. None for
/// a method with round neighbourhoods.
pub fn neighborhoods(
    space: &Space,
    table: &NeighborTable,
    options: &SynthesisOptions,
) -> Result<Vec<Neighborhood>> {
    planned_neighborhoods(table, &complete_for(space, table, options)?, options)
}

/// The same for options that are completed already.
pub fn planned_neighborhoods(
    table: &NeighborTable,
    plan: &Plan,
    options: &SynthesisOptions,
) -> Result<Vec<Neighborhood>> {
    Ok(match options.method {
        Method::KCoherence | Method::WeiLevoy => {
            neighborhoods_of(table, plan).into_iter().cloned().collect()
        }
        Method::Adaptive => Vec::new(),
        Method::Multiscale => options.multiscale.neighborhoods(plan.levels),
        Method::Coherent => vec![Neighborhood::square(COHERENT_WIDTH, 0)],
        Method::Progressive => variant_neighborhoods(table, plan, options),
        Method::Choosy => return Err(needs_faces()),
    })
}

/// Checks inputs of the multiscale method, and says what windows it compares on each level.
pub fn multiscale<const N: usize, S: Sites<N>>(
    inputs: Inputs<'_, S>,
    options: &SynthesisOptions,
) -> Result<Vec<Neighborhood>> {
    let levels = multiscale_levels(inputs.space, options)?;
    let neighborhoods = options.multiscale.neighborhoods(levels);
    check_sites(inputs.sites, &neighborhoods.iter().collect::<Vec<_>>())?;
    Ok(neighborhoods)
}

/// Checks inputs of the progressive method and completes its options.
pub fn progressive<const N: usize, S: Sites<N>>(
    inputs: Inputs<'_, S>,
    options: &SynthesisOptions,
) -> Result<Plan> {
    exemplar(inputs.space, inputs.table)?;
    let plan = variant_levels(inputs.space, inputs.table, options)?;
    check_controls(inputs)?;
    let neighborhoods = variant_neighborhoods(inputs.table, &plan, options);
    check_sites(inputs.sites, &neighborhoods.iter().collect::<Vec<_>>())?;
    Ok(plan)
}

/// Checks inputs of the coherent method.
pub fn coherent<const N: usize, S: Sites<N>>(
    inputs: Inputs<'_, S>,
    options: &SynthesisOptions,
) -> Result<()> {
    one_level(inputs.space, options)?;
    match inputs.sites.levels.first().map_or(0, Sites::count) {
        0 => Err(Error::data("target", "no sites").expected("one or more")),
        _ => Ok(()),
    }
}

/// Checks inputs of a method with round neighbourhoods of its own, and says how many levels it has.
pub fn round<const N: usize, S: Sites<N>>(
    inputs: Inputs<'_, S>,
    options: &SynthesisOptions,
) -> Result<usize> {
    for (index, level) in inputs.space.levels.iter().enumerate() {
        space_level(level, index)?;
    }
    let levels = round_levels(inputs.space, options)?;
    match inputs.sites.levels.len() {
        there if there < levels => Err(Error::option(
            "levels",
            format!("{levels}, but the target has {there}"),
            format!("at most {there}"),
        )),
        _ => Ok(levels),
    }
}

/// The levels of a method with round neighbourhoods, on each of which they must fit the exemplar.
fn round_levels(space: &Space, options: &SynthesisOptions) -> Result<usize> {
    options.validate()?;
    let most = space.levels.len();
    let levels = options.adaptive_levels(most);
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
