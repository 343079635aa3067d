//! The nearest of many points, weighted by how often each was used.
//!
//! A use of a point doubles its distance to whatever is compared with it, relative to the points that were used least
//! (Castellanos and Williams §3.11). Deviation: their set of trees, one per count, searched approximately, is one
//! static kd-tree here, searched exactly. Every node keeps the smallest count below it, so that
//! 2^(smallest − smallest of all) · (distance to its box) is a lower bound of what its points score.

mod splitting;

use multiversion::multiversion;

use crate::synthesis::recipes::choosy::counted_tree::splitting::{halve, leaf_starts};

/// Numbers in a block: points are padded with zeros to whole blocks.
const LANES: usize = 8;
/// Points per leaf, at most.
const LEAF: usize = 8;
/// Nodes that wait at most while the tree is searched: one per level of a tree of 2³² leaves, and one more.
const MOST_WAITING: usize = 34;
/// Uses beyond the smallest count that still change the score; 4^500 is finite.
const MOST_USES: u32 = 500;

type Block = [f32; LANES];

/// What a search found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Choice {
    /// The square of distance · 2^(count − smallest count).
    pub score: f64,
    /// How often the point was used before.
    pub count: u32,
    /// The point.
    pub item: u32,
    /// What the search was called by.
    pub phase: u8,
}

impl Choice {
    /// Nothing found yet.
    pub const NONE: Self = Self {
        score: f64::INFINITY,
        count: u32::MAX,
        item: u32::MAX,
        phase: u8::MAX,
    };

    /// Keeps the better of two: the smaller score, then count, then number of the point, then phase.
    #[inline(always)]
    pub fn offer(&mut self, other: Self) {
        let order = self.score.total_cmp(&other.score);
        let rest = |choice: &Self| (choice.count, choice.item, choice.phase);
        if order.then_with(|| rest(self).cmp(&rest(&other))).is_gt() {
            *self = other;
        }
    }
}

/// 4 to the power of the uses beyond the smallest count: the factor of a squared distance.
#[inline(always)]
pub fn penalty(count: u32, smallest: u32) -> f64 {
    let uses = count.saturating_sub(smallest).min(MOST_USES);
    f64::from_bits(u64::from(1023 + 2 * uses) << 52)
}

/// Points, their counts, and a tree over them.
///
/// Nodes stand as in a heap: those below node i are 2i + 1 and 2i + 2. Leaves are the last level, from left to right.
#[derive(Clone, Debug)]
pub struct CountedTree {
    /// Blocks per point.
    blocks: usize,
    /// The points in the order of the leaves.
    points: Vec<Block>,
    /// The number of every point, in the order of the leaves.
    items: Vec<u32>,
    /// How often every point was used, in the order of the leaves.
    counts: Vec<u32>,
    /// Where every point stands in the order of the leaves, by its number.
    places: Vec<u32>,
    /// The leaf of every point, in the order of the leaves.
    leaf_of: Vec<u32>,
    /// Where each leaf begins; one more entry than leaves.
    starts: Vec<u32>,
    /// The boxes of all nodes: the blocks of the lower corner, then those of the upper one.
    boxes: Vec<Block>,
    /// The smallest count and the smallest number of a point with it, below every node.
    least: Vec<(u32, u32)>,
}

impl CountedTree {
    /// The tree of points of `dimensions` numbers each, all unused. Numbers are finite.
    pub fn new(numbers: &[f32], dimensions: usize) -> Self {
        let count = numbers.len() / dimensions.max(1);
        let blocks = dimensions.div_ceil(LANES).max(1);
        let point = |item: u32| &numbers[item as usize * dimensions..][..dimensions];
        let levels = count.div_ceil(LEAF).max(1).next_power_of_two().ilog2();
        let mut items: Vec<u32> = (0..count as u32).collect();
        halve(&mut items, &point, levels);
        let mut starts = Vec::with_capacity((1 << levels) + 1);
        leaf_starts(0, count, levels, &mut starts);
        starts.push(count as u32);
        let mut tree = Self {
            blocks,
            points: items
                .iter()
                .flat_map(|&item| padded(point(item), blocks))
                .collect(),
            counts: vec![0; count],
            places: vec![0; count],
            leaf_of: vec![0; count],
            boxes: Vec::new(),
            least: Vec::new(),
            items,
            starts,
        };
        for (place, &item) in tree.items.iter().enumerate() {
            tree.places[item as usize] = place as u32;
        }
        for (leaf, ends) in tree.starts.windows(2).enumerate() {
            tree.leaf_of[ends[0] as usize..ends[1] as usize].fill(leaf as u32);
        }
        tree.make_boxes();
        tree.forget_uses();
        tree
    }

    /// Points in all.
    pub fn len(&self) -> usize {
        self.items.len()
    }

    /// Whether there is no point.
    pub fn is_empty(&self) -> bool {
        self.items.is_empty()
    }

    /// How often a point was used.
    pub fn uses(&self, item: u32) -> u32 {
        self.counts[self.places[item as usize] as usize]
    }

    /// The smallest number of uses of any point.
    pub fn smallest(&self) -> u32 {
        self.least.first().map_or(0, |least| least.0)
    }

    /// Sets all counts to 0.
    pub fn forget_uses(&mut self) {
        self.counts.fill(0);
        let inner = self.inner();
        self.least = vec![(u32::MAX, u32::MAX); 2 * inner + 1];
        for leaf in 0..=inner {
            self.least[inner + leaf] = self.least_of_leaf(leaf);
        }
        for node in (0..inner).rev() {
            self.least[node] = self.least[2 * node + 1].min(self.least[2 * node + 2]);
        }
    }

    /// Counts a use of a point.
    pub fn count_use(&mut self, item: u32) {
        let place = self.places[item as usize] as usize;
        self.counts[place] += 1;
        let leaf = self.leaf_of[place] as usize;
        let mut node = self.inner() + leaf;
        let mut least = self.least_of_leaf(leaf);
        while self.least[node] != least {
            self.least[node] = least;
            if node == 0 {
                break;
            }
            node = (node - 1) / 2;
            least = self.least[2 * node + 1].min(self.least[2 * node + 2]);
        }
    }

    /// A query that is compared with the points.
    pub fn query(&self, numbers: &[f32]) -> Query {
        let mut query = Query::default();
        self.set_query(&mut query, numbers);
        query
    }

    /// Makes a query of other numbers.
    pub fn set_query(&self, query: &mut Query, numbers: &[f32]) {
        query.0.clear();
        query.0.extend(padded(numbers, self.blocks));
    }

    /// What one point scores.
    #[inline(always)]
    pub fn compared(&self, query: &Query, item: u32, phase: u8) -> Choice {
        let place = self.places[item as usize] as usize;
        self.scored(query, place, self.smallest(), phase)
    }

    /// Keeps the best point, if it is better than what is held. A good guess at the start shortens the search and
    /// does not change what is found.
    pub fn search(&self, query: &Query, phase: u8, held: &mut Choice) {
        if !self.is_empty() {
            search_nodes(self, query, phase, held);
        }
    }

    /// Keeps the best point by looking at all of them: what [`search`](Self::search) finds, slowly.
    pub fn search_all(&self, query: &Query, phase: u8, held: &mut Choice) {
        for place in 0..self.len() {
            held.offer(self.scored(query, place, self.smallest(), phase));
        }
    }

    fn inner(&self) -> usize {
        self.starts.len() - 2
    }

    #[inline(always)]
    fn scored(&self, query: &Query, place: usize, smallest: u32, phase: u8) -> Choice {
        let count = self.counts[place];
        let point = &self.points[place * self.blocks..][..self.blocks];
        Choice {
            score: f64::from(square_distance(&query.0, point)) * penalty(count, smallest),
            count,
            item: self.items[place],
            phase,
        }
    }

    /// A lower bound of what the points below a node score. Rounding is monotone, and sums are added in the
    /// same order as in [`square_distance`], so it holds for rounded numbers too.
    #[inline(always)]
    fn bound(&self, query: &Query, node: usize, smallest: u32) -> f64 {
        let (low, high) = self.corners(node);
        let mut squares = [0.0; LANES];
        for ((own, low), high) in query.0.iter().zip(low).zip(high) {
            for lane in 0..LANES {
                let (below, above) = (low[lane] - own[lane], own[lane] - high[lane]);
                let beyond = if below > above { below } else { above };
                let beyond = if beyond > 0.0 { beyond } else { 0.0 };
                squares[lane] += beyond * beyond;
            }
        }
        f64::from(sum_of_lanes(squares)) * penalty(self.least[node].0, smallest)
    }

    #[inline(always)]
    fn is_ruled_out(&self, node: usize, bound: f64, held: &Choice) -> bool {
        // At the same score the smaller count wins, then the smaller number.
        bound > held.score || (bound == held.score && self.least[node] > (held.count, held.item))
    }

    /// The lower and upper corner of a node's box.
    #[inline(always)]
    fn corners(&self, node: usize) -> (&[Block], &[Block]) {
        self.boxes[2 * node * self.blocks..][..2 * self.blocks].split_at(self.blocks)
    }

    fn least_of_leaf(&self, leaf: usize) -> (u32, u32) {
        let places = self.starts[leaf] as usize..self.starts[leaf + 1] as usize;
        let used = places.map(|place| (self.counts[place], self.items[place]));
        used.min().unwrap_or((u32::MAX, u32::MAX))
    }

    fn make_boxes(&mut self) {
        let (inner, blocks) = (self.inner(), self.blocks);
        let nodes = 2 * inner + 1;
        self.boxes = vec![[0.0; LANES]; 2 * nodes * blocks];
        for node in 0..nodes {
            let corners = &mut self.boxes[2 * node * blocks..][..2 * blocks];
            corners[..blocks].fill([f32::INFINITY; LANES]);
            corners[blocks..].fill([f32::NEG_INFINITY; LANES]);
        }
        for node in (0..nodes).rev() {
            let (before, own) = self.boxes.split_at_mut(2 * node * blocks);
            let own = &mut own[..2 * blocks];
            if let Some(leaf) = node.checked_sub(inner) {
                let places = self.starts[leaf] as usize..self.starts[leaf + 1] as usize;
                for place in places {
                    let point = &self.points[place * blocks..][..blocks];
                    extend(own, point, point);
                }
            }
            if let Some(parent) = node.checked_sub(1).map(|above| above / 2) {
                let (low, high) = own.split_at(blocks);
                extend(&mut before[2 * parent * blocks..][..2 * blocks], low, high);
            }
        }
    }
}

/// Searches the nodes of a tree that holds a point, near ones first.
#[multiversion(targets(
    "x86_64+avx512f+avx512bw+avx512vl+avx2+fma",
    "x86_64+avx2+fma",
    "aarch64+neon"
))]
fn search_nodes(tree: &CountedTree, query: &Query, phase: u8, held: &mut Choice) {
    let (inner, smallest) = (tree.inner(), tree.smallest());
    let mut waiting = [(0usize, 0f64); MOST_WAITING];
    let mut count = 1;
    while count > 0 {
        count -= 1;
        let (node, bound) = waiting[count];
        if tree.is_ruled_out(node, bound, held) {
            continue;
        }
        if node >= inner {
            let leaf = node - inner;
            for place in tree.starts[leaf] as usize..tree.starts[leaf + 1] as usize {
                held.offer(tree.scored(query, place, smallest, phase));
            }
            continue;
        }
        let (left, right) = (2 * node + 1, 2 * node + 2);
        let left = (left, tree.bound(query, left, smallest));
        let right = (right, tree.bound(query, right, smallest));
        let (far, near) = match left.1 < right.1 {
            true => (right, left),
            false => (left, right),
        };
        (waiting[count], waiting[count + 1]) = (far, near);
        count += 2;
    }
}

/// A point in blocks.
#[derive(Clone, Debug, Default)]
pub struct Query(Vec<Block>);

/// Extends a box, lower corner first, to hold another.
fn extend(own: &mut [Block], low: &[Block], high: &[Block]) {
    let (own_low, own_high) = own.split_at_mut(low.len());
    for (own, low) in own_low.iter_mut().flatten().zip(low.iter().flatten()) {
        *own = own.min(*low);
    }
    for (own, high) in own_high.iter_mut().flatten().zip(high.iter().flatten()) {
        *own = own.max(*high);
    }
}

fn padded(numbers: &[f32], blocks: usize) -> impl Iterator<Item = Block> + '_ {
    (0..blocks).map(|block| {
        let mut lanes = [0.0; LANES];
        let held = numbers.iter().skip(block * LANES).take(LANES);
        lanes
            .iter_mut()
            .zip(held)
            .for_each(|(lane, &number)| *lane = number);
        lanes
    })
}

#[inline(always)]
fn square_distance(one: &[Block], other: &[Block]) -> f32 {
    let mut squares = [0.0; LANES];
    for (one, other) in one.iter().zip(other) {
        for lane in 0..LANES {
            let apart = one[lane] - other[lane];
            squares[lane] += apart * apart;
        }
    }
    sum_of_lanes(squares)
}

#[inline(always)]
fn sum_of_lanes(lanes: Block) -> f32 {
    let [a, b, c, d, e, f, g, h] = lanes;
    ((a + b) + (c + d)) + ((e + f) + (g + h))
}

#[cfg(test)]
mod tests;
