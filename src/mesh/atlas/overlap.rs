//! Whether two triangles cover the same place of the texture.
//!
//! Triangles are sorted into a uniform grid one after the other; each is compared with those that share a
//! cell with it. Coordinates are 32-bit numbers, so that their differences and products are exact in double
//! precision.

use glam::{DVec2, Vec2};

/// Triangles that reach into each other by no more than this, in texture coordinates, only touch. OBJ files
/// hold six decimals.
const TOUCHING: f64 = 1e-5;
/// Cells along a side of the grid at most.
const MOST_CELLS: usize = 2048;

/// The first two triangles that overlap, the smaller first: of all such pairs the one whose larger triangle
/// comes first.
pub(super) fn first_overlap(corner_uvs: &[[Vec2; 3]]) -> Option<[u32; 2]> {
    let mut grid = CellGrid::new(corner_uvs);
    for (triangle, uvs) in corner_uvs.iter().enumerate() {
        let corners = counter_clockwise(uvs);
        let mut first: Option<u32> = None;
        grid.visit(&corners, |cell| {
            let others = cell.iter().copied();
            let met = others.filter(|&other| {
                first.is_none_or(|first| other < first)
                    && overlap(&corners, &counter_clockwise(&corner_uvs[other as usize]))
            });
            first = met.min().or(first);
            cell.push(triangle as u32);
        });
        if let Some(first) = first {
            return Some([first, triangle as u32]);
        }
    }
    None
}

fn counter_clockwise(uvs: &[Vec2; 3]) -> [DVec2; 3] {
    let [a, b, c] = uvs.map(|uv| uv.as_dvec2());
    match (b - a).perp_dot(c - a) < 0.0 {
        true => [a, c, b],
        false => [a, b, c],
    }
}

/// Whether two counter-clockwise triangles reach into each other: no edge of either has the other outside
/// (separating axes).
fn overlap(a: &[DVec2; 3], b: &[DVec2; 3]) -> bool {
    !has_separating_edge(a, b) && !has_separating_edge(b, a)
}

fn has_separating_edge(of: &[DVec2; 3], other: &[DVec2; 3]) -> bool {
    (0..3).any(|k| {
        let (from, to) = (of[k], of[(k + 1) % 3]);
        let edge = to - from;
        let tolerance = TOUCHING * edge.length();
        other
            .iter()
            .all(|&corner| edge.perp_dot(corner - from) <= tolerance)
    })
}

/// The triangles met so far, by the cells of a grid over the box of all.
struct CellGrid {
    low: DVec2,
    /// Cells per unit along u and v.
    density: DVec2,
    side: usize,
    cells: Vec<Vec<u32>>,
}

impl CellGrid {
    fn new(corner_uvs: &[[Vec2; 3]]) -> Self {
        let side = ((corner_uvs.len() as f64).sqrt() as usize).clamp(1, MOST_CELLS);
        let all = corner_uvs.iter().flatten();
        let (low, high) = all.fold((Vec2::ONE, Vec2::ZERO), |(low, high), &uv| {
            (low.min(uv), high.max(uv))
        });
        let extent = (high - low).as_dvec2().max(DVec2::splat(1e-9));
        Self {
            low: low.as_dvec2(),
            density: side as f64 / extent,
            side,
            cells: vec![Vec::new(); side * side],
        }
    }

    /// Visits the cells that a triangle reaches into, row by row.
    fn visit(&mut self, corners: &[DVec2; 3], mut work: impl FnMut(&mut Vec<u32>)) {
        let corners = corners.map(|corner| (corner - self.low) * self.density);
        let last = self.side - 1;
        let cell = |at: f64| (at.max(0.0) as usize).min(last);
        let bottom = corners.iter().fold(f64::INFINITY, |y, c| y.min(c.y));
        let top = corners.iter().fold(f64::NEG_INFINITY, |y, c| y.max(c.y));
        for row in cell(bottom - MARGIN)..=cell(top + MARGIN) {
            let band = [row as f64 - MARGIN, row as f64 + 1.0 + MARGIN];
            let [left, right] = extent_within(&corners, band);
            for column in cell(left - MARGIN)..=cell(right + MARGIN) {
                work(&mut self.cells[row * self.side + column]);
            }
        }
    }
}

/// Cells are visited that a triangle misses by less than this share of one: rounding loses none.
const MARGIN: f64 = 1e-6;

/// The smallest and the largest x of a triangle within a band of y.
fn extent_within(corners: &[DVec2; 3], [bottom, top]: [f64; 2]) -> [f64; 2] {
    let mut extent = [f64::INFINITY, f64::NEG_INFINITY];
    let mut take = |x: f64| extent = [extent[0].min(x), extent[1].max(x)];
    for k in 0..3 {
        let (from, to) = (corners[k], corners[(k + 1) % 3]);
        if (bottom..=top).contains(&from.y) {
            take(from.x);
        }
        for line in [bottom, top] {
            let share = (line - from.y) / (to.y - from.y);
            if (0.0..=1.0).contains(&share) {
                take(from.x + share * (to.x - from.x));
            }
        }
    }
    extent
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random;
    use rand::Rng;

    fn triangle(corners: [[f32; 2]; 3]) -> [Vec2; 3] {
        corners.map(Vec2::from_array)
    }

    #[test]
    fn shared_edges_and_corners_are_no_overlap() {
        let first = triangle([[0.2, 0.2], [0.6, 0.2], [0.2, 0.6]]);
        for other in [
            [[0.6, 0.2], [0.6, 0.6], [0.2, 0.6]],
            [[0.6, 0.2], [0.2, 0.6], [0.6, 0.6]],
            [[0.2, 0.6], [0.1, 0.9], [0.4, 0.9]],
            [[0.4, 0.4], [0.9, 0.9], [0.4, 0.9]],
            [[0.2, 0.1], [0.5, 0.1], [0.4, 0.200_000_1]],
        ] {
            assert_eq!(first_overlap(&[first, triangle(other)]), None, "{other:?}");
        }
        for other in [
            [[0.2, 0.2], [0.6, 0.2], [0.2, 0.6]],
            [[0.25, 0.25], [0.3, 0.25], [0.25, 0.3]],
            [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]],
            [[0.2, 0.1], [0.5, 0.1], [0.4, 0.201]],
            [[0.0, 0.3], [0.9, 0.3], [0.9, 0.31]],
        ] {
            let found = first_overlap(&[first, triangle(other)]);
            assert_eq!(found, Some([0, 1]), "{other:?}");
        }
    }

    #[test]
    fn the_grid_finds_what_comparing_all_pairs_finds() {
        let mut random = random::stream(3, "overlap test", 0, 0);
        for _ in 0..40 {
            let all: Vec<[Vec2; 3]> = (0..60)
                .map(|_| {
                    let size = random.gen_range(0.01..0.2_f32);
                    let at = Vec2::new(random.gen_range(0.0..0.8), random.gen_range(0.0..0.8));
                    std::array::from_fn(|_| at + size * Vec2::new(random.r#gen(), random.r#gen()))
                })
                .collect();
            let turned: Vec<_> = all.iter().map(counter_clockwise).collect();
            let slow = (0..all.len()).find_map(|b| {
                let first = (0..b).find(|&a| overlap(&turned[a], &turned[b]));
                first.map(|a| [a as u32, b as u32])
            });
            assert_eq!(first_overlap(&all), slow);
        }
    }
}
