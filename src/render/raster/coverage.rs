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
    #[inline(always)]
    fn to_f32(self) -> f32 {
        self as f32
    }
}

impl EdgeNumber for i64 {
    #[inline(always)]
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
    #[inline(always)]
    pub fn draw(&mut self, corners: [&ScreenVertex; 3], number: u32) {
        let [ox, oy] = self.origin;
        let [a, b, c] = corners;
        let at = [
            [a.x - ox, a.y - oy],
            [b.x - ox, b.y - oy],
            [c.x - ox, c.y - oy],
        ];
        let low = [
            at[0][0].min(at[1][0]).min(at[2][0]),
            at[0][1].min(at[1][1]).min(at[2][1]),
        ];
        let high = [
            at[0][0].max(at[1][0]).max(at[2][0]),
            at[0][1].max(at[1][1]).max(at[2][1]),
        ];
        let first = [
            low[0].div_euclid(SUBPIXEL).max(0),
            low[1].div_euclid(SUBPIXEL).max(0),
        ];
        let last = [
            high[0].div_euclid(SUBPIXEL).min(self.extent[0] - 1),
            high[1].div_euclid(SUBPIXEL).min(self.extent[1] - 1),
        ];
        let nearness = [a.nearness, b.nearness, c.nearness];
        if high[0] - low[0] < SMALL && high[1] - low[1] < SMALL {
            self.cover::<i32>(at, nearness, number, first, last);
        } else {
            self.cover::<i64>(at, nearness, number, first, last);
        }
    }

    #[inline(always)]
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
        let [e0, e1, e2] = &triangle.edges;
        let offsets = [
            e0.offsets(&self.positions),
            e1.offsets(&self.positions),
            e2.offsets(&self.positions),
        ];
        for row in first[1]..=last[1] {
            let corner = [first[0] * SUBPIXEL, row * SUBPIXEL];
            let mut at_pixel = [e0.at(corner), e1.at(corner), e2.at(corner)];
            let pixels = (row * TILE as i32 + first[0]) as usize..;
            let count = (last[0] - first[0] + 1).max(0) as usize;
            let nearness = &mut self.nearness[pixels.clone()][..count];
            let triangles = &mut self.triangles[pixels][..count];
            for (nearness, triangles) in nearness.iter_mut().zip(triangles) {
                for sample in 0..STORED {
                    let s0 = at_pixel[0] + offsets[0][sample];
                    let s1 = at_pixel[1] + offsets[1][sample];
                    let s2 = at_pixel[2] + offsets[2][sample];
                    let here = triangle.nearness
                        + s1.to_f32() * triangle.slopes[0]
                        + s2.to_f32() * triangle.slopes[1];
                    let seen = (s0 | s1 | s2) >= T::from(0) && here > nearness[sample];
                    nearness[sample] = if seen { here } else { nearness[sample] };
                    triangles[sample] = if seen { number } else { triangles[sample] };
                }
                at_pixel[0] = at_pixel[0] - e0.dy * T::from(SUBPIXEL);
                at_pixel[1] = at_pixel[1] - e1.dy * T::from(SUBPIXEL);
                at_pixel[2] = at_pixel[2] - e2.dy * T::from(SUBPIXEL);
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
    #[inline(always)]
    fn new(from: [i32; 2], to: [i32; 2]) -> Self {
        let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
        let owns_its_samples = dy > 0 || (dy == 0 && dx < 0);
        Self {
            dx: T::from(dx),
            dy: T::from(dy),
            from: [T::from(from[0]), T::from(from[1])],
            bias: T::from(i32::from(!owns_its_samples)),
        }
    }

    /// What the function differs by at each position within a pixel.
    #[inline(always)]
    fn offsets<const STORED: usize>(&self, positions: &[[i32; 2]; STORED]) -> [T; STORED] {
        let mut offsets = [T::from(0); STORED];
        for (offset, &[x, y]) in offsets.iter_mut().zip(positions) {
            *offset = self.dx * T::from(y) - self.dy * T::from(x);
        }
        offsets
    }

    #[inline(always)]
    fn at(&self, point: [i32; 2]) -> T {
        let (x, y) = (T::from(point[0]), T::from(point[1]));
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
    #[inline(always)]
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
            slopes: [
                (nearness[1] - nearness[0]) * scale,
                (nearness[2] - nearness[0]) * scale,
            ],
        })
    }
}

/// Perspective-correct barycentric weights of a sample that a screen triangle covers; `sample` in
/// 1/256 pixel. With `perspective` the corners' nearness is 1/depth.
#[inline(always)]
pub(super) fn barycentric(
    corners: [&ScreenVertex; 3],
    sample: [i32; 2],
    perspective: bool,
) -> [f32; 3] {
    let [a, b, c] = corners;
    let offset = |v: &ScreenVertex| (i64::from(v.x - sample[0]), i64::from(v.y - sample[1]));
    let (p, q, r) = (offset(a), offset(b), offset(c));
    let twice_area = |p: (i64, i64), q: (i64, i64)| (p.0 * q.1 - q.0 * p.1) as f32;
    let (mut u, mut v, mut w) = (twice_area(q, r), twice_area(r, p), twice_area(p, q));
    if perspective {
        u *= a.nearness;
        v *= b.nearness;
        w *= c.nearness;
    }
    let sum = u + v + w;
    [u / sum, v / sum, w / sum]
}
