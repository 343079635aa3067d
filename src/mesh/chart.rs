//! The (s, t) chart of the surface round a point: the discrete exponential map (Schmidt 2006 §3).
//!
//! A front grows from the point in order of distance. A vertex is placed, from each neighbour already placed, at the
//! neighbour's position plus the edge between them, rotated by the rotation accumulated on the way; the placements
//! that agree are averaged, weighted by inverse edge length (the upwind average of Schmidt 2013 §3.1). Where the front
//! meets itself behind a narrow part, placements disagree and the nearer one is kept. In: a connection, seeds with
//! known positions. Out: the placed vertices, nearest first. Folds are found by the sampler
//! ([`sampling`](crate::sites::vertices::sampling)).

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use glam::Vec2;

use crate::mesh::connection::Connection;

/// Placements of a vertex farther apart than this multiple of the edge do not agree.
const DISAGREEMENT: f32 = 0.5;

/// A vertex of a chart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placed {
    /// The vertex.
    pub vertex: u32,
    /// Where it lies, in mesh units along the centre's s and t.
    pub position: Vec2,
    /// Unit; turns a vector in the vertex's frame into one in the centre's.
    pub rotation: Vec2,
}

/// A vertex the front has reached and not yet passed.
#[derive(Clone, Copy, Debug, Default)]
struct Tentative {
    vertex: u32,
    placed: bool,
    weight: f32,
    position_sum: Vec2,
    rotation_sum: Vec2,
}

impl Tentative {
    #[inline]
    fn position(&self) -> Vec2 {
        self.position_sum / self.weight
    }

    /// Takes one more placement into account; `weight` is one over the edge's length.
    #[inline]
    fn hear(&mut self, position: Vec2, rotation: Vec2, weight: f32) {
        let apart = self.position_sum - self.weight * position;
        if self.weight > 0.0 && apart.length() * weight > DISAGREEMENT * self.weight {
            if position.length_squared() >= self.position().length_squared() {
                return;
            }
            (self.weight, self.position_sum, self.rotation_sum) = (0.0, Vec2::ZERO, Vec2::ZERO);
        }
        self.weight += weight;
        self.position_sum += weight * position;
        self.rotation_sum += weight * rotation;
    }
}

/// Grows charts; keeps its memory from one to the next.
pub struct ChartGrower {
    /// Per vertex of the mesh its place among `reached` in this chart, where `stamp` says so.
    place: Vec<(u32, u32)>,
    stamp: u32,
    reached: Vec<Tentative>,
    front: BinaryHeap<Reverse<(u32, u32)>>,
    placed: Vec<Placed>,
}

impl ChartGrower {
    /// For a mesh of this many vertices.
    pub fn new(vertices: usize) -> Self {
        Self {
            place: vec![(0, 0); vertices],
            stamp: 0,
            reached: Vec::new(),
            front: BinaryHeap::new(),
            placed: Vec::new(),
        }
    }

    /// The chart round a vertex, to a radius in mesh units.
    pub fn round_vertex(&mut self, connection: &Connection, vertex: u32, radius: f32) -> &[Placed] {
        let seed = Placed {
            vertex,
            position: Vec2::ZERO,
            rotation: Vec2::X,
        };
        self.grow(connection, &[seed], radius)
    }

    /// The chart round a point whose surroundings are known: `seeds` stand where they say.
    ///
    /// Every vertex no farther than `radius` from the point is placed, and so are the neighbours of
    /// those; nearest first, ties by index.
    pub fn grow(&mut self, connection: &Connection, seeds: &[Placed], radius: f32) -> &[Placed] {
        // Place the seeds.
        self.clear();
        for seed in seeds {
            let local = self.reach(seed.vertex);
            let tentative = &mut self.reached[local as usize];
            tentative.weight = 1.0;
            tentative.position_sum = seed.position;
            tentative.rotation_sum = seed.rotation;
            tentative.placed = true;
            self.placed.push(*seed);
        }
        // Spread from them, the nearest vertex first.
        for index in 0..seeds.len() {
            self.pass(connection, self.placed[index]);
        }
        while let Some(Reverse((_, local))) = self.front.pop() {
            let tentative = &mut self.reached[local as usize];
            if tentative.placed {
                continue;
            }
            tentative.placed = true;
            let placed = Placed {
                vertex: tentative.vertex,
                position: tentative.position(),
                rotation: tentative.rotation_sum.normalize_or(Vec2::X),
            };
            self.placed.push(placed);
            if placed.position.length() <= radius {
                self.pass(connection, placed);
            }
        }
        // Sort by distance.
        let key = |p: &Placed| (p.position.length_squared(), p.vertex);
        self.placed.sort_unstable_by(|a, b| {
            key(a)
                .partial_cmp(&key(b))
                .unwrap_or(std::cmp::Ordering::Equal)
        });
        &self.placed
    }

    /// Where a vertex stands in the chart grown last, `None` when it was not placed.
    #[inline]
    pub fn position_of(&self, vertex: u32) -> Option<Vec2> {
        let (stamp, local) = self.place[vertex as usize];
        let tentative = (stamp == self.stamp).then(|| self.reached[local as usize])?;
        tentative.placed.then(|| tentative.position())
    }

    fn clear(&mut self) {
        self.reached.clear();
        self.front.clear();
        self.placed.clear();
        self.stamp = self.stamp.wrapping_add(1);
        if self.stamp == 0 {
            self.place.fill((0, 0));
            self.stamp = 1;
        }
    }

    /// The local number of a vertex, given out when it is first met.
    #[inline]
    fn reach(&mut self, vertex: u32) -> u32 {
        let entry = &mut self.place[vertex as usize];
        if entry.0 != self.stamp {
            *entry = (self.stamp, self.reached.len() as u32);
            self.reached.push(Tentative {
                vertex,
                ..Tentative::default()
            });
        }
        entry.1
    }

    /// Moves the front over a placed vertex: it proposes a position to each of its neighbours.
    #[inline]
    fn pass(&mut self, connection: &Connection, from: Placed) {
        for spoke in connection.spokes.row(from.vertex as usize) {
            let local = self.reach(spoke.target);
            let tentative = &mut self.reached[local as usize];
            if tentative.placed {
                continue;
            }
            let weight = spoke.edge.length_recip();
            if !weight.is_finite() {
                continue;
            }
            let position = from.position + from.rotation.rotate(spoke.edge);
            let rotation = from.rotation.rotate(spoke.rotation);
            tentative.hear(position, rotation, weight);
            let distance = tentative.position().length();
            self.front.push(Reverse((distance.to_bits(), local)));
        }
    }
}
