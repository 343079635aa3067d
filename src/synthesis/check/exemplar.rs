//! Whether a space and a neighbour table are sound and belong together.

use crate::error::{Error, Result};
use crate::exemplar::neighbor_table::NeighborTable;
use crate::exemplar::space::Space;
use crate::exemplar::square_window::check_square;
use crate::neighborhood::Neighborhood;
use crate::synthesis::check::space_level::space_level;

/// Checks that a space and a table are sound and describe the same texels; ids are for
/// [`NeighborTable::check_belongs_to`].
pub fn check_exemplar(space: &Space, table: &NeighborTable) -> Result<()> {
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
