//! The place of every texel on the coarser level: both levels lie on the same surface, so that a texel's point
//! is its parent point.

use rayon::prelude::*;

use super::geometry::{Geometry, largest};
use super::level_cells::LevelCells;
use super::texels::LevelTexels;
use crate::sites::level::{Parent, SampleLocation};

/// The parents of a level's sites.
pub fn parents(
    geometry: &Geometry<'_>,
    level: &LevelTexels,
    (coarser, cells): (&LevelTexels, &LevelCells<'_>),
) -> Vec<Parent> {
    let parent = |site: usize| {
        let point = level.point(geometry, site);
        let parent = match cells.sample(&point).locate(cells.cells()) {
            SampleLocation::Outside => 0,
            SampleLocation::AtSite(parent) => parent,
            SampleLocation::Between(sites, weights) => sites[largest(weights)],
        };
        let apart = coarser.positions[parent as usize] - level.positions[site];
        let [x, y] = level.seen_from(site, apart);
        Parent {
            site: parent,
            x: x / 2.0,
            y: y / 2.0,
        }
    };
    (0..level.texels.len())
        .into_par_iter()
        .map(parent)
        .collect()
}
