//! Full search without most of its distances, and exact all the same.
//!
//! The windows of all whole texels are projected once on a few orthonormal directions B, near their
//! principal ones. For a site's pattern f and a texel's window e, both weighted by √w,
//! ‖f − e‖² ≥ ‖Bᵀf − Bᵀe‖² + (‖f − BBᵀf‖ − ‖e − BBᵀe‖)², whatever the directions: a texel whose
//! bound is above the best distance so far need not be compared.

use multiversion::multiversion;
use nalgebra::DMatrix;
use rand::Rng;
use rayon::prelude::*;

use crate::random;
use crate::synthesis::choice::{Pick, Preference};
use crate::synthesis::embedding::{Block, LANES};

/// Blocks of projected numbers.
const BLOCKS: usize = 1;
/// Directions projected on.
const DIRECTIONS: usize = BLOCKS * LANES;
/// Windows the directions are found from.
const SAMPLES: usize = 256;
/// Rounds of subspace iteration.
const ROUNDS: usize = 2;
/// Share of both windows' squared norms by which a bound is lowered, against the rounding of single
/// precision: directions, projections and residuals are each good to about 1e-6 of them.
const SLACK: f32 = 8e-6;

type Projection = [Block; BLOCKS];

/// The projected windows of the whole texels of a level.
#[derive(Clone, Debug)]
pub struct ProjectedWindows {
    /// What every number of a window weighs.
    weights: Vec<f32>,
    /// Per number of a window, its share in each direction, times √w.
    basis: Vec<Projection>,
    texels: usize,
    groups: Vec<Group>,
}

/// The projected windows of as many texels as a block has lanes, direction after direction, and what
/// the directions leave of them.
#[derive(Clone, Debug)]
struct Group {
    projections: [Block; DIRECTIONS],
    /// The norms of what is left.
    residuals: Block,
    /// The squared norms of the whole.
    squares: Block,
}

/// What the directions leave of a window.
#[derive(Clone, Copy, Debug, Default)]
struct Rest {
    residual: f32,
    square: f32,
}

impl ProjectedWindows {
    /// Finds the directions and projects the windows of `texels` on them; `window` appends the
    /// numbers of one, which weigh `weights`.
    pub fn new(
        weights: Vec<f32>,
        texels: &[u32],
        window: impl Fn(u32, &mut Vec<f32>) + Sync,
        seed: u64,
        level: u32,
    ) -> Self {
        let mut projected = Self {
            basis: basis(&weights, texels, &window, seed, level),
            weights,
            texels: texels.len(),
            groups: Vec::new(),
        };
        let groups = texels
            .par_chunks(LANES)
            .map_init(Vec::new, |numbers, group| {
                let projected_window = |&texel: &u32| {
                    numbers.clear();
                    window(texel, numbers);
                    projected.project([numbers, &[]])
                };
                Group::of(group.iter().map(projected_window))
            });
        projected.groups = groups.collect();
        projected
    }

    /// Lower bounds of the distances of a pattern, in two parts, to every texel in their order.
    pub fn bounds(&self, pattern: [&[f32]; 2], bounds: &mut Vec<f32>) {
        let (projection, rest) = self.project(pattern);
        bounds.clear();
        fill_bounds(&self.groups, projection.as_flattened(), rest, bounds);
        bounds.truncate(self.texels);
    }

    /// Bᵀf, and what it leaves of f.
    fn project(&self, pattern: [&[f32]; 2]) -> (Projection, Rest) {
        let mut projection = [[0.0; LANES]; BLOCKS];
        let (mut norm, mut begin) = (0.0, 0);
        for part in pattern {
            let numbers = begin..begin + part.len();
            begin = numbers.end;
            let (basis, weights) = (&self.basis[numbers.clone()], &self.weights[numbers]);
            norm += add_projection(&mut projection, basis, weights, part);
        }
        let squares = projection.as_flattened().iter();
        let held: f64 = squares.map(|&number| f64::from(number).powi(2)).sum();
        let rest = Rest {
            residual: (norm - held).max(0.0).sqrt() as f32,
            square: norm as f32,
        };
        (projection, rest)
    }
}

impl Group {
    fn of(texels: impl Iterator<Item = (Projection, Rest)>) -> Self {
        let mut group = Self {
            projections: [[0.0; LANES]; DIRECTIONS],
            residuals: [0.0; LANES],
            squares: [0.0; LANES],
        };
        for (lane, (projection, rest)) in texels.enumerate() {
            let directions = projection.as_flattened().iter();
            for (direction, &number) in directions.enumerate() {
                group.projections[direction][lane] = number;
            }
            (group.residuals[lane], group.squares[lane]) = (rest.residual, rest.square);
        }
        group
    }
}

/// Orthonormal directions near the principal ones of the windows, by subspace iteration on a
/// spread of them; rows times √w.
fn basis(
    weights: &[f32],
    texels: &[u32],
    window: impl Fn(u32, &mut Vec<f32>),
    seed: u64,
    level: u32,
) -> Vec<Projection> {
    let step = texels.len().div_ceil(SAMPLES).max(1);
    let mut numbers = Vec::new();
    for &texel in texels.iter().step_by(step) {
        window(texel, &mut numbers);
    }
    let roots: Vec<f32> = weights.iter().map(|weight| weight.sqrt()).collect();
    for (number, root) in numbers.iter_mut().zip(roots.iter().cycle()) {
        *number *= root;
    }
    let windows = DMatrix::from_vec(roots.len(), numbers.len() / roots.len().max(1), numbers);
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

/// Adds what some numbers give in every direction; returns Σ w · number².
#[multiversion(targets(
    "x86_64+avx512f+avx512bw+avx512vl+avx2+fma",
    "x86_64+avx2+fma",
    "aarch64+neon"
))]
fn add_projection(
    projection: &mut Projection,
    basis: &[Projection],
    weights: &[f32],
    numbers: &[f32],
) -> f64 {
    let mut sums = *projection;
    let mut norm = 0.0;
    for ((row, &number), &weight) in basis.iter().zip(numbers).zip(weights) {
        norm += f64::from(weight * number * number);
        for (sums, row) in sums.iter_mut().zip(row) {
            for lane in 0..LANES {
                sums[lane] += number * row[lane];
            }
        }
    }
    *projection = sums;
    norm
}

#[multiversion(targets(
    "x86_64+avx512f+avx512bw+avx512vl+avx2+fma",
    "x86_64+avx2+fma",
    "aarch64+neon"
))]
fn fill_bounds(groups: &[Group], projection: &[f32], rest: Rest, bounds: &mut Vec<f32>) {
    for group in groups {
        let mut bound = [0.0; LANES];
        for (own, others) in projection.iter().zip(&group.projections) {
            for lane in 0..LANES {
                let apart = own - others[lane];
                bound[lane] += apart * apart;
            }
        }
        for (lane, bound) in bound.iter_mut().enumerate() {
            let apart = rest.residual - group.residuals[lane];
            *bound += apart * apart - SLACK * (rest.square + group.squares[lane]);
        }
        bounds.extend_from_slice(&bound);
    }
}

/// The better of `first` and every texel of a list, none of them preferred, skipping those whose lower
/// bound is above the best so far; the most promising comes first.
#[inline(always)]
pub fn best_within(
    bounds: &[f32],
    texels: &[u32],
    first: Option<Pick>,
    preference: Preference,
    mut distance: impl FnMut(u32, f64) -> f64,
) -> Option<Pick> {
    let Preference { coherence, noise } = preference;
    let mut best = first;
    let mut consider = |texel: u32| {
        let limit = Pick::limit(best, coherence, noise);
        let pick = Pick::new(texel, distance(texel, limit), coherence, noise);
        if best.is_none_or(|best| pick.beats(&best)) {
            best = Some(pick);
        }
        Pick::limit(best, coherence, noise) as f32
    };
    let mut limit = consider(texels[least(bounds)?]);
    for (&texel, &bound) in texels.iter().zip(bounds) {
        if bound <= limit {
            limit = consider(texel);
        }
    }
    best
}

/// Where the first of the least numbers is; `None` when there are none.
#[inline(always)]
fn least(numbers: &[f32]) -> Option<usize> {
    let (blocks, rest) = numbers.as_chunks::<LANES>();
    let mut lanes = [f32::INFINITY; LANES];
    for block in blocks {
        for lane in 0..LANES {
            lanes[lane] = if block[lane] < lanes[lane] {
                block[lane]
            } else {
                lanes[lane]
            };
        }
    }
    let least = lanes
        .iter()
        .chain(rest)
        .copied()
        .fold(f32::INFINITY, f32::min);
    numbers.iter().position(|&number| number == least)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_of_the_least_is_found() {
        let mut numbers: Vec<f32> = (0..40).map(|at| (at as f32 - 20.0).abs()).collect();
        assert_eq!(least(&numbers), Some(20));
        (numbers[37], numbers[39]) = (-1.0, -1.0);
        assert_eq!(least(&numbers), Some(37));
        assert_eq!(least(&[]), None);
    }

    #[test]
    fn bounds_are_below_distances_and_tight_in_the_plane() {
        // Windows in a plane of few dimensions: the directions span them all.
        let mut stream = random::stream(3, "test", 0, 0);
        let plane: Vec<f32> = (0..8 * 50).map(|_| stream.gen_range(-1.0..1.0)).collect();
        let windows: Vec<Vec<f32>> = (0..40)
            .map(|_| {
                let shares = [0.0; 8].map(|_: f32| stream.gen_range(-1.0f32..1.0));
                let number = |at: usize| (0..8).map(|i| shares[i] * plane[50 * i + at]).sum();
                (0..50).map(number).collect()
            })
            .collect();
        let weights: Vec<f32> = (0..50).map(|at| (at % 3) as f32).collect();
        let texels: Vec<u32> = (0..40).collect();
        let window = |texel: u32, out: &mut Vec<f32>| out.extend(&windows[texel as usize]);
        let projected = ProjectedWindows::new(weights.clone(), &texels, window, 1, 0);
        let mut bounds = Vec::new();
        for own in &windows {
            projected.bounds([&own[..20], &own[20..]], &mut bounds);
            for (other, &bound) in windows.iter().zip(&bounds) {
                let terms = own.iter().zip(other).zip(&weights);
                let distance: f32 = terms.map(|((a, b), w)| w * (a - b).powi(2)).sum();
                assert!(
                    bound <= distance && bound > 0.99 * distance - 1e-2,
                    "{bound} {distance}"
                );
            }
        }
    }
}
