//! Sampling by surface marching (Ying 2001 §4.1): a straight path to every sample of a neighbourhood, over
//! smoothed geometry.

use super::collecting::{LevelSamples, Window, site_by_site};
use super::geometry::Geometry;
use super::level_cells::LevelCells;
use super::paths::Paths;
use super::texels::LevelTexels;
use crate::error::Result;
use crate::mesh::triangle_mesh::TriangleMesh;
use crate::progress::Progress;

/// The samples of a window at every site of a level.
pub fn sample(
    (geometry, marched): (&Geometry<'_>, &TriangleMesh),
    (level, cells): (&LevelTexels, &LevelCells<'_>),
    window: Window<'_>,
    progress: Progress<'_>,
) -> Result<LevelSamples> {
    site_by_site((level, cells), window, progress, |site, out| {
        let paths = Paths::new((geometry, marched), level, site);
        let offsets = window.template.positions.iter();
        let points = offsets.map(|&offset| paths.end(offset));
        out.take((level, cells), window, site, points);
    })
}
