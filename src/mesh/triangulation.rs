//! Polygons into triangles: ears are cut off in the polygon's own plane, best-shaped first.
//!
//! In: a polygon's corners in order. Out: n − 2 triangles of corner numbers. A polygon that crosses itself is cut by
//! the same rules; its triangles may then overlap.
//!
//! Small polygons are searched corner by corner. Large ones keep their convex corners in a queue, the
//! best-shaped first: a corner is looked at again only when its own triangle changed, or when the
//! corner that lay inside it was cut off. That takes about n log n steps and gives the same triangles.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use glam::{DVec2, DVec3};

use crate::error::Result;
use crate::mesh::point_tree::PointTree;
use crate::progress::Progress;

/// Polygons of up to this many corners are searched corner by corner.
const SMALL: usize = 64;
/// Ears cut from one look at whether to stop to the next.
const EARS_BETWEEN_CHECKS: usize = 1024;
/// The score of a corner that is no ear.
const NO_EAR: f64 = -1.0;

/// Cuts a polygon into triangles, each as three corner numbers in the polygon's direction.
pub fn triangulate(corners: &[DVec3], progress: Progress<'_>) -> Result<Vec<[usize; 3]>> {
    match corners.len() {
        0..=2 => Ok(Vec::new()),
        3 => Ok(vec![[0, 1, 2]]),
        4..=SMALL => {
            let points = flatten(corners);
            let mut triangles = Vec::with_capacity(corners.len() - 2);
            cut_by_search(&points, (0..points.len()).collect(), &mut triangles);
            Ok(triangles)
        }
        _ => Clipping::new(&flatten(corners)).cut(progress),
    }
}

/// The polygon seen along its area normal (Newell).
fn flatten(corners: &[DVec3]) -> Vec<DVec2> {
    let after = |k: usize| corners[(k + 1) % corners.len()];
    let newell: DVec3 = (0..corners.len())
        .map(|k| (corners[k] - corners[0]).cross(after(k) - corners[0]))
        .sum();
    let normal = newell.try_normalize().unwrap_or(DVec3::Z);
    let x = normal.any_orthonormal_vector();
    let y = normal.cross(x);
    corners
        .iter()
        .map(|&corner| DVec2::new((corner - corners[0]).dot(x), (corner - corners[0]).dot(y)))
        .collect()
}

/// Cuts what is `left` of a polygon, looking at every corner for every ear.
fn cut_by_search(points: &[DVec2], mut left: Vec<usize>, triangles: &mut Vec<[usize; 3]>) {
    while left.len() > 3 {
        let ear = best_ear(points, &left);
        triangles.push(around(&left, ear));
        left.remove(ear);
    }
    triangles.push([left[0], left[1], left[2]]);
}

fn around(left: &[usize], at: usize) -> [usize; 3] {
    let count = left.len();
    [
        left[(at + count - 1) % count],
        left[at],
        left[(at + 1) % count],
    ]
}

/// The convex corner with no other inside its triangle whose smallest angle is largest, counting
/// also the one that the cut leaves behind in a quad; without any, the first.
fn best_ear(points: &[DVec2], left: &[usize]) -> usize {
    let quality = |at: usize| {
        let [a, b, c] = around(left, at);
        let (p, q, r) = (points[a], points[b], points[c]);
        if (q - p).perp_dot(r - p) <= 0.0 {
            return NO_EAR;
        }
        let inside = |&other: &usize| {
            other != a && other != b && other != c && contains([p, q, r], points[other])
        };
        if left.iter().any(inside) {
            return NO_EAR;
        }
        let rest = match left.len() {
            4 => smallest_angle(around(left, (at + 2) % 4).map(|k| points[k])),
            _ => f64::INFINITY,
        };
        smallest_angle([p, q, r]).min(rest)
    };
    let scores: Vec<f64> = (0..left.len()).map(quality).collect();
    let mut best = 0;
    for (at, &score) in scores.iter().enumerate() {
        if score > scores[best] {
            best = at;
        }
    }
    best
}

fn contains([p, q, r]: [DVec2; 3], point: DVec2) -> bool {
    (q - p).perp_dot(point - p) >= 0.0
        && (r - q).perp_dot(point - q) >= 0.0
        && (p - r).perp_dot(point - r) >= 0.0
        && point != p
        && point != q
        && point != r
}

fn smallest_angle([p, q, r]: [DVec2; 3]) -> f64 {
    let angle = |a: DVec2, b: DVec2, c: DVec2| (b - a).perp_dot(c - a).atan2((b - a).dot(c - a));
    angle(p, q, r).min(angle(q, r, p)).min(angle(r, p, q))
}

/// A convex corner in the queue: the best-shaped is the greatest, of equal ones the smallest.
struct Candidate {
    score: f64,
    corner: u32,
    /// The corner's version when it was queued.
    version: u32,
}

impl Ord for Candidate {
    fn cmp(&self, other: &Self) -> Ordering {
        let by_score = self.score.total_cmp(&other.score);
        by_score.then(other.corner.cmp(&self.corner))
    }
}

impl PartialOrd for Candidate {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Candidate {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Candidate {}

/// What a corner is, as far as ears go.
#[derive(Clone, Copy, PartialEq)]
enum State {
    /// Convex, in the queue.
    Queued,
    /// Not convex; only a change of its triangle can make it an ear.
    Reflex,
    /// Another corner lies in its triangle.
    BlockedBy(u32),
    CutOff,
}

/// A large polygon on its way.
struct Clipping<'a> {
    points: &'a [DVec2],
    left: PointTree,
    before: Vec<u32>,
    after: Vec<u32>,
    states: Vec<State>,
    versions: Vec<u32>,
    queue: BinaryHeap<Candidate>,
    /// Per corner those that it blocks, or once blocked.
    blocks: Vec<Vec<u32>>,
    /// No corner before this one is left.
    first: u32,
}

impl<'a> Clipping<'a> {
    fn new(points: &'a [DVec2]) -> Self {
        let count = points.len() as u32;
        Self {
            points,
            left: PointTree::new(points),
            before: (0..count).map(|k| (k + count - 1) % count).collect(),
            after: (0..count).map(|k| (k + 1) % count).collect(),
            states: vec![State::Reflex; points.len()],
            versions: vec![0; points.len()],
            queue: BinaryHeap::with_capacity(points.len()),
            blocks: vec![Vec::new(); points.len()],
            first: 0,
        }
    }

    /// Cuts ears until four corners are left, and those by search.
    fn cut(mut self, progress: Progress<'_>) -> Result<Vec<[usize; 3]>> {
        let count = self.points.len();
        let mut triangles = Vec::with_capacity(count - 2);
        for corner in 0..count as u32 {
            if (corner as usize).is_multiple_of(EARS_BETWEEN_CHECKS) {
                progress.check()?;
            }
            self.look_at(corner);
        }
        while triangles.len() < count - 4 {
            if triangles.len().is_multiple_of(EARS_BETWEEN_CHECKS) {
                progress.check()?;
            }
            let ear = self.next_ear();
            triangles.push(self.triangle(ear).map(|corner| corner as usize));
            self.cut_off(ear);
        }
        let is_left = |&corner: &usize| self.states[corner] != State::CutOff;
        let left = (0..count).filter(is_left).collect();
        cut_by_search(self.points, left, &mut triangles);
        Ok(triangles)
    }

    fn triangle(&self, corner: u32) -> [u32; 3] {
        let at = corner as usize;
        [self.before[at], corner, self.after[at]]
    }

    /// The best ear; without any, the first corner left. Corners are searched for others inside their
    /// triangles only when they are next by shape: most triangles change before.
    fn next_ear(&mut self) -> u32 {
        while let Some(next) = self.queue.pop() {
            let at = next.corner as usize;
            if self.states[at] != State::Queued || self.versions[at] != next.version {
                continue;
            }
            let Some(inside) = self.inside_of(next.corner) else {
                return next.corner;
            };
            self.states[at] = State::BlockedBy(inside);
            self.blocks[inside as usize].push(next.corner);
        }
        while self.states[self.first as usize] == State::CutOff {
            self.first += 1;
        }
        self.first
    }

    /// A corner that lies inside the triangle of another.
    fn inside_of(&self, corner: u32) -> Option<u32> {
        let corners = self.triangle(corner);
        let triangle = corners.map(|k| self.points[k as usize]);
        let other = |point: DVec2, number: u32| {
            !corners.contains(&number) && triangle.iter().all(|&corner| corner != point)
        };
        self.left.find_inside(triangle, corner, other)
    }

    fn cut_off(&mut self, corner: u32) {
        let [before, _, after] = self.triangle(corner);
        self.states[corner as usize] = State::CutOff;
        self.left.remove(corner);
        self.after[before as usize] = after;
        self.before[after as usize] = before;
        self.look_at(before);
        self.look_at(after);
        for blocked in std::mem::take(&mut self.blocks[corner as usize]) {
            if self.states[blocked as usize] == State::BlockedBy(corner) {
                self.look_at(blocked);
            }
        }
    }

    /// Queues a corner if it is convex.
    fn look_at(&mut self, corner: u32) {
        let at = corner as usize;
        let [p, q, r] = self.triangle(corner).map(|k| self.points[k as usize]);
        self.versions[at] += 1;
        self.states[at] = State::Reflex;
        if (q - p).perp_dot(r - p) <= 0.0 {
            return;
        }
        let score = smallest_angle([p, q, r]);
        if score > NO_EAR {
            self.states[at] = State::Queued;
            self.queue.push(Candidate {
                score,
                corner,
                version: self.versions[at],
            });
        }
    }
}

#[cfg(test)]
mod tests;
