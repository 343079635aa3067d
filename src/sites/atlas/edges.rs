//! Pairs of texels side by side on the surface, and triangles between them.

use glam::Vec3;
use rayon::prelude::*;

use super::level_cells::LevelCells;
use super::texels::LevelTexels;
use crate::sites::level::SiteEdge;

/// Every texel with the one to its right and the one below it, across charts' borders too; sorted, each pair
/// once.
pub fn edges(level: &LevelTexels, cells: &LevelCells<'_>) -> Vec<SiteEdge> {
    let mut pairs: Vec<[u32; 2]> = (0..level.texels.len() as u32)
        .into_par_iter()
        .flat_map_iter(|site| {
            let [_, right, below, _] = cells.sites_from(site as usize);
            let pairs = [right, below].into_iter();
            pairs
                .filter(move |&other| other != site)
                .map(move |other| [site.min(other), site.max(other)])
        })
        .collect();
    pairs.par_sort_unstable();
    pairs.dedup();
    let edge = |&[from, to]: &[u32; 2]| {
        let apart = level.positions[to as usize] - level.positions[from as usize];
        SiteEdge {
            from,
            to,
            offset: level.seen_from(from as usize, apart),
        }
    };
    pairs.par_iter().map(edge).collect()
}

/// Triangles between the texels of a level: two in every cell of four. Over the border of two charts the cells
/// of both lie, so that no gap is left.
pub fn triangles(level: &LevelTexels, cells: &LevelCells<'_>) -> Vec<[u32; 3]> {
    let halves = |[a, b, c, d]: &[u32; 4]| [[*a, *c, *d], [*a, *d, *b]];
    let mut triangles: Vec<[u32; 3]> = cells
        .cells()
        .par_iter()
        .flat_map_iter(|cell| halves(cell).into_iter())
        .filter_map(|triangle| facing_out(level, triangle))
        .collect();
    triangles.par_sort_unstable();
    triangles.dedup();
    triangles
}

/// A triangle turned to face as the surface does, its smallest site first; `None` where it has no
/// area.
fn facing_out(level: &LevelTexels, triangle: [u32; 3]) -> Option<[u32; 3]> {
    let [p, q, r] = triangle.map(|site| level.positions[site as usize]);
    let normal = (q - p).cross(r - p);
    let [a, b, c] = triangle;
    let is_one = a != b && b != c && c != a && normal.length_squared() > 0.0;
    if !is_one {
        return None;
    }
    let around: Vec3 = triangle
        .iter()
        .map(|&site| level.frames[site as usize].n)
        .sum();
    // A chart may lie in the texture as in a mirror.
    let turned = match normal.dot(around) < 0.0 {
        true => [a, c, b],
        false => [a, b, c],
    };
    let first = (0..3).min_by_key(|&k| turned[k])?;
    Some(std::array::from_fn(|k| turned[(first + k) % 3]))
}
