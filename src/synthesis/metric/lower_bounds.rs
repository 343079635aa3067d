//! Lower bounds by which a search skips most distances and still finds the same texels.
//!
//! The windows of all whole texels are projected once on a few orthonormal directions B, near their
//! principal ones. For a site's pattern f and a texel's window e, both weighted by √w,
//! ‖f − e‖² ≥ ‖Bᵀf − Bᵀe‖² + (‖f − BBᵀf‖ − ‖e − BBᵀe‖)², whatever the directions: a texel whose
//! bound is above the best distance so far need not be compared. A search of all texels of a
//! plain image has [finer bounds](super::fine_bounds) as well, in more directions; the windows of textons have so many
//! numbers that projecting on these costs more than they spare.

use macro_rules_attribute::apply;
use nalgebra::DMatrix;
use rand::Rng;
use rayon::prelude::*;

use crate::lanes::{LANES, LaneBlock, vectorized};
use crate::random;
use crate::synthesis::candidates::forward::Candidate;
use crate::synthesis::keep::{Keep, Pick, smallest};
use crate::synthesis::metric::bound_tree::{BoundTree, Point};
use crate::synthesis::metric::fine_bounds::{FINE_BLOCKS, FinePattern, FinePoint};
use crate::synthesis::metric::projection::{DIRECTIONS, Projected, Projection, Residual, Sums};

/// Candidates from which on it pays to project a pattern for their bounds. That of textons has so many
/// numbers that it does not: their bounds are for full searches alone.
pub const MANY: usize = 4;
/// Windows the directions are found from.
const SAMPLES: usize = 256;
/// Rounds of subspace iteration.
const ROUNDS: usize = 2;

/// Per number of a window, its share in each direction, times √w.
#[derive(Clone, Debug)]
struct Basis {
    first: Vec<LaneBlock>,
    /// None where bounds in more directions cost more than they spare.
    fine: Option<[Vec<LaneBlock>; FINE_BLOCKS]>,
}

/// The projected windows of the whole texels of a level.
#[derive(Clone, Debug)]
pub struct ProjectedWindows {
    /// What every number of a window weighs.
    weights: Vec<f32>,
    basis: Basis,
    /// By texel, up to the last whole one; those that are not whole have none.
    projections: Vec<Projection>,
    rests: Vec<Residual>,
    tree: BoundTree,
}

impl ProjectedWindows {
    /// Finds the directions and projects the windows of the whole texels, ascending, on them; `window`
    /// appends the numbers of one, whole blocks that weigh `weights`. `has_fine` asks for finer bounds as well.
    pub fn new(
        weights: Vec<f32>,
        texels: &[u32],
        window: impl Fn(u32, &mut Vec<f32>) + Sync,
        (seed, level): (u64, u32),
        has_fine: bool,
    ) -> Self {
        // Find the directions.
        let basis = Basis::new(&weights, texels, &window, (seed, level), has_fine);
        // Project each window.
        let project = |numbers: &mut Vec<f32>, &texel: &u32| {
            numbers.clear();
            window(texel, numbers);
            let (first, fine) = project_apart(&basis, &weights, numbers);
            Point {
                texel,
                first,
                fine: fine.as_ref().map(FinePoint::new).unwrap_or_default(),
            }
        };
        let whole = texels.par_iter().with_min_len(4 * LANES);
        let whole: Vec<Point> = whole.map_init(Vec::new, project).collect();
        // Keep the projections by texel.
        let most = texels.last().map_or(0, |&last| last as usize + 1);
        let mut projections = vec![Projection::default(); most];
        let mut rests = vec![Residual::default(); most];
        for Point { texel, first, .. } in &whole {
            projections[*texel as usize] = first.projection;
            rests[*texel as usize] = first.rest;
        }
        Self {
            tree: BoundTree::new(&whole),
            projections,
            rests,
            basis,
            weights,
        }
    }

    /// Projects a pattern of two parts.
    #[inline(always)]
    pub fn project(&self, pattern: [&[f32]; 2]) -> Projected {
        sums(&self.basis.first, &self.weights, pattern).projected()
    }

    /// Projects a pattern of two parts on all directions.
    #[inline(always)]
    fn project_on_all(&self, pattern: [&[f32]; 2]) -> (Projected, Option<FinePattern>) {
        self.basis.project(&self.weights, pattern)
    }

    /// A lower bound of the distance of a pattern to a whole texel.
    #[inline(always)]
    pub fn bound(&self, pattern: &Projected, texel: u32) -> f32 {
        let texel = texel as usize;
        pattern.bound(&self.projections[texel], self.rests[texel])
    }
}

impl Basis {
    /// Orthonormal directions near the principal ones of the windows, by subspace iteration on a
    /// spread of them.
    fn new(
        weights: &[f32],
        texels: &[u32],
        window: impl Fn(u32, &mut Vec<f32>),
        (seed, level): (u64, u32),
        has_fine: bool,
    ) -> Self {
        // Gather a spread of weighted windows.
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
        // Start from random directions, and let the windows pull them.
        let mut stream = random::stream(seed, "full search directions", level, 0);
        let blocks = if has_fine { 1 + FINE_BLOCKS } else { 1 };
        let all = DIRECTIONS * blocks;
        let start = DMatrix::from_fn(windows.ncols(), all, |_, _| stream.gen_range(-1.0f32..1.0));
        let mut directions = (&windows * start).qr().q();
        for _ in 0..ROUNDS {
            directions = (&windows * windows.tr_mul(&directions)).qr().q();
        }
        // Fold the weights into the directions.
        let rows = |first: usize| {
            let row = |(index, root): (usize, &f32)| {
                let mut row = [0.0; LANES];
                let directions = directions.row(index);
                for (slot, direction) in row.iter_mut().zip(directions.iter().skip(first)) {
                    *slot = direction * root;
                }
                row
            };
            roots.iter().enumerate().map(row).collect()
        };
        Self {
            first: rows(0),
            fine: has_fine.then(|| std::array::from_fn(|block| rows((1 + block) * DIRECTIONS))),
        }
    }

    /// Projects the two parts of a window.
    #[inline(always)]
    fn project(&self, weights: &[f32], window: [&[f32]; 2]) -> (Projected, Option<FinePattern>) {
        let first = sums(&self.first, weights, window);
        let fine = self.fine.as_ref().map(|blocks| {
            let fine = blocks.each_ref().map(|basis| sums(basis, weights, window));
            FinePattern::new(&first, &fine)
        });
        (first.projected(), fine)
    }
}

/// What the two parts of a window give in the directions of a block.
#[inline(always)]
fn sums(basis: &[LaneBlock], weights: &[f32], window: [&[f32]; 2]) -> Sums {
    let (basis, more_basis) = basis.split_at(window[0].len());
    let (weights, more_weights) = weights.split_at(window[0].len());
    let mut sums = Sums::default();
    sums.add(basis, weights, window[0]);
    sums.add(more_basis, more_weights, window[1]);
    sums
}

/// The projection of a window.
#[apply(vectorized!)]
fn project_apart(
    basis: &Basis,
    weights: &[f32],
    numbers: &[f32],
) -> (Projected, Option<FinePattern>) {
    basis.project(weights, [numbers, &[]])
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
    let (first, fine) = windows.project_on_all(pattern);
    windows.tree.search(&first, fine.as_ref(), keep, distance);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthesis::keep::Nearest;

    /// Forty windows of 48 numbers that lie in a space of some dimensions.
    fn windows(dimensions: usize) -> Vec<Vec<f32>> {
        let mut stream = random::stream(3, "test", 0, 0);
        let spanning: Vec<f32> = (0..dimensions * 48)
            .map(|_| stream.gen_range(-1.0..1.0))
            .collect();
        let window = |_| {
            let shares: Vec<f32> = (0..dimensions)
                .map(|_| stream.gen_range(-1.0f32..1.0))
                .collect();
            let number = |at: usize| {
                (0..dimensions)
                    .map(|i| shares[i] * spanning[48 * i + at])
                    .sum()
            };
            (0..48).map(number).collect()
        };
        (0..40).map(window).collect()
    }

    #[test]
    fn bounds_are_below_distances_and_tight_where_directions_span_the_windows() {
        // The first directions span a space of 8 dimensions, all directions one of 30.
        for dimensions in [8, 30] {
            let windows = windows(dimensions);
            let weights: Vec<f32> = (0..48).map(|at| (at % 3) as f32).collect();
            let texels: Vec<u32> = (0..40).collect();
            let window = |texel: u32, out: &mut Vec<f32>| out.extend(&windows[texel as usize]);
            let projected = ProjectedWindows::new(weights.clone(), &texels, window, (1, 0), true);
            for own in &windows {
                let parts = [&own[..16], &own[16..]];
                let (first, fine) = projected.project_on_all(parts);
                let fine = fine.unwrap();
                for (texel, other) in (0..).zip(&windows) {
                    let terms = own.iter().zip(other).zip(&weights);
                    let distance: f32 = terms.map(|((a, b), w)| w * (a - b).powi(2)).sum();
                    let bound = projected.bound(&first, texel);
                    let in_first: f32 = {
                        let others = &projected.projections[texel as usize].0;
                        let pairs = first.projection.0.iter().zip(others);
                        pairs.map(|(a, b)| (a - b).powi(2)).sum()
                    };
                    let (_, point) = projected.project_on_all([&other[..16], &other[16..]]);
                    let finer = fine.bound(in_first, &FinePoint::new(&point.unwrap()));
                    let tight = match dimensions {
                        8 => bound,
                        _ => finer,
                    };
                    assert!(bound <= distance && finer <= distance, "{bound} {distance}");
                    assert!(tight > 0.96 * distance - 0.05, "{tight} {distance}");
                }
            }
        }
    }

    #[test]
    fn a_search_finds_what_comparing_all_finds() {
        let windows = windows(30);
        let texels: Vec<u32> = (0..40).collect();
        let window = |texel: u32, out: &mut Vec<f32>| out.extend(&windows[texel as usize]);
        let projected = ProjectedWindows::new(vec![1.0; 48], &texels, window, (1, 0), true);
        for own in &windows {
            // A window with noise, as synthesized ones have.
            let pattern: Vec<f32> = own.iter().map(|number| 0.9 * number + 0.1).collect();
            let distance = |texel: u32| -> f64 {
                let pairs = pattern.iter().zip(&windows[texel as usize]);
                pairs.map(|(a, b)| f64::from((a - b).powi(2))).sum()
            };
            let (mut found, mut expected) = (Nearest::new(3, 1.5), Nearest::new(3, 1.5));
            let parts = [&pattern[..16], &pattern[16..]];
            search_within(&projected, parts, &mut found, |texel, _| distance(texel));
            texels
                .iter()
                .for_each(|&texel| expected.offer(texel, distance(texel)));
            assert_eq!(found.kept(), expected.kept());
        }
    }
}
