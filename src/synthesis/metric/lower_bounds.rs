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
use crate::synthesis::metric::bound_tree::BoundTree;
use crate::synthesis::metric::projection::{DIRECTIONS, Projected, Projection, Residual, Sums};

/// Candidates from which on it pays to project a pattern for their bounds. That of textons has so many
/// numbers that it does not: their bounds are for full searches alone.
pub const MANY: usize = 4;
/// Windows the directions are found from.
const SAMPLES: usize = 256;
/// Rounds of subspace iteration.
const ROUNDS: usize = 2;

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
    tree: BoundTree,
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
            tree: BoundTree::new(texels, &whole),
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
        let texel = texel as usize;
        pattern.bound(&self.projections[texel], self.rests[texel])
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

/// Compares the whole texels whose lower bounds do not rule them out.
#[inline(always)]
pub fn search_within(
    windows: &ProjectedWindows,
    pattern: [&[f32]; 2],
    keep: &mut impl Keep,
    distance: impl FnMut(u32, f64) -> f64,
) {
    windows
        .tree
        .search(&windows.project(pattern), keep, distance);
}

#[cfg(test)]
mod tests {
    use super::*;

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
        for own in &windows {
            let pattern = projected.project([&own[..16], &own[16..]]);
            for (texel, other) in (0..).zip(&windows) {
                let terms = own.iter().zip(other).zip(&weights);
                let distance: f32 = terms.map(|((a, b), w)| w * (a - b).powi(2)).sum();
                let bound = projected.bound(&pattern, texel);
                assert!(
                    bound <= distance && bound > 0.99 * distance - 1e-2,
                    "{bound} {distance}"
                );
            }
        }
    }
}
