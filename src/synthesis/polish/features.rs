//! The exemplar's finest level as a function of the plane: feature vectors, bilinear between texel centres.

use rand::Rng;

use crate::exemplar::embedding::Embedding;
use crate::exemplar::level::ExemplarLevel;
use crate::grid::{TexCoord, TexelGrid};
use crate::index::TexelIndex;
use crate::lanes::LANES;
use crate::random;

/// Pairs of random texels that the mean distance is measured at.
const PAIRS: u32 = 4096;

/// Numbers of a vector that are compared side by side.
const WIDTH: usize = 4;

/// Feature vectors texel by texel, scaled so that two random texels are 1 apart on average.
#[derive(Clone, Debug)]
pub struct PlaneFeatures {
    grid: TexelGrid,
    /// Parts of a vector.
    parts: usize,
    vectors: Vec<[f32; WIDTH]>,
}

impl PlaneFeatures {
    /// Those of a level.
    pub fn new(exemplar: &ExemplarLevel<'_>, embedding: &Embedding) -> Self {
        let parts = embedding.dimensions.div_ceil(WIDTH).max(1);
        let vectors = exemplar.rows.iter().flat_map(|&row| {
            (0..parts).map(move |part| {
                let block = &embedding.plane(part * WIDTH / LANES)[row as usize];
                std::array::from_fn(|lane| block[part * WIDTH % LANES + lane])
            })
        });
        let mut features = Self {
            grid: exemplar.grid,
            parts,
            vectors: vectors.collect(),
        };
        let mean = features.mean_distance();
        if mean > 0.0 {
            let numbers = features.vectors.iter_mut().flatten();
            numbers.for_each(|number| *number /= mean);
        }
        features
    }

    /// How far random texels are apart.
    fn mean_distance(&self) -> f32 {
        let mut stream = random::stream(0, "texels by chance", 0, 0);
        let mut centre = || {
            let texel = stream.gen_range(0..self.grid.len() as u32);
            self.grid.centre(TexelIndex(texel))
        };
        let sum: f64 = (0..PAIRS)
            .map(|_| f64::from(self.distance(centre(), centre())))
            .sum();
        (sum / f64::from(PAIRS)) as f32
    }

    /// ‖F(a) − F(b)‖.
    #[inline]
    pub fn distance(&self, a: TexCoord, b: TexCoord) -> f32 {
        let ((a, u), (b, v)) = (self.corners(a), self.corners(b));
        let mut sums = [0.0f32; WIDTH];
        for part in 0..self.parts {
            let of = |corner: usize| &self.vectors[corner * self.parts + part];
            for (lane, sum) in sums.iter_mut().enumerate() {
                let here = (0..4).map(|at| u[at] * of(a[at])[lane]).sum::<f32>();
                let there = (0..4).map(|at| v[at] * of(b[at])[lane]).sum::<f32>();
                *sum += (here - there) * (here - there);
            }
        }
        sums.iter().sum::<f32>().sqrt()
    }

    /// The texels round a coordinate and their weights.
    #[inline]
    fn corners(&self, at: TexCoord) -> ([usize; 4], [f32; 4]) {
        let (x, y) = (at.s - 0.5, self.grid.height as f32 - at.t - 0.5);
        let (col, row) = (floor(x), floor(y));
        let (u, v) = (x - col as f32, y - row as f32);
        let TexelGrid {
            width,
            height,
            tileable,
        } = self.grid;
        let cols = [col, col + 1].map(|col| place(col, width, tileable));
        let rows = [row, row + 1].map(|row| place(row, height, tileable));
        let texel = |row: usize, col: usize| row * width as usize + col;
        (
            [
                texel(rows[0], cols[0]),
                texel(rows[0], cols[1]),
                texel(rows[1], cols[0]),
                texel(rows[1], cols[1]),
            ],
            [(1.0 - u) * (1.0 - v), u * (1.0 - v), (1.0 - u) * v, u * v],
        )
    }
}

/// A row or column on the grid: wrapped if it is tileable, else the nearest.
#[inline]
fn place(at: i32, side: u32, tileable: bool) -> usize {
    let side = side as i32;
    let at = match tileable {
        _ if (0..side).contains(&at) => at,
        true => at.rem_euclid(side),
        false => at.clamp(0, side - 1),
    };
    at as usize
}

/// ⌊value⌋, without the call that `f32::floor` is on processors of old.
#[inline(always)]
fn floor(value: f32) -> i32 {
    let whole = value as i32;
    whole - i32::from(whole as f32 > value)
}
