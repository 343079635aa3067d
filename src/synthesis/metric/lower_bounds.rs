//! Lower bounds that spare a search most of its distances, and leave what it finds the same.
//!
//! The windows of all whole texels are projected once on a few orthonormal directions B, near their
//! principal ones. For a site's pattern f and a texel's window e, both weighted by √w,
//! ‖f − e‖² ≥ ‖Bᵀf − Bᵀe‖² + (‖f − BBᵀf‖ − ‖e − BBᵀe‖)², whatever the directions: a texel whose
//! bound is above the best distance so far need not be compared.

use multiversion::multiversion;
use nalgebra::DMatrix;
use rand::Rng;
use rayon::prelude::*;

use crate::exemplar::embedding::{Block, LANES};
use crate::random;
use crate::synthesis::candidates::forward::Candidate;
use crate::synthesis::keep::{Keep, Pick, smallest};

/// Candidates from which on it pays to project a pattern for their bounds. That of textons has so many
/// numbers that it does not: their bounds are for full searches alone.
pub const MANY: usize = 4;
/// Directions projected on.
const DIRECTIONS: usize = LANES;
/// Windows the directions are found from.
const SAMPLES: usize = 256;
/// Rounds of subspace iteration.
const ROUNDS: usize = 2;
/// Sums that a projection is added up in side by side.
const CHAINS: usize = 4;
/// Share of both windows' squared norms by which a bound is lowered, against the rounding of single
/// precision: directions, projections and residuals are each good to some 1e-6 of them.
const SLACK: f32 = 2e-5;

/// What a window gives in every direction, aligned as processors load it fastest.
#[repr(C, align(64))]
#[derive(Clone, Copy, Debug, Default)]
struct Projection(Block);

/// What the directions leave of a window.
#[derive(Clone, Copy, Debug, Default)]
struct Residual {
    /// The norm of what is left.
    residual: f32,
    /// The squared norm of the whole.
    square: f32,
}

/// A projected pattern.
#[derive(Clone, Copy, Debug, Default)]
pub struct Projected {
    projection: Projection,
    rest: Residual,
}

/// The projected windows of the whole texels of a level.
#[derive(Clone, Debug)]
pub struct ProjectedWindows {
    /// What every number of a window weighs.
    weights: Vec<f32>,
    /// Per number of a window, its share in each direction, times √w.
    basis: Vec<Block>,
    /// By texel, up to the last whole one; those that are not whole have none.
    projections: Vec<Projection>,
    rests: Vec<Residual>,
    /// Whole texels in all, and they in their order.
    whole: usize,
    groups: Vec<Group>,
}

/// The projected windows of as many whole texels as a block has lanes, direction after direction, and
/// what the directions leave of them.
#[derive(Clone, Debug)]
struct Group {
    projections: [Block; DIRECTIONS],
    residuals: Block,
    squares: Block,
}

impl ProjectedWindows {
    /// Finds the directions and projects the windows of the whole texels, ascending, on them; `window`
    /// appends the numbers of one, whole blocks that weigh `weights`.
    pub fn new(
        weights: Vec<f32>,
        texels: &[u32],
        window: impl Fn(u32, &mut Vec<f32>) + Sync,
        seed: u64,
        level: u32,
    ) -> Self {
        let basis = basis(&weights, texels, &window, seed, level);
        let project = |numbers: &mut Vec<f32>, &texel: &u32| {
            numbers.clear();
            window(texel, numbers);
            project_apart(&basis, &weights, numbers)
        };
        let whole = texels.par_iter().with_min_len(4 * LANES);
        let whole: Vec<Projected> = whole.map_init(Vec::new, project).collect();
        let most = texels.last().map_or(0, |&last| last as usize + 1);
        let mut projections = vec![Projection::default(); most];
        let mut rests = vec![Residual::default(); most];
        for (&texel, projected) in texels.iter().zip(&whole) {
            projections[texel as usize] = projected.projection;
            rests[texel as usize] = projected.rest;
        }
        Self {
            groups: whole.chunks(LANES).map(Group::of).collect(),
            whole: whole.len(),
            projections,
            rests,
            basis,
            weights,
        }
    }

    /// Projects a pattern of two parts.
    #[inline(always)]
    pub fn project(&self, pattern: [&[f32]; 2]) -> Projected {
        let (basis, more_basis) = self.basis.split_at(pattern[0].len());
        let (weights, more_weights) = self.weights.split_at(pattern[0].len());
        let mut sums = Sums::default();
        sums.add(basis, weights, pattern[0]);
        sums.add(more_basis, more_weights, pattern[1]);
        sums.projected()
    }

    /// A lower bound of the distance of a pattern to a whole texel.
    #[inline(always)]
    pub fn bound(&self, pattern: &Projected, texel: u32) -> f32 {
        let projection = &self.projections[texel as usize].0;
        let rest = self.rests[texel as usize];
        let mut squares = [0.0; LANES];
        for (lane, square) in squares.iter_mut().enumerate() {
            let apart = pattern.projection.0[lane] - projection[lane];
            *square = apart * apart;
        }
        let apart = pattern.rest.residual - rest.residual;
        let slack = SLACK * (pattern.rest.square + rest.square);
        sum_of_lanes(squares) + apart * apart - slack
    }

    /// Lower bounds of the distances of a pattern to every whole texel in their order.
    pub fn bounds(&self, pattern: [&[f32]; 2], bounds: &mut Vec<f32>) {
        bounds.clear();
        fill_bounds(self, pattern, bounds);
        bounds.truncate(self.whole);
    }
}

impl Group {
    fn of(texels: &[Projected]) -> Self {
        let mut group = Self {
            projections: [[0.0; LANES]; DIRECTIONS],
            residuals: [0.0; LANES],
            squares: [0.0; LANES],
        };
        for (lane, Projected { projection, rest }) in texels.iter().enumerate() {
            for (direction, &number) in projection.0.iter().enumerate() {
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
) -> Vec<Block> {
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
        let mut row = [0.0; LANES];
        for (slot, direction) in row.iter_mut().zip(directions.row(index).iter()) {
            *slot = direction * root;
        }
        row
    };
    roots.iter().enumerate().map(row).collect()
}

/// What numbers give in every direction, and their weighted squares, while they are summed.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    shares: [Block; CHAINS],
    squares: Block,
}

impl Sums {
    #[inline(always)]
    fn add(&mut self, basis: &[Block], weights: &[f32], numbers: &[f32]) {
        let basis = basis.as_chunks::<LANES>().0;
        let weights = weights.as_chunks::<LANES>().0;
        let blocks = numbers.as_chunks::<LANES>().0.iter().zip(weights);
        for ((numbers, weights), rows) in blocks.zip(basis) {
            for lane in 0..LANES {
                self.squares[lane] += weights[lane] * (numbers[lane] * numbers[lane]);
            }
            for (at, (number, row)) in numbers.iter().zip(rows).enumerate() {
                let shares = &mut self.shares[at % CHAINS];
                for lane in 0..LANES {
                    shares[lane] += number * row[lane];
                }
            }
        }
    }

    #[inline(always)]
    fn projected(&self) -> Projected {
        let [a, b, c, d] = &self.shares;
        let (mut shares, mut held) = ([0.0; LANES], [0.0; LANES]);
        for lane in 0..LANES {
            shares[lane] = (a[lane] + b[lane]) + (c[lane] + d[lane]);
            held[lane] = shares[lane] * shares[lane];
        }
        let square = sum_of_lanes(self.squares);
        Projected {
            projection: Projection(shares),
            rest: Residual {
                residual: (square - sum_of_lanes(held)).max(0.0).sqrt(),
                square,
            },
        }
    }
}

/// The projection of a window.
#[multiversion(targets(
    "x86_64+avx512f+avx512bw+avx512vl+avx2+fma",
    "x86_64+avx2+fma",
    "aarch64+neon"
))]
fn project_apart(basis: &[Block], weights: &[f32], numbers: &[f32]) -> Projected {
    let mut sums = Sums::default();
    sums.add(basis, weights, numbers);
    sums.projected()
}

/// The sum of all lanes, as a tree.
#[inline(always)]
fn sum_of_lanes(lanes: Block) -> f32 {
    let (mut eight, mut four) = ([0.0; 8], [0.0; 4]);
    for lane in 0..8 {
        eight[lane] = lanes[lane] + lanes[lane + 8];
    }
    for lane in 0..4 {
        four[lane] = eight[lane] + eight[lane + 4];
    }
    (four[0] + four[2]) + (four[1] + four[3])
}

#[multiversion(targets(
    "x86_64+avx512f+avx512bw+avx512vl+avx2+fma",
    "x86_64+avx2+fma",
    "aarch64+neon"
))]
fn fill_bounds(windows: &ProjectedWindows, pattern: [&[f32]; 2], bounds: &mut Vec<f32>) {
    let Projected { projection, rest } = windows.project(pattern);
    for group in &windows.groups {
        let mut bound = [0.0; LANES];
        for (own, others) in projection.0.iter().zip(&group.projections) {
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

/// The best of `first` and some candidates whose lower bounds do not rule them out.
#[inline(always)]
pub fn smallest_within(
    windows: &ProjectedWindows,
    pattern: [&[f32]; 2],
    candidates: &[Candidate],
    first: Option<Pick>,
    floor: f64,
    mut distance: impl FnMut(u32, f64) -> f64,
) -> Option<Pick> {
    let pattern = windows.project(pattern);
    smallest(candidates, first, floor, |texel, limit| {
        match windows.bound(&pattern, texel) > limit as f32 {
            true => f64::INFINITY,
            false => distance(texel, limit),
        }
    })
}

/// Compares the texels of a list whose lower bounds do not rule them out; the most promising comes first.
#[inline(always)]
pub fn search_within(
    bounds: &[f32],
    texels: &[u32],
    keep: &mut impl Keep,
    mut distance: impl FnMut(u32, f64) -> f64,
) {
    let Some(promising) = least(bounds) else {
        return;
    };
    let mut compare = |texel: u32| {
        keep.offer(texel, distance(texel, keep.limit()));
        keep.limit() as f32
    };
    let mut limit = compare(texels[promising]);
    for (at, (&texel, &bound)) in texels.iter().zip(bounds).enumerate() {
        if bound <= limit && at != promising {
            limit = compare(texel);
        }
    }
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
        let plane: Vec<f32> = (0..8 * 48).map(|_| stream.gen_range(-1.0..1.0)).collect();
        let windows: Vec<Vec<f32>> = (0..40)
            .map(|_| {
                let shares = [0.0; 8].map(|_: f32| stream.gen_range(-1.0f32..1.0));
                let number = |at: usize| (0..8).map(|i| shares[i] * plane[48 * i + at]).sum();
                (0..48).map(number).collect()
            })
            .collect();
        let weights: Vec<f32> = (0..48).map(|at| (at % 3) as f32).collect();
        let texels: Vec<u32> = (0..40).collect();
        let window = |texel: u32, out: &mut Vec<f32>| out.extend(&windows[texel as usize]);
        let projected = ProjectedWindows::new(weights.clone(), &texels, window, 1, 0);
        let mut bounds = Vec::new();
        for own in &windows {
            projected.bounds([&own[..16], &own[16..]], &mut bounds);
            let pattern = projected.project([&own[..16], &own[16..]]);
            for ((texel, other), &bound) in (0..).zip(&windows).zip(&bounds) {
                let terms = own.iter().zip(other).zip(&weights);
                let distance: f32 = terms.map(|((a, b), w)| w * (a - b).powi(2)).sum();
                for bound in [bound, projected.bound(&pattern, texel)] {
                    assert!(
                        bound <= distance && bound > 0.99 * distance - 1e-2,
                        "{bound} {distance}"
                    );
                }
            }
        }
    }
}
