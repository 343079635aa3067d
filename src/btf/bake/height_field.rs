//! The surface that is baked: a toroidal height field of bilinear patches over the texel grid.
//!
//! In: heights at the texel centres. Out: points, normals and a pyramid of maxima for the rays of
//! [`trace`](super::trace). Grid coordinates: x = column rightwards, y upwards (row H−1 is y = 0), both
//! integral at texel centres; heights and lengths in texels; z = 0 is the mean height. Patch
//! (i, j) spans the four texel centres from (i, j) to (i + 1, j + 1), wrapped.

use std::borrow::Cow;

use glam::{DVec2, DVec3};

use crate::grid::TexelGrid;

/// Within this of a patch's edge a point lies on the edge, in texels.
const ON_EDGE: f64 = 1e-9;

/// A height field over a torus.
#[derive(Clone, Debug)]
pub struct HeightField {
    width: usize,
    height: usize,
    /// Each patch's corner heights: at (0,0), (1,0), (0,1), (1,1).
    corners: Vec<[f32; 4]>,
    /// `maxima[k]` bounds blocks of 2^k × 2^k patches from above; the last level is one block.
    maxima: Vec<Maxima>,
    lowest: f64,
}

/// Upper bounds of blocks of patches.
#[derive(Clone, Debug)]
pub(super) struct Maxima {
    pub(super) width: usize,
    pub(super) bounds: Vec<f32>,
}

/// A point of the surface: a patch and the place in it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReliefPoint {
    /// Column of the patch.
    pub x: usize,
    /// Row of the patch, counted upwards.
    pub y: usize,
    /// Place in the patch, 0 to 1 each.
    pub within: DVec2,
}

impl HeightField {
    /// The surface through `heights` (row-major, row 0 at the top, in texels), moved so that its mean
    /// is z = 0.
    pub fn new(width: usize, height: usize, heights: &[f32]) -> Self {
        let mean = heights.iter().map(|&h| f64::from(h)).sum::<f64>() / heights.len() as f64;
        Self::moved_down(width, height, heights, mean)
    }

    /// The surface over a sample's texels, moved so that its mean is z = 0. One that is not tileable is continued by
    /// mirroring, so it has twice the rows and columns.
    pub fn of_grid(grid: TexelGrid, heights: &[f32]) -> Self {
        let (width, height, heights) = continued(grid, heights);
        Self::new(width, height, &heights)
    }

    /// The same with heights above z = 0, left as they are.
    pub fn above_plane(grid: TexelGrid, heights: &[f32]) -> Self {
        let (width, height, heights) = continued(grid, heights);
        Self::moved_down(width, height, &heights, 0.0)
    }

    fn moved_down(width: usize, height: usize, heights: &[f32], by: f64) -> Self {
        let at = |x: usize, y: usize| {
            let row = height - 1 - y % height;
            (f64::from(heights[row * width + x % width]) - by) as f32
        };
        let corners: Vec<[f32; 4]> = (0..width * height)
            .map(|patch| {
                let (x, y) = (patch % width, patch / width);
                [at(x, y), at(x + 1, y), at(x, y + 1), at(x + 1, y + 1)]
            })
            .collect();
        let lowest = corners.iter().map(|c| c[0]).fold(f32::INFINITY, f32::min);
        Self {
            width,
            height,
            maxima: maxima_pyramid(width, height, &corners),
            corners,
            lowest: f64::from(lowest),
        }
    }

    /// Columns.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows.
    pub fn height(&self) -> usize {
        self.height
    }

    /// The highest point over the mean plane, in texels.
    pub fn highest(&self) -> f64 {
        f64::from(self.maxima[self.maxima.len() - 1].bounds[0])
    }

    /// The lowest point, in texels (not positive).
    pub fn lowest(&self) -> f64 {
        self.lowest
    }

    pub(super) fn maxima(&self) -> &[Maxima] {
        &self.maxima
    }

    #[inline]
    pub(super) fn patch(&self, x: usize, y: usize) -> Patch {
        let [h00, h10, h01, h11] = self.corners[y * self.width + x].map(f64::from);
        Patch {
            base: h00,
            along_x: h10 - h00,
            along_y: h01 - h00,
            twist: h11 - h10 - h01 + h00,
        }
    }

    /// Where a surface point lies, in grid coordinates.
    #[inline]
    pub fn position(&self, point: ReliefPoint) -> DVec3 {
        let z = self.patch(point.x, point.y).height(point.within);
        DVec3::new(
            point.x as f64 + point.within.x,
            point.y as f64 + point.within.y,
            z,
        )
    }

    /// The unit normal of the surface itself. Where patches meet in an edge or a corner it is that of
    /// their mean slope, so that a texel's centre has its central differences.
    pub fn normal(&self, point: ReliefPoint) -> DVec3 {
        let slope = self.slope(point);
        DVec3::new(-slope.x, -slope.y, 1.0).normalize()
    }

    fn slope(&self, point: ReliefPoint) -> DVec2 {
        let ReliefPoint { x, y, within } = point;
        let (beside_x, other_u) = neighbor_over_edge(x, within.x, self.width);
        let (beside_y, other_v) = neighbor_over_edge(y, within.y, self.height);
        let here = self.patch(x, y);
        let over_x = self.patch(beside_x, y);
        let over_y = self.patch(x, beside_y);
        DVec2::new(
            0.5 * (here.slope(within).x + over_x.slope(DVec2::new(other_u, within.y)).x),
            0.5 * (here.slope(within).y + over_y.slope(DVec2::new(within.x, other_v)).y),
        )
    }
}

/// Heights over a torus: those of a tileable grid, or of a grid and its mirror images.
fn continued(grid: TexelGrid, heights: &[f32]) -> (usize, usize, Cow<'_, [f32]>) {
    let (width, height) = (grid.width as usize, grid.height as usize);
    if grid.tileable {
        return (width, height, Cow::Borrowed(heights));
    }
    // Grid rows are counted upwards from the last row: it stays at y = 0.
    let mirrored = (0..4 * width * height)
        .map(|i| (i % (2 * width), 2 * height - 1 - i / (2 * width)))
        .map(|(x, y)| heights[texel(grid, x, y)]);
    (2 * width, 2 * height, mirrored.collect())
}

/// The texel at a column and an upward row of a surface over `grid`, however far it is continued.
pub(super) fn texel(grid: TexelGrid, x: usize, y: usize) -> usize {
    let fold = |index: usize, side: u32| {
        let side = side as usize;
        match grid.tileable {
            true => index % side,
            false if index % (2 * side) < side => index % (2 * side),
            false => 2 * side - 1 - index % (2 * side),
        }
    };
    let (col, up) = (fold(x, grid.width), fold(y, grid.height));
    (grid.height as usize - 1 - up) * grid.width as usize + col
}

/// The patch that shares the edge at `place`, and the place there; the same patch off the edges.
fn neighbor_over_edge(index: usize, place: f64, count: usize) -> (usize, f64) {
    if place < ON_EDGE {
        ((index + count - 1) % count, 1.0)
    } else if place > 1.0 - ON_EDGE {
        ((index + 1) % count, 0.0)
    } else {
        (index, place)
    }
}

/// One bilinear patch: h(u, v) = base + along_x·u + along_y·v + twist·u·v.
#[derive(Clone, Copy, Debug)]
pub(super) struct Patch {
    pub(super) base: f64,
    pub(super) along_x: f64,
    pub(super) along_y: f64,
    pub(super) twist: f64,
}

impl Patch {
    #[inline]
    pub(super) fn height(&self, at: DVec2) -> f64 {
        self.base + self.along_x * at.x + (self.along_y + self.twist * at.x) * at.y
    }

    #[inline]
    pub(super) fn slope(&self, at: DVec2) -> DVec2 {
        DVec2::new(
            self.along_x + self.twist * at.y,
            self.along_y + self.twist * at.x,
        )
    }
}

fn maxima_pyramid(width: usize, height: usize, corners: &[[f32; 4]]) -> Vec<Maxima> {
    let bounds = corners
        .iter()
        .map(|c| c.iter().copied().fold(f32::NEG_INFINITY, f32::max))
        .collect();
    let mut levels = vec![Maxima { width, bounds }];
    let (mut columns, mut rows) = (width, height);
    while columns > 1 || rows > 1 {
        let finer = &levels[levels.len() - 1];
        let (coarse_columns, coarse_rows) = (columns.div_ceil(2), rows.div_ceil(2));
        let mut bounds = vec![f32::NEG_INFINITY; coarse_columns * coarse_rows];
        for y in 0..rows {
            for x in 0..columns {
                let bound = &mut bounds[(y / 2) * coarse_columns + x / 2];
                *bound = bound.max(finer.bounds[y * columns + x]);
            }
        }
        (columns, rows) = (coarse_columns, coarse_rows);
        levels.push(Maxima {
            width: columns,
            bounds,
        });
    }
    levels
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows from the top.
    const HEIGHTS: [f32; 6] = [0.0, 1.0, 2.0, 3.0, 5.0, 7.0];

    #[test]
    fn the_mean_is_the_plane_and_row_0_is_at_the_top() {
        let field = HeightField::new(3, 2, &HEIGHTS);
        let corner = |x, y| {
            field.position(ReliefPoint {
                x,
                y,
                within: DVec2::ZERO,
            })
        };
        assert_eq!(corner(0, 0), DVec3::new(0.0, 0.0, 0.0));
        assert_eq!(corner(2, 1), DVec3::new(2.0, 1.0, -1.0));
        assert_eq!((field.highest(), field.lowest()), (4.0, -3.0));
    }

    #[test]
    fn patches_meet_at_their_edges_and_wrap() {
        let field = HeightField::new(3, 2, &HEIGHTS);
        for (x, y) in [(0, 0), (1, 0), (2, 1)] {
            let right = field.patch(x, y).height(DVec2::new(1.0, 0.3));
            let left = field.patch((x + 1) % 3, y).height(DVec2::new(0.0, 0.3));
            assert!((right - left).abs() < 1e-12);
        }
    }

    #[test]
    fn normals_at_texel_centres_are_central_differences() {
        let field = HeightField::new(3, 2, &HEIGHTS);
        let point = ReliefPoint {
            x: 1,
            y: 0,
            within: DVec2::ZERO,
        };
        let normal = field.normal(point);
        // Row 1 is y = 0: (3, 5, 7), so dh/dx = 2; above and below (wrapped) is 1 twice: dh/dy = 0.
        let wanted = DVec3::new(-2.0, 0.0, 1.0).normalize();
        assert!((normal - wanted).length() < 1e-12);
    }

    #[test]
    fn every_block_bounds_its_patches() {
        let heights: Vec<f32> = (0..35).map(|i| ((i * 17) % 23) as f32).collect();
        let field = HeightField::new(7, 5, &heights);
        for (level, maxima) in field.maxima().iter().enumerate() {
            for y in 0..5 {
                for x in 0..7 {
                    let bound = maxima.bounds[(y >> level) * maxima.width + (x >> level)];
                    assert!(field.corners[y * 7 + x].iter().all(|&h| h <= bound));
                }
            }
        }
        assert_eq!(field.maxima().last().unwrap().bounds.len(), 1);
    }
}
