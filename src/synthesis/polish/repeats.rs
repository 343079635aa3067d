//! Texels that show more than once in a region.

use crate::grid::{TexCoord, TexelGrid};
use crate::synthesis::polish::region::Region;

/// Texels between two sites from which on the same texel shows twice.
const APART: f32 = 2.0;

/// The share of a region's sites whose texel is held farther off in the region too.
pub fn repeated(grid: TexelGrid, region: &Region, coords: &[TexCoord]) -> f32 {
    let texel = |at: usize| grid.texel_nearest(coords[region.sites[at] as usize]);
    let mut held: Vec<_> = (0..region.sites.len()).map(|at| (texel(at), at)).collect();
    held.sort_unstable();
    let is_apart = |a: usize, b: usize| {
        let ([ax, ay], [bx, by]) = (region.places[a], region.places[b]);
        (ax - bx).hypot(ay - by) > APART
    };
    let of_a_texel = held.chunk_by(|(a, _), (b, _)| a == b);
    let repeated = of_a_texel.flat_map(|held| {
        let elsewhere = |at: usize| held.iter().any(|&(_, other)| is_apart(at, other));
        held.iter().filter(move |&&(_, at)| elsewhere(at))
    });
    repeated.count() as f32 / region.sites.len().max(1) as f32
}
