//! Full search without most of its distances, and exact all the same.
//!
//! The windows of all whole texels are projected once on a few orthonormal directions B, near their
//! principal ones. For a site's pattern f and a texel's window e, both weighted by √w,
//! ‖f − e‖² ≥ ‖Bᵀf − Bᵀe‖² + (‖f − BBᵀf‖ − ‖e − BBᵀe‖)², whatever the directions: a texel whose
//! bound is above the best distance so far need not be compared.

use multiversion::multiversion;
use nalgebra::DMatrix;
use rand::Rng;

use crate::random;
use crate::synthesis::embedded::{EmbeddedMetric, EmbeddedPattern, PatternPart, sum_of_lanes};
use crate::synthesis::embedding::{Block, LANES};
use crate::synthesis::exemplar_level::ExemplarLevel;

/// Blocks of projected numbers.
const BLOCKS: usize = 2;
/// Directions projected on.
const DIRECTIONS: usize = BLOCKS * LANES;
/// Windows the directions are found from.
const SAMPLES: usize = 1024;
/// Rounds of subspace iteration.
const ROUNDS: usize = 3;
/// Share of both windows' squared norms by which a bound is lowered, against the rounding of single
/// precision: directions, projections and residuals are each good to about 1e-6 of them.
const SLACK: f32 = 8e-6;

type Projection = [Block; BLOCKS];

/// The projected windows of the whole texels of a level.
#[derive(Clone, Debug)]
pub struct ProjectedWindows {
    /// Per number of a pattern, its share in each direction, times √w.
    basis: Vec<Projection>,
    /// Per whole texel the projection of its window.
    projections: Vec<Projection>,
    /// Per whole texel what the directions leave of its window.
    rests: Vec<Rest>,
}

/// What the directions leave of a window.
#[derive(Clone, Copy, Debug)]
struct Rest {
    /// The norm of what is left.
    residual: f32,
    /// The squared norm of the whole.
    square: f32,
}

impl ProjectedWindows {
    /// Finds the directions and projects every whole texel's window on them.
    pub fn new(
        metric: &EmbeddedMetric<'_>,
        exemplar: &ExemplarLevel<'_>,
        seed: u64,
        level: u32,
    ) -> Self {
        let texels = &exemplar.whole_texels;
        let mut pattern = EmbeddedPattern::default();
        let mut projected = Self {
            basis: basis(metric, texels, seed, level),
            projections: Vec::with_capacity(texels.len()),
            rests: Vec::with_capacity(texels.len()),
        };
        for &texel in texels {
            metric.pattern_of_texel(texel, &mut pattern);
            let (projection, rest) = project(&projected.basis, &pattern);
            projected.projections.push(projection);
            projected.rests.push(rest);
        }
        projected
    }

    /// Lower bounds of the distances of a pattern to every whole texel, in their order.
    pub fn bounds(&self, pattern: &EmbeddedPattern, bounds: &mut Vec<f32>) {
        let (projection, rest) = project(&self.basis, pattern);
        bounds.clear();
        fill_bounds(self, &projection, rest, bounds);
    }
}

/// Orthonormal directions near the principal ones of the windows, by subspace iteration on a
/// spread of them; rows times √w.
fn basis(metric: &EmbeddedMetric<'_>, texels: &[u32], seed: u64, level: u32) -> Vec<Projection> {
    let step = texels.len().div_ceil(SAMPLES).max(1);
    let mut pattern = EmbeddedPattern::default();
    let (mut columns, mut roots) = (Vec::new(), Vec::new());
    for &texel in texels.iter().step_by(step) {
        metric.pattern_of_texel(texel, &mut pattern);
        roots = weight_roots(&pattern);
        let numbers = numbers(&pattern).zip(&roots);
        columns.extend(numbers.map(|(number, root)| number * root));
    }
    let windows = DMatrix::from_vec(roots.len(), columns.len() / roots.len().max(1), columns);
    let mut stream = random::stream(seed, "full search directions", level, 0);
    let start = DMatrix::from_fn(windows.ncols(), DIRECTIONS, |_, _| {
        stream.gen_range(-1.0f32..1.0)
    });
    let mut directions = (&windows * start).qr().q();
    for _ in 0..ROUNDS {
        directions = (&windows * windows.tr_mul(&directions)).qr().q();
    }
    let row = |(index, root): (usize, &f32)| {
        let mut row = [[0.0; LANES]; BLOCKS];
        let slots = row.as_flattened_mut().iter_mut();
        for (slot, direction) in slots.zip(directions.row(index).iter()) {
            *slot = direction * root;
        }
        row
    };
    roots.iter().enumerate().map(row).collect()
}

/// All numbers of a pattern, fine samples first.
fn numbers(pattern: &EmbeddedPattern) -> impl Iterator<Item = f32> + '_ {
    let parts = [&pattern.fine, &pattern.coarse];
    parts
        .into_iter()
        .flat_map(|part| part.values.as_flattened().iter().copied())
}

/// √w of every number of a pattern.
fn weight_roots(pattern: &EmbeddedPattern) -> Vec<f32> {
    let of_part = |part: &PatternPart| {
        let roots = part.value_weights().map(f32::sqrt);
        roots
            .flat_map(|root| std::iter::repeat_n(root, LANES))
            .collect::<Vec<f32>>()
    };
    [of_part(&pattern.fine), of_part(&pattern.coarse)].concat()
}

/// Bᵀf, and what it leaves of f.
fn project(basis: &[Projection], pattern: &EmbeddedPattern) -> (Projection, Rest) {
    let mut projection = [[0.0; LANES]; BLOCKS];
    let mut norm = 0.0;
    let mut rest = basis;
    for part in [&pattern.fine, &pattern.coarse] {
        let (rows, after) = rest.split_at(part.values.len() * LANES);
        add_projection(&mut projection, rows, part.values.as_flattened());
        norm += weighted_norm(part);
        rest = after;
    }
    let held: f64 = projection
        .as_flattened()
        .iter()
        .map(|&number| f64::from(number).powi(2))
        .sum();
    let rest = Rest {
        residual: (norm - held).max(0.0).sqrt() as f32,
        square: norm as f32,
    };
    (projection, rest)
}

/// Σ w ‖value‖² of a part.
fn weighted_norm(part: &PatternPart) -> f64 {
    let values = part.values.iter().zip(part.value_weights());
    values
        .map(|(block, weight)| {
            let squares = block.map(|number| number * number);
            f64::from(weight) * f64::from(sum_of_lanes(&squares))
        })
        .sum()
}

#[multiversion(targets(
    "x86_64+avx512f+avx512bw+avx512vl+avx2+fma",
    "x86_64+avx2+fma",
    "aarch64+neon"
))]
fn add_projection(projection: &mut Projection, rows: &[Projection], numbers: &[f32]) {
    let mut sums = *projection;
    for (row, &number) in rows.iter().zip(numbers) {
        for (sums, row) in sums.iter_mut().zip(row) {
            for lane in 0..LANES {
                sums[lane] += number * row[lane];
            }
        }
    }
    *projection = sums;
}

#[multiversion(targets(
    "x86_64+avx512f+avx512bw+avx512vl+avx2+fma",
    "x86_64+avx2+fma",
    "aarch64+neon"
))]
fn fill_bounds(
    windows: &ProjectedWindows,
    projection: &Projection,
    rest: Rest,
    bounds: &mut Vec<f32>,
) {
    let texels = windows.projections.iter().zip(&windows.rests);
    bounds.extend(texels.map(|(window, left)| {
        let mut squares = [0.0; LANES];
        for (a, b) in projection.iter().zip(window) {
            for lane in 0..LANES {
                let difference = a[lane] - b[lane];
                squares[lane] += difference * difference;
            }
        }
        let apart = rest.residual - left.residual;
        sum_of_lanes(&squares) + apart * apart - SLACK * (rest.square + left.square)
    }));
}
