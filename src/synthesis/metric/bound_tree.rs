//! A tree of projected windows, so that a search of all texels compares few of them.
//!
//! A window is a point: its coordinate in every direction, and the norm of the remainder. The lower
//! bound of two windows' distance is the squared distance of their points. Every node of the tree has the box of its
//! points; a box farther away than what a search still keeps is skipped whole. Leaves have as many points as a block
//! has lanes, at most. What is left is held against its [finer bound](super::fine_bounds), where there is one.

use crate::lanes::{LANES, LaneBlock, sum_of_lanes};
use crate::synthesis::keep::Keep;
use crate::synthesis::metric::fine_bounds::{FinePattern, FinePoint};
use crate::synthesis::metric::projection::{DIRECTIONS, Projected, SLACK};

/// Points that are ordered by one thread.
const FEW: usize = 1 << 12;
/// Nodes that wait at most while the tree is searched: one per level of a tree of 2³² leaves, and one more.
const MOST_WAITING: usize = 34;

/// A texel's projected window.
#[derive(Clone, Copy, Debug)]
pub struct Point {
    /// The texel.
    pub texel: u32,
    /// In the directions of the tree.
    pub first: Projected,
    /// In the finer ones, where they are asked for.
    pub fine: FinePoint,
}

/// The tree.
#[derive(Clone, Debug)]
pub struct BoundTree {
    /// The boxes of all nodes: the root's, then level after level; those below node i are 2i + 1 and 2i + 2.
    boxes: Vec<Extent>,
    /// The nodes of the last level, from left to right.
    leaves: Vec<Leaf>,
}

/// The box of some points.
#[derive(Clone, Copy, Debug)]
struct Extent {
    low: LaneBlock,
    high: LaneBlock,
    /// The least and the largest norm that the directions leave.
    residuals: [f32; 2],
    /// The largest squared norm of a whole window.
    square: f32,
}

/// A few points, direction after direction.
#[derive(Clone, Debug)]
struct Leaf {
    projections: [LaneBlock; DIRECTIONS],
    residuals: LaneBlock,
    squares: LaneBlock,
    fine: [FinePoint; LANES],
    texels: [u32; LANES],
    count: usize,
}

impl BoundTree {
    /// The tree of some texels' windows.
    pub fn new(points: &[Point]) -> Self {
        let levels = points
            .len()
            .div_ceil(LANES)
            .max(1)
            .next_power_of_two()
            .ilog2();
        let mut order: Vec<u32> = (0..points.len() as u32).collect();
        halve(&mut order, points, levels);
        let mut leaves = Vec::with_capacity(1 << levels);
        collect_leaves(&order, levels, &mut |of_leaf| {
            leaves.push(Leaf::new(of_leaf, points));
        });
        let inner = leaves.len() - 1;
        let mut boxes = vec![Extent::NONE; inner + leaves.len()];
        let mut at = inner;
        collect_leaves(&order, levels, &mut |of_leaf| {
            let extents = of_leaf
                .iter()
                .map(|&index| Extent::of(&points[index as usize].first));
            boxes[at] = extents.fold(Extent::NONE, Extent::with);
            at += 1;
        });
        for node in (0..inner).rev() {
            boxes[node] = boxes[2 * node + 1].with(boxes[2 * node + 2]);
        }
        Self { boxes, leaves }
    }

    /// Compares the texels that bounds do not rule out, near ones first.
    #[inline(always)]
    pub fn search(
        &self,
        pattern: &Projected,
        fine: Option<&FinePattern>,
        keep: &mut impl Keep,
        mut distance: impl FnMut(u32, f64) -> f64,
    ) {
        // Visit the tree, the nearer box first; leave out boxes beyond the limit.
        let inner = self.leaves.len() - 1;
        let mut waiting = [(0, f32::NEG_INFINITY); MOST_WAITING];
        let mut count = 1;
        while count > 0 {
            count -= 1;
            let (node, bound) = waiting[count];
            if bound > keep.limit() as f32 {
                continue;
            }
            // Compare the texels of a leaf.
            if node >= inner {
                self.leaves[node - inner].search(pattern, fine, keep, &mut distance);
                continue;
            }
            let (left, right) = (2 * node + 1, 2 * node + 2);
            let left = (left, self.boxes[left].bound(pattern));
            let right = (right, self.boxes[right].bound(pattern));
            let (far, near) = match left.1 < right.1 {
                true => (right, left),
                false => (left, right),
            };
            (waiting[count], waiting[count + 1]) = (far, near);
            count += 2;
        }
    }
}

/// Orders points so that on every one of some levels the two halves lie apart in the direction of their largest spread.
fn halve(order: &mut [u32], points: &[Point], levels: u32) {
    if levels == 0 {
        return;
    }
    // Find the direction of the largest spread.
    let extents = order
        .iter()
        .map(|&index| Extent::of(&points[index as usize].first));
    let direction = extents.fold(Extent::NONE, Extent::with).longest();
    let along = |index: u32| {
        let Projected { projection, rest } = points[index as usize].first;
        projection
            .0
            .get(direction)
            .copied()
            .unwrap_or(rest.residual)
    };
    // Divide at the median.
    let middle = order.len() / 2;
    if middle > 0 {
        order.select_nth_unstable_by(middle, |&a, &b| {
            along(a).total_cmp(&along(b)).then(a.cmp(&b))
        });
    }
    // Halve both halves.
    let is_long = order.len() > FEW;
    let (left, right) = order.split_at_mut(middle);
    if is_long {
        rayon::join(
            || halve(left, points, levels - 1),
            || halve(right, points, levels - 1),
        );
    } else {
        halve(left, points, levels - 1);
        halve(right, points, levels - 1);
    }
}

/// Hands over the leaves of ordered points, from left to right.
fn collect_leaves(order: &[u32], levels: u32, leaf: &mut impl FnMut(&[u32])) {
    if levels == 0 {
        return leaf(order);
    }
    let (left, right) = order.split_at(order.len() / 2);
    collect_leaves(left, levels - 1, leaf);
    collect_leaves(right, levels - 1, leaf);
}

impl Extent {
    /// The box of no point.
    const NONE: Self = Self {
        low: [f32::INFINITY; LANES],
        high: [f32::NEG_INFINITY; LANES],
        residuals: [f32::INFINITY, f32::NEG_INFINITY],
        square: 0.0,
    };

    fn of(window: &Projected) -> Self {
        Self {
            low: window.projection.0,
            high: window.projection.0,
            residuals: [window.rest.residual; 2],
            square: window.rest.square,
        }
    }

    /// The box of two.
    fn with(mut self, other: Self) -> Self {
        for lane in 0..LANES {
            self.low[lane] = self.low[lane].min(other.low[lane]);
            self.high[lane] = self.high[lane].max(other.high[lane]);
        }
        let ([low, high], [other_low, other_high]) = (self.residuals, other.residuals);
        self.residuals = [low.min(other_low), high.max(other_high)];
        self.square = self.square.max(other.square);
        self
    }

    /// The direction in which it is longest; one past all directions for the residual.
    fn longest(&self) -> usize {
        let spreads = self
            .low
            .iter()
            .zip(&self.high)
            .map(|(low, high)| high - low);
        let spreads = spreads.chain([self.residuals[1] - self.residuals[0]]);
        let longest = spreads.enumerate().max_by(|a, b| a.1.total_cmp(&b.1));
        longest.map_or(0, |(direction, _)| direction)
    }

    /// A lower bound of the bounds of all points inside.
    #[inline(always)]
    fn bound(&self, pattern: &Projected) -> f32 {
        let mut squares = [0.0; LANES];
        for (lane, square) in squares.iter_mut().enumerate() {
            let at = pattern.projection.0[lane];
            *square = beyond(at, self.low[lane], self.high[lane]);
        }
        let [low, high] = self.residuals;
        let rest = pattern.rest;
        let slack = SLACK * (rest.square + self.square);
        sum_of_lanes(squares) + beyond(rest.residual, low, high) - slack
    }
}

/// The squared distance of a number to a range.
#[inline(always)]
fn beyond(at: f32, low: f32, high: f32) -> f32 {
    let (below, above) = (low - at, at - high);
    let beyond = if below > above { below } else { above };
    let beyond = if beyond > 0.0 { beyond } else { 0.0 };
    beyond * beyond
}

impl Leaf {
    fn new(order: &[u32], points: &[Point]) -> Self {
        let mut leaf = Self {
            projections: [[0.0; LANES]; DIRECTIONS],
            residuals: [0.0; LANES],
            squares: [0.0; LANES],
            fine: [FinePoint::default(); LANES],
            texels: [0; LANES],
            count: order.len(),
        };
        for (lane, &index) in order.iter().enumerate() {
            let Point { texel, first, fine } = points[index as usize];
            let Projected { projection, rest } = first;
            for (direction, &number) in projection.0.iter().enumerate() {
                leaf.projections[direction][lane] = number;
            }
            (leaf.residuals[lane], leaf.squares[lane]) = (rest.residual, rest.square);
            (leaf.fine[lane], leaf.texels[lane]) = (fine, texel);
        }
        leaf
    }

    /// Compares its texels that neither bound rules out.
    #[inline(always)]
    fn search(
        &self,
        pattern: &Projected,
        fine: Option<&FinePattern>,
        keep: &mut impl Keep,
        distance: &mut impl FnMut(u32, f64) -> f64,
    ) {
        let (sums, bounds) = self.bounds(pattern);
        let mut left = lanes_within(&bounds, keep.limit() as f32) & ((1 << self.count) - 1);
        while left != 0 {
            let lane = left.trailing_zeros() as usize;
            left &= left - 1;
            let limit = keep.limit();
            let bound = fine.map(|fine| fine.bound(sums[lane], &self.fine[lane]));
            if bound.is_none_or(|bound| bound <= limit as f32) {
                let texel = self.texels[lane];
                keep.offer(texel, distance(texel, limit));
            }
        }
    }

    /// The squared distances in the directions of the tree, and the bounds that they make with the residuals.
    #[inline(always)]
    fn bounds(&self, pattern: &Projected) -> (LaneBlock, LaneBlock) {
        let mut sums = [0.0; LANES];
        for (own, others) in pattern.projection.0.iter().zip(&self.projections) {
            for lane in 0..LANES {
                let apart = own - others[lane];
                sums[lane] += apart * apart;
            }
        }
        let (rest, mut bounds) = (pattern.rest, sums);
        for (lane, bound) in bounds.iter_mut().enumerate() {
            let apart = rest.residual - self.residuals[lane];
            *bound += apart * apart - SLACK * (rest.square + self.squares[lane]);
        }
        (sums, bounds)
    }
}

/// The lanes whose numbers are at most a limit, as bits. Not inlined, so that the loops that fill the block keep it in
/// whole vectors.
#[inline(never)]
fn lanes_within(block: &LaneBlock, limit: f32) -> u32 {
    let lanes = block.iter().enumerate();
    lanes.fold(0, |within, (lane, &number)| {
        within | u32::from(number <= limit) << lane
    })
}

#[cfg(test)]
mod tests {
    use rand::Rng;

    use super::*;
    use crate::random;
    use crate::synthesis::keep::Nearest;
    use crate::synthesis::metric::projection::{Projection, Residual};

    fn windows(count: usize) -> Vec<Projected> {
        let mut stream = random::stream(8, "windows", 0, 0);
        let window = |_| {
            let mut numbers = [0.0; LANES];
            for (direction, number) in numbers.iter_mut().enumerate() {
                *number = stream.gen_range(-1.0..1.0) / (1.0 + direction as f32);
            }
            let residual: f32 = stream.gen_range(0.0..0.2);
            let square = numbers.iter().map(|number| number * number).sum::<f32>();
            Projected {
                projection: Projection(numbers),
                rest: Residual {
                    residual,
                    square: square + residual * residual,
                },
            }
        };
        (0..count).map(window).collect()
    }

    fn points(texels: &[u32], windows: &[Projected]) -> Vec<Point> {
        let point = |(&texel, &first)| Point {
            texel,
            first,
            fine: FinePoint::default(),
        };
        texels.iter().zip(windows).map(point).collect()
    }

    #[test]
    fn the_nearest_are_found_and_few_are_compared() {
        for count in [0, 1, 7, 16, 17, 100, 5000] {
            let windows = windows(count);
            let texels: Vec<u32> = (0..count as u32).map(|index| 3 * index + 1).collect();
            let tree = BoundTree::new(&points(&texels, &windows));
            let mut compared = 0;
            for pattern in self::windows(40) {
                let bound = |texel: u32| {
                    let window = &windows[texel as usize / 3];
                    f64::from(pattern.bound(&window.projection, window.rest)) + 0.001
                };
                let (mut found, mut expected) = (Nearest::new(8, 1.5), Nearest::new(8, 1.5));
                tree.search(&pattern, None, &mut found, |texel, _| {
                    compared += 1;
                    bound(texel)
                });
                texels
                    .iter()
                    .for_each(|&texel| expected.offer(texel, bound(texel)));
                assert_eq!(found.kept(), expected.kept(), "{count}");
            }
            if count == 5000 {
                assert!(compared < 40 * 400, "{compared}");
            }
        }
    }

    #[test]
    fn a_search_that_keeps_all_sees_every_texel_once() {
        let texels: Vec<u32> = (0..777).collect();
        let windows = windows(777);
        let tree = BoundTree::new(&points(&texels, &windows));
        let mut all = Nearest::new(1000, f64::INFINITY);
        tree.search(&windows[5], None, &mut all, |texel, _| {
            1.0 + f64::from(texel)
        });
        assert!(all.kept().iter().map(|&(_, texel)| texel).eq(0..777));
    }
}
