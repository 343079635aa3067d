//! One tile: which triangle each sample sees, by integer edge functions (Pineda 1988).
//!
//! A sample on an edge belongs to exactly one of the two triangles that share it, so that surfaces
//! have no cracks and no doubly covered samples. Of equally near triangles the first drawn wins.

use std::array::from_fn;
use std::ops::{Add, BitOr, Mul, RangeInclusive, Sub};

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
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + BitOr<Output = Self>
{
    fn to_f32(self) -> f32;
    /// All bits set where it is 0 or more, none where it is less.
    fn not_negative(self) -> u32;
}

impl EdgeNumber for i32 {
    #[inline(always)]
    fn to_f32(self) -> f32 {
        self as f32
    }

    #[inline(always)]
    fn not_negative(self) -> u32 {
        !(self >> 31) as u32
    }
}

impl EdgeNumber for i64 {
    #[inline(always)]
    fn to_f32(self) -> f32 {
        self as f32
    }

    #[inline(always)]
    fn not_negative(self) -> u32 {
        !(self >> 63) as u32
    }
}

/// The samples of one tile while triangles are drawn into it; those beyond the pattern's see what
/// the pixel's centre sees.
pub(super) struct TileSamples<const LANES: usize> {
    /// Upper left corner, in 1/256 pixel.
    origin: [i32; 2],
    /// Columns and rows that lie on the image.
    extent: [i32; 2],
    positions: [[i32; 2]; LANES],
    nearness: Vec<[f32; LANES]>,
    /// The triangle each sample sees, pixel by pixel.
    pub triangles: Vec<[u32; LANES]>,
}

/// A triangle's place in a tile.
struct Placed {
    /// Its corners, from the tile's.
    at: [[i32; 2]; 3],
    /// Columns and rows of pixels it may touch, first and last.
    pixels: [RangeInclusive<i32>; 2],
    is_small: bool,
}

impl<const LANES: usize> TileSamples<LANES> {
    /// An empty tile; `corner` is its first pixel, `size` the image's.
    pub fn new(corner: [u32; 2], size: [u32; 2], samples: Samples) -> Self {
        let pixels = (TILE * TILE) as usize;
        Self {
            origin: corner.map(|pixel| pixel as i32 * SUBPIXEL),
            extent: [0, 1].map(|axis| (size[axis] - corner[axis]).min(TILE) as i32),
            positions: samples.positions(),
            nearness: vec![[f32::NEG_INFINITY; LANES]; pixels],
            triangles: vec![[NOTHING; LANES]; pixels],
        }
    }

    /// Draws a triangle under a number.
    #[inline(always)]
    pub fn draw(&mut self, corners: [&ScreenVertex; 3], number: u32) {
        let placed = self.place(corners);
        self.draw_placed(&placed, corners, number);
    }

    /// How near the farthest sample of every pixel is.
    pub fn farthest(&self) -> Vec<f32> {
        let of_pixel =
            |samples: &[f32; LANES]| samples.iter().copied().fold(f32::INFINITY, f32::min);
        self.nearness.iter().map(of_pixel).collect()
    }

    /// Draws a triangle unless all of its pixels are nearer than all of it: as [`draw`](Self::draw)
    /// does. `farthest` may be of an earlier state.
    #[inline(always)]
    pub fn draw_behind(&mut self, corners: [&ScreenVertex; 3], number: u32, farthest: &[f32]) {
        let placed = self.place(corners);
        let [a, b, c] = corners.map(|corner| corner.nearness);
        let nearest = a.max(b).max(c);
        // Interpolation may round beyond the corners.
        let nearest = nearest + nearest.abs() * 1e-5;
        let [columns, rows] = placed.pixels.clone();
        let shows = rows.into_iter().any(|row| {
            let line = &farthest[(row * TILE as i32) as usize..][..TILE as usize];
            columns
                .clone()
                .any(|column| line[column as usize] < nearest)
        });
        if shows {
            self.draw_placed(&placed, corners, number);
        }
    }

    #[inline(always)]
    fn place(&self, corners: [&ScreenVertex; 3]) -> Placed {
        let [ox, oy] = self.origin;
        let at = corners.map(|corner| [corner.x - ox, corner.y - oy]);
        let low = [0, 1].map(|axis| at[0][axis].min(at[1][axis]).min(at[2][axis]));
        let high = [0, 1].map(|axis| at[0][axis].max(at[1][axis]).max(at[2][axis]));
        let pixels = [0, 1].map(|axis| {
            let first = low[axis].div_euclid(SUBPIXEL).max(0);
            first..=high[axis].div_euclid(SUBPIXEL).min(self.extent[axis] - 1)
        });
        Placed {
            at,
            pixels,
            is_small: high[0] - low[0] < SMALL && high[1] - low[1] < SMALL,
        }
    }

    #[inline(always)]
    fn draw_placed(&mut self, placed: &Placed, corners: [&ScreenVertex; 3], number: u32) {
        let nearness = corners.map(|corner| corner.nearness);
        let [columns, rows] = &placed.pixels;
        let first = [*columns.start(), *rows.start()];
        let last = [*columns.end(), *rows.end()];
        if placed.is_small {
            self.cover::<i32>(placed.at, nearness, number, first, last);
        } else {
            self.cover::<i64>(placed.at, nearness, number, first, last);
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
        // Set up the edges.
        let Some(triangle) = Edges::<T>::new(at, nearness) else {
            return;
        };
        let [e0, e1, e2] = &triangle.edges;
        let offsets = [
            e0.offsets(&self.positions),
            e1.offsets(&self.positions),
            e2.offsets(&self.positions),
        ];
        // Test all samples of each pixel, row by row.
        for row in first[1]..=last[1] {
            let corner = [first[0] * SUBPIXEL, row * SUBPIXEL];
            let mut at_pixel = [e0.at(corner), e1.at(corner), e2.at(corner)];
            let pixels = (row * TILE as i32 + first[0]) as usize..;
            let count = (last[0] - first[0] + 1).max(0) as usize;
            let nearness = &mut self.nearness[pixels.clone()][..count];
            let triangles = &mut self.triangles[pixels][..count];
            for (nearness, triangles) in nearness.iter_mut().zip(triangles) {
                triangle.cover_pixel(at_pixel, &offsets, number, nearness, triangles);
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
    fn offsets<const LANES: usize>(&self, positions: &[[i32; 2]; LANES]) -> [T; LANES] {
        let mut offsets = [T::from(0); LANES];
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

    /// Shows the triangle to those of a pixel's samples that it covers and that saw nothing nearer.
    /// No branches: all lanes go together.
    #[inline(always)]
    fn cover_pixel<const LANES: usize>(
        &self,
        at: [T; 3],
        offsets: &[[T; LANES]; 3],
        number: u32,
        nearness: &mut [f32; LANES],
        triangles: &mut [u32; LANES],
    ) {
        let [s0, s1, s2]: [[T; LANES]; 3] =
            from_fn(|edge| from_fn(|lane| at[edge] + offsets[edge][lane]));
        let here: [f32; LANES] = from_fn(|lane| {
            self.nearness + s1[lane].to_f32() * self.slopes[0] + s2[lane].to_f32() * self.slopes[1]
        });
        let seen: [u32; LANES] = from_fn(|lane| {
            let is_nearer = u32::from(here[lane] > nearness[lane]).wrapping_neg();
            (s0[lane] | s1[lane] | s2[lane]).not_negative() & is_nearer
        });
        *nearness = from_fn(|lane| {
            let [new, old] = [here[lane], nearness[lane]].map(f32::to_bits);
            f32::from_bits(new & seen[lane] | old & !seen[lane])
        });
        *triangles = from_fn(|lane| number & seen[lane] | triangles[lane] & !seen[lane]);
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
