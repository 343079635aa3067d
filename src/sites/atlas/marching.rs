//! Sampling by surface marching (Ying 2001 §4.1): a straight path to every sample of a neighbourhood, over
//! smoothed geometry.

use rayon::prelude::*;

use super::collecting::{Block, LevelSamples, Window, join};
use super::geometry::Geometry;
use super::level_cells::LevelCells;
use super::paths::Paths;
use super::texels::LevelTexels;
use crate::error::Result;
use crate::mesh::triangle_mesh::TriangleMesh;
use crate::progress::Progress;

/// Sites per block.
const BLOCK: usize = 1024;

/// The samples of a window at every site of a level.
pub fn sample(
    (geometry, marched): (&Geometry<'_>, &TriangleMesh),
    (level, cells): (&LevelTexels, &LevelCells<'_>),
    window: Window<'_>,
    progress: Progress<'_>,
) -> Result<LevelSamples> {
    let count = level.texels.len();
    let blocks: Vec<Block> = (0..count.div_ceil(BLOCK))
        .into_par_iter()
        .map(|block| {
            let mut out = Block::default();
            for site in block * BLOCK..((block + 1) * BLOCK).min(count) {
                progress.check()?;
                let paths = Paths::new((geometry, marched), level, site);
                let offsets = window.template.positions.iter();
                let points = offsets.map(|&offset| paths.end(offset));
                out.take((level, cells), window, site, points);
            }
            Ok(out)
        })
        .collect::<Result<_>>()?;
    join((level, cells), window, blocks)
}
