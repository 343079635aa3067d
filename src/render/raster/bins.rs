//! Which triangles touch which tile: lists built in parallel, in the triangles' order.

use rayon::prelude::*;

use super::pattern::SUBPIXEL;
use super::screen::Screen;

/// Sides of a tile, in pixels.
pub const TILE: u32 = 32;

/// Triangles handled by one task; fixed, so that the lists do not depend on the thread count.
const CHUNK: usize = 1 << 14;

/// Triangle numbers by tile.
pub(super) struct Bins {
    chunks: Vec<Chunk>,
}

struct Chunk {
    /// Where each tile's list begins; one more entry than tiles.
    starts: Vec<u32>,
    entries: Vec<u32>,
}

/// Tiles across and down an image.
pub(super) fn tile_counts(size: [u32; 2]) -> [u32; 2] {
    size.map(|side| side.div_ceil(TILE))
}

impl Bins {
    /// Sorts the mesh's triangles, and after them the screen's clipped pieces, into tiles.
    pub fn sort(screen: &Screen, triangles: &[[u32; 3]], size: [u32; 2]) -> Self {
        let total = triangles.len() + screen.pieces.len();
        let chunks = (0..total.div_ceil(CHUNK))
            .into_par_iter()
            .map(|chunk| {
                let range = chunk * CHUNK..total.min((chunk + 1) * CHUNK);
                Chunk::sort(screen, triangles, size, range)
            })
            .collect();
        Self { chunks }
    }

    /// The triangles of one tile, in rising order.
    pub fn of_tile(&self, tile: usize) -> impl Iterator<Item = u32> + '_ {
        self.chunks.iter().flat_map(move |chunk| {
            let range = chunk.starts[tile] as usize..chunk.starts[tile + 1] as usize;
            chunk.entries[range].iter().copied()
        })
    }
}

impl Chunk {
    fn sort(
        screen: &Screen,
        triangles: &[[u32; 3]],
        size: [u32; 2],
        range: std::ops::Range<usize>,
    ) -> Self {
        let [across, down] = tile_counts(size);
        let mut pairs: Vec<(u32, u32)> = Vec::with_capacity(range.len());
        for index in range {
            let corners = match triangles.get(index) {
                Some(&corners) if !screen.is_drawable(corners) => continue,
                Some(&corners) => corners,
                None => screen.pieces[index - triangles.len()].corners,
            };
            let Some([left, top, right, bottom]) = tiles_touched(screen, corners, size) else {
                continue;
            };
            for row in top..=bottom {
                for column in left..=right {
                    pairs.push((row * across + column, index as u32));
                }
            }
        }
        Self::by_tile(&pairs, (across * down) as usize)
    }

    /// A counting sort, stable in the triangles' order.
    fn by_tile(pairs: &[(u32, u32)], tiles: usize) -> Self {
        let mut starts = vec![0u32; tiles + 1];
        for &(tile, _) in pairs {
            starts[tile as usize + 1] += 1;
        }
        for tile in 0..tiles {
            starts[tile + 1] += starts[tile];
        }
        let mut next = starts.clone();
        let mut entries = vec![0; pairs.len()];
        for &(tile, triangle) in pairs {
            let at = &mut next[tile as usize];
            entries[*at as usize] = triangle;
            *at += 1;
        }
        Self { starts, entries }
    }
}

/// First and last tile column and row a triangle's bounds touch; `None` when it covers no area or
/// lies off the image.
fn tiles_touched(screen: &Screen, corners: [u32; 3], size: [u32; 2]) -> Option<[u32; 4]> {
    let [a, b, c] = corners.map(|v| &screen.vertices[v as usize]);
    let area =
        i64::from(b.x - a.x) * i64::from(c.y - a.y) - i64::from(c.x - a.x) * i64::from(b.y - a.y);
    if area == 0 {
        return None;
    }
    let left = a.x.min(b.x).min(c.x).div_euclid(SUBPIXEL).max(0);
    let top = a.y.min(b.y).min(c.y).div_euclid(SUBPIXEL).max(0);
    let last = size.map(|side| side as i32 - 1);
    let right = a.x.max(b.x).max(c.x).div_euclid(SUBPIXEL).min(last[0]);
    let bottom = a.y.max(b.y).max(c.y).div_euclid(SUBPIXEL).min(last[1]);
    let tile = |pixel: i32| pixel as u32 / TILE;
    (left <= right && top <= bottom).then(|| [left, top, right, bottom].map(tile))
}
