//! One tile: which triangle each sample sees, by integer edge functions (Pineda 1988).
//!
//! A sample on an edge belongs to exactly one of the two triangles that share it, so that surfaces
//! have no cracks and no doubly covered samples. Of equally near triangles the first wins.

use std::ops::{Add, BitOr, Mul, Sub};

use super::bins::TILE;
use super::pattern::{SUBPIXEL, Samples};
use super::screen::ScreenVertex;

/// No triangle.
pub const NOTHING: u32 = u32::MAX;

/// Triangles whose bounds are smaller than this many pixels are drawn in 32-bit numbers:
/// products of two offsets of at most (64 + 32) · 256 stay below 2³¹.
const SMALL: i32 = 64 * SUBPIXEL;

/// An integer wide enough for the edge functions of a triangle.
trait EdgeNumber:
    Copy
    + From<i32>
    + PartialOrd
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + BitOr<Output = Self>
{
    fn to_f32(self) -> f32;
}

impl EdgeNumber for i32 {
    #[inline]
    fn to_f32(self) -> f32 {
        self as f32
    }
}

impl EdgeNumber for i64 {
    #[inline]
    fn to_f32(self) -> f32 {
        self as f32
    }
}

/// The samples of one tile while triangles are drawn into it.
pub(super) struct TileSamples<const STORED: usize> {
    /// Upper left corner, in 1/256 pixel.
    origin: [i32; 2],
    /// Columns and rows that lie on the image.
    extent: [i32; 2],
    positions: [[i32; 2]; STORED],
    nearness: Vec<[f32; STORED]>,
    /// The triangle each sample sees, pixel by pixel.
    pub triangles: Vec<[u32; STORED]>,
}

impl<const STORED: usize> TileSamples<STORED> {
    /// An empty tile; `corner` is its first pixel, `size` the image's.
    pub fn new(corner: [u32; 2], size: [u32; 2], samples: Samples) -> Self {
        let pixels = (TILE * TILE) as usize;
        Self {
            origin: corner.map(|pixel| pixel as i32 * SUBPIXEL),
            extent: [0, 1].map(|axis| (size[axis] - corner[axis]).min(TILE) as i32),
            positions: samples.positions(),
            nearness: vec![[f32::NEG_INFINITY; STORED]; pixels],
            triangles: vec![[NOTHING; STORED]; pixels],
        }
    }

    /// Draws a triangle under a number.
    pub fn draw(&mut self, corners: [&ScreenVertex; 3], number: u32) {
        let at = corners.map(|v| [v.x - self.origin[0], v.y - self.origin[1]]);
        let low = [0, 1].map(|axis| at[0][axis].min(at[1][axis]).min(at[2][axis]));
        let high = [0, 1].map(|axis| at[0][axis].max(at[1][axis]).max(at[2][axis]));
        let first = low.map(|v| v.div_euclid(SUBPIXEL).max(0));
        let last = [0, 1].map(|axis| high[axis].div_euclid(SUBPIXEL).min(self.extent[axis] - 1));
        let nearness = corners.map(|v| v.nearness);
        if high[0] - low[0] < SMALL && high[1] - low[1] < SMALL {
            self.cover::<i32>(at, nearness, number, first, last);
        } else {
            self.cover::<i64>(at, nearness, number, first, last);
        }
    }

    #[inline]
    fn cover<T: EdgeNumber>(
        &mut self,
        at: [[i32; 2]; 3],
        nearness: [f32; 3],
        number: u32,
        first: [i32; 2],
        last: [i32; 2],
    ) {
        let Some(triangle) = Edges::<T>::new(at, nearness) else {
            return;
        };
        let offsets = triangle.edges.map(|edge| {
            self.positions
                .map(|[x, y]| edge.dx * T::from(y) - edge.dy * T::from(x))
        });
        for row in first[1]..=last[1] {
            let corner = [first[0] * SUBPIXEL, row * SUBPIXEL];
            let mut at_pixel = triangle.edges.map(|edge| edge.at(corner));
            let pixels = (row * TILE as i32 + first[0]) as usize..;
            let count = (last[0] - first[0] + 1).max(0) as usize;
            let nearness = &mut self.nearness[pixels.clone()][..count];
            let triangles = &mut self.triangles[pixels][..count];
            for (nearness, triangles) in nearness.iter_mut().zip(triangles) {
                for sample in 0..STORED {
                    let [e0, e1, e2] = [0, 1, 2].map(|k| at_pixel[k] + offsets[k][sample]);
                    let here = triangle.nearness
                        + e1.to_f32() * triangle.slopes[0]
                        + e2.to_f32() * triangle.slopes[1];
                    let seen = (e0 | e1 | e2) >= T::from(0) && here > nearness[sample];
                    nearness[sample] = if seen { here } else { nearness[sample] };
                    triangles[sample] = if seen { number } else { triangles[sample] };
                }
                for (value, edge) in at_pixel.iter_mut().zip(&triangle.edges) {
                    *value = *value - edge.dy * T::from(SUBPIXEL);
                }
            }
        }
    }
}

/// An edge function: positive inside, 0 on the edge, less a bias of 1 where the edge's samples
/// belong to the triangle on its other side.
#[derive(Clone, Copy)]
struct Edge<T> {
    dx: T,
    dy: T,
    from: [T; 2],
    bias: T,
}

impl<T: EdgeNumber> Edge<T> {
    fn new(from: [i32; 2], to: [i32; 2]) -> Self {
        let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
        let owns_its_samples = dy > 0 || (dy == 0 && dx < 0);
        Self {
            dx: T::from(dx),
            dy: T::from(dy),
            from: from.map(T::from),
            bias: T::from(i32::from(!owns_its_samples)),
        }
    }

    #[inline]
    fn at(&self, point: [i32; 2]) -> T {
        let [x, y] = point.map(T::from);
        self.dx * (y - self.from[1]) - self.dy * (x - self.from[0]) - self.bias
    }
}

/// A triangle's edge functions, each opposite the corner of its number, and its nearness.
struct Edges<T> {
    edges: [Edge<T>; 3],
    /// At corner 0.
    nearness: f32,
    /// Change for each unit of the second and the third edge function.
    slopes: [f32; 2],
}

impl<T: EdgeNumber> Edges<T> {
    /// `None` for a triangle without area. Either orientation is drawn.
    fn new(mut at: [[i32; 2]; 3], mut nearness: [f32; 3]) -> Option<Self> {
        let difference = |a: usize, b: usize, axis: usize| i64::from(at[a][axis] - at[b][axis]);
        let area =
            difference(1, 0, 0) * difference(2, 0, 1) - difference(2, 0, 0) * difference(1, 0, 1);
        if area == 0 {
            return None;
        }
        if area < 0 {
            at.swap(1, 2);
            nearness.swap(1, 2);
        }
        let scale = 1.0 / area.abs() as f32;
        Some(Self {
            edges: [
                Edge::new(at[1], at[2]),
                Edge::new(at[2], at[0]),
                Edge::new(at[0], at[1]),
            ],
            nearness: nearness[0],
            slopes: [1, 2].map(|corner: usize| (nearness[corner] - nearness[0]) * scale),
        })
    }
}

/// Perspective-correct barycentric weights of a sample that a screen triangle covers; `sample` in
/// 1/256 pixel. With `perspective` the corners' nearness is 1/depth.
pub(super) fn barycentric(
    corners: [&ScreenVertex; 3],
    sample: [i32; 2],
    perspective: bool,
) -> [f32; 3] {
    let offset = |a: &ScreenVertex| (i64::from(a.x - sample[0]), i64::from(a.y - sample[1]));
    let [a, b, c] = corners.map(offset);
    let twice_area = |p: (i64, i64), q: (i64, i64)| (p.0 * q.1 - q.0 * p.1) as f32;
    let mut weights = [twice_area(b, c), twice_area(c, a), twice_area(a, b)];
    if perspective {
        for (weight, corner) in weights.iter_mut().zip(corners) {
            *weight *= corner.nearness;
        }
    }
    let sum: f32 = weights.iter().sum();
    weights.map(|weight| weight / sum)
}
