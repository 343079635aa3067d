//! Points of a plane that are removed one by one, asked for one that lies in a triangle.
//!
//! A kd-tree: what a query costs depends on how the points lie to each other, not on the box they
//! fill, so that outlying points and collinear runs do not slow it down.

use glam::DVec2;

/// Points in a leaf, at most.
const LEAF: usize = 8;
/// No node.
const NONE: u32 = u32::MAX;

/// The points that are left.
pub struct PointTree {
    nodes: Vec<Node>,
    /// The points in the tree's order, with their numbers.
    points: Vec<(DVec2, u32)>,
    /// By slot, whether the point is left.
    is_left: Vec<bool>,
    /// By number: slot and leaf.
    places: Vec<(u32, u32)>,
}

struct Node {
    low: DVec2,
    high: DVec2,
    parent: u32,
    /// Points that are left below.
    left: u32,
    /// The first of two children, or the first slot of a leaf.
    first: u32,
    /// Slots of a leaf; 0 for an inner node.
    slots: u32,
}

impl PointTree {
    /// All of `points` are left.
    pub fn new(points: &[DVec2]) -> Self {
        let mut tree = Self {
            nodes: Vec::with_capacity(points.len() / 2 + 1),
            points: points.iter().copied().zip(0..).collect(),
            is_left: vec![true; points.len()],
            places: vec![(0, 0); points.len()],
        };
        let root = tree.node(0, points.len(), NONE);
        tree.nodes.push(root);
        let mut open = vec![(0, 0, points.len())];
        while let Some((node, begin, end)) = open.pop() {
            if end - begin <= LEAF {
                tree.make_leaf(node, begin, end);
            } else {
                let middle = tree.halve(node, begin, end);
                let first = tree.nodes.len() as u32;
                tree.nodes[node as usize].first = first;
                for (child, begin, end) in [(first, begin, middle), (first + 1, middle, end)] {
                    let below = tree.node(begin, end, node);
                    tree.nodes.push(below);
                    open.push((child, begin, end));
                }
            }
        }
        tree
    }

    fn node(&self, begin: usize, end: usize, parent: u32) -> Node {
        let points = self.points[begin..end].iter().map(|(point, _)| *point);
        Node {
            low: points.clone().fold(DVec2::INFINITY, DVec2::min),
            high: points.fold(DVec2::NEG_INFINITY, DVec2::max),
            parent,
            left: (end - begin) as u32,
            first: NONE,
            slots: 0,
        }
    }

    fn make_leaf(&mut self, node: u32, begin: usize, end: usize) {
        self.nodes[node as usize].first = begin as u32;
        self.nodes[node as usize].slots = (end - begin) as u32;
        for slot in begin..end {
            self.places[self.points[slot].1 as usize] = (slot as u32, node);
        }
    }

    /// Sorts a node's points into halves along its longer side.
    fn halve(&mut self, node: u32, begin: usize, end: usize) -> usize {
        let size = self.nodes[node as usize].high - self.nodes[node as usize].low;
        let axis = usize::from(size.y > size.x);
        let middle = (end - begin) / 2;
        self.points[begin..end].select_nth_unstable_by(middle, |(p, i), (q, j)| {
            p[axis].total_cmp(&q[axis]).then(i.cmp(j))
        });
        begin + middle
    }

    /// Takes a point away.
    pub fn remove(&mut self, point: u32) {
        let (slot, mut node) = self.places[point as usize];
        self.is_left[slot as usize] = false;
        while node != NONE {
            self.nodes[node as usize].left -= 1;
            node = self.nodes[node as usize].parent;
        }
    }

    /// A point that is left, lies in the triangle's closed box, left of or on its three edges, and
    /// that `accept` takes. Which one of several depends on `choice`.
    pub fn find_inside(
        &self,
        triangle: [DVec2; 3],
        choice: u32,
        accept: impl Fn(DVec2, u32) -> bool,
    ) -> Option<u32> {
        let [p, q, r] = triangle;
        let (low, high) = (p.min(q).min(r), p.max(q).max(r));
        let edges = [(p, q - p), (q, r - q), (r, p - r)];
        // Different triangles look into different halves first.
        let turns = choice.wrapping_mul(0x9e37_79b9);
        let mut stack = vec![(0, 0)];
        while let Some((index, depth)) = stack.pop() {
            let node = &self.nodes[index as usize];
            let apart = node.left == 0
                || node.low.cmpgt(high).any()
                || node.high.cmplt(low).any()
                || edges.iter().any(|&edge| is_right_of(node, edge));
            if apart {
                continue;
            }
            if node.slots == 0 {
                let far = turns >> (depth & 31) & 1;
                stack.push((node.first + far, depth + 1));
                stack.push((node.first + 1 - far, depth + 1));
                continue;
            }
            for slot in node.first..node.first + node.slots {
                let (point, number) = self.points[slot as usize];
                let inside = self.is_left[slot as usize]
                    && point.cmpge(low).all()
                    && point.cmple(high).all()
                    && edges
                        .iter()
                        .all(|&(from, along)| along.perp_dot(point - from) >= 0.0);
                if inside && accept(point, number) {
                    return Some(number);
                }
            }
        }
        None
    }
}

/// Whether all of a box lies right of an edge. Rounding is monotone, so that no point of the box
/// passes the same test by itself.
fn is_right_of(node: &Node, (from, along): (DVec2, DVec2)) -> bool {
    let x = if along.y >= 0.0 {
        node.low.x
    } else {
        node.high.x
    };
    let y = if along.x >= 0.0 {
        node.high.y
    } else {
        node.low.y
    };
    along.perp_dot(DVec2::new(x, y) - from) < 0.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random;
    use rand::Rng;

    #[test]
    fn what_is_found_is_what_a_full_search_finds() {
        let mut random = random::stream(1, "point tree test", 0, 0);
        let mut point = || {
            DVec2::new(
                f64::from(random.gen_range(0..30)),
                random.gen_range(0.0..9.0),
            )
        };
        let points: Vec<DVec2> = (0..500).map(|_| point()).collect();
        let mut tree = PointTree::new(&points);
        let mut left = vec![true; points.len()];
        for round in 0..500 {
            let triangle = [point(), point(), point()];
            let inside = |number: u32| {
                let point = points[number as usize];
                (0..3).all(|k| {
                    let (from, to) = (triangle[k], triangle[(k + 1) % 3]);
                    (to - from).perp_dot(point - from) >= 0.0
                })
            };
            let found = tree.find_inside(triangle, round, |_, _| true);
            let slow = (0..500).any(|number| left[number as usize] && inside(number));
            assert_eq!(found.is_some(), slow);
            assert!(found.is_none_or(|number| left[number as usize] && inside(number)));
            tree.remove(round);
            left[round as usize] = false;
        }
    }
}
