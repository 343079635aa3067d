//! Which triangles touch which tile: lists built in parallel, in the triangles' order, those that face the camera apart
//! from those that face away.

use rayon::prelude::*;

use super::pattern::SUBPIXEL;
use super::screen::Screen;

/// Sides of a tile, in pixels.
pub const TILE: u32 = 32;

/// Triangles handled by one task; fixed, so that the lists do not depend on the thread count.
const CHUNK: usize = 1 << 14;

/// Which side of a triangle the camera sees.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Side {
    /// Corners run counter-clockwise in the image.
    Front,
    /// Corners run clockwise.
    Back,
}

/// Triangle numbers by tile and side.
pub(super) struct Bins {
    chunks: Vec<Chunk>,
}

struct Chunk {
    /// Where each list begins, two a tile; one more entry than lists.
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

    /// The triangles of one tile that show this side, in rising order.
    pub fn of_tile(&self, tile: usize, side: Side) -> impl Iterator<Item = u32> + '_ {
        let list = list_of(tile as u32, side) as usize;
        self.chunks.iter().flat_map(move |chunk| {
            let range = chunk.starts[list] as usize..chunk.starts[list + 1] as usize;
            chunk.entries[range].iter().copied()
        })
    }
}

/// The number of a list.
fn list_of(tile: u32, side: Side) -> u32 {
    2 * tile + side as u32
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
            let Some((side, [left, top, right, bottom])) = touched(screen, corners, size) else {
                continue;
            };
            for row in top..=bottom {
                for column in left..=right {
                    pairs.push((list_of(row * across + column, side), index as u32));
                }
            }
        }
        Self::by_list(&pairs, 2 * (across * down) as usize)
    }

    /// A counting sort, stable in the triangles' order.
    fn by_list(pairs: &[(u32, u32)], lists: usize) -> Self {
        let mut starts = vec![0u32; lists + 1];
        for &(list, _) in pairs {
            starts[list as usize + 1] += 1;
        }
        for list in 0..lists {
            starts[list + 1] += starts[list];
        }
        let mut next = starts.clone();
        let mut entries = vec![0; pairs.len()];
        for &(list, triangle) in pairs {
            let at = &mut next[list as usize];
            entries[*at as usize] = triangle;
            *at += 1;
        }
        Self { starts, entries }
    }
}

/// The side a triangle shows, and the first and last tile column and row its bounds touch; `None`
/// when it covers no area or lies off the image.
fn touched(screen: &Screen, corners: [u32; 3], size: [u32; 2]) -> Option<(Side, [u32; 4])> {
    let [a, b, c] = corners.map(|v| &screen.vertices[v as usize]);
    let area =
        i64::from(b.x - a.x) * i64::from(c.y - a.y) - i64::from(c.x - a.x) * i64::from(b.y - a.y);
    // Rows are counted downwards: what runs counter-clockwise has a negative area.
    let side = match area {
        0 => return None,
        ..0 => Side::Front,
        _ => Side::Back,
    };
    let left = a.x.min(b.x).min(c.x).div_euclid(SUBPIXEL).max(0);
    let top = a.y.min(b.y).min(c.y).div_euclid(SUBPIXEL).max(0);
    let last = size.map(|side| side as i32 - 1);
    let right = a.x.max(b.x).max(c.x).div_euclid(SUBPIXEL).min(last[0]);
    let bottom = a.y.max(b.y).max(c.y).div_euclid(SUBPIXEL).min(last[1]);
    let tile = |pixel: i32| pixel as u32 / TILE;
    (left <= right && top <= bottom).then(|| (side, [left, top, right, bottom].map(tile)))
}
