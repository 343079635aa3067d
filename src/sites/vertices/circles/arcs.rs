//! Circles round vertices, as they are stored: each a partition of the full turn in arcs, 8 bytes per arc.
//!
//! Nothing here depends on the texture direction: angles and arc lengths count from the reference tangent of
//! the vertex.

use crate::mesh::compressed_rows::Rows;

/// Steps of an angle or arc length in a full turn.
const STEPS: f32 = 65536.0;
/// Steps of a distance from the axis, from 0 to the outermost circle.
const RADIUS_STEPS: f32 = 65535.0;

/// Where an arc of a circle begins; it ends where the next one begins, the last after a full turn.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Arc {
    /// The triangle that it lies in, or [`Arc::GAP`].
    pub triangle: u32,
    /// Its angle about the axis from the reference tangent, in 1/65536 turns, counter-clockwise.
    pub turn: u16,
    /// The arc length up to it, in 1/65536 of the circle's.
    pub fraction: u16,
}

impl Arc {
    /// `triangle` of a stretch where the patch has no surface.
    pub const GAP: u32 = u32::MAX;
}

/// A vertex inside the outermost circle of another.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct NearVertex {
    /// The vertex.
    pub vertex: u32,
    /// Its distance from the axis, in 1/65535 of the outermost radius.
    pub radius: u16,
    /// Its share of the arc length round the axis, from the reference tangent, in 1/65536 turns.
    pub turn: u16,
}

impl NearVertex {
    /// Packs a distance (as a share of the outermost radius) and a turn.
    pub(super) fn new(vertex: u32, share: f32, turn: f32) -> Self {
        Self {
            vertex,
            radius: (share * RADIUS_STEPS + 0.5).min(RADIUS_STEPS) as u16,
            turn: (turn * STEPS + 0.5).min(STEPS - 1.0) as u16,
        }
    }

    /// Its distance from the axis as a share of the outermost radius.
    pub fn share(&self) -> f32 {
        f32::from(self.radius) / RADIUS_STEPS
    }

    /// Its share of the arc length round the axis, in turns.
    pub fn turn(&self) -> f32 {
        f32::from(self.turn) / STEPS
    }
}

/// The circles of every vertex, and the vertices inside them.
#[derive(Clone, Debug, PartialEq)]
pub struct Circles {
    /// Circles per vertex; circle m, counted from 1, has m times the vertex's first radius.
    pub per_vertex: u32,
    /// Per vertex the radius of its first circle, in mesh units.
    pub radii: Vec<f32>,
    /// Per vertex and circle the arcs, in order of their angle.
    pub arcs: Rows<Arc>,
    /// Per vertex and circle its length in mesh units; gaps count as in the plane.
    pub perimeters: Vec<f32>,
    /// Per vertex the others inside its outermost circle, nearest to the axis first.
    pub near: Rows<NearVertex>,
}

impl Circles {
    /// Circle `number` of a vertex, counted from 1.
    pub fn circle(&self, vertex: usize, number: u32) -> Circle<'_> {
        let row = vertex * self.per_vertex as usize + number as usize - 1;
        Circle {
            arcs: self.arcs.row(row),
        }
    }

    /// The share of the arc length at a turn, at a distance from the axis given in first radii: interpolated
    /// between the two circles about it, and that of the first circle inside it.
    pub(super) fn fraction_between(&self, vertex: usize, distance: f32, turn: f32) -> f32 {
        let row = vertex * self.per_vertex as usize;
        let circles = |m: u32| self.arcs.row(row + m as usize - 1);
        fraction_between(circles, self.per_vertex, distance, turn)
    }
}

/// One circle.
#[derive(Clone, Copy, Debug)]
pub struct Circle<'a> {
    /// Its arcs, in order of their angle; never empty.
    pub arcs: &'a [Arc],
}

impl Circle<'_> {
    /// Whether parts of the circle have no surface.
    pub fn is_open(&self) -> bool {
        self.arcs.iter().any(|arc| arc.triangle == Arc::GAP)
    }

    /// The share of the arc length (Chen 2008 Eq. 1) at a turn, both from the reference tangent.
    pub fn fraction_at(&self, turn: f32) -> f32 {
        let steps = turn * STEPS;
        let at = self
            .arcs
            .partition_point(|arc| f32::from(arc.turn) <= steps);
        let (begin, end) = self.ends(at.max(1) - 1);
        let share = (steps - begin.0) / (end.0 - begin.0);
        (begin.1 + share * (end.1 - begin.1)) / STEPS
    }

    /// The triangle (or [`Arc::GAP`]) and the turn at a share of the arc length, from 0 up to 1.
    pub fn point_at(&self, fraction: f32) -> (u32, f32) {
        let steps = fraction * STEPS;
        let at = self
            .arcs
            .partition_point(|arc| f32::from(arc.fraction) <= steps);
        let index = at.max(1) - 1;
        let (begin, end) = self.ends(index);
        let share = (steps - begin.1) / (end.1 - begin.1);
        let turn = (begin.0 + share * (end.0 - begin.0)) / STEPS;
        (self.arcs[index].triangle, turn)
    }

    /// Turn and arc length where an arc begins and ends, in steps.
    fn ends(&self, index: usize) -> ((f32, f32), (f32, f32)) {
        let of = |arc: &Arc| (f32::from(arc.turn), f32::from(arc.fraction));
        let end = self.arcs.get(index + 1).map_or((STEPS, STEPS), of);
        (of(&self.arcs[index]), end)
    }
}

/// [`Circles::fraction_between`] for circles that are still being marched.
pub(super) fn fraction_between<'a>(
    arcs: impl Fn(u32) -> &'a [Arc],
    per_vertex: u32,
    distance: f32,
    turn: f32,
) -> f32 {
    let at = |number: u32| Circle { arcs: arcs(number) }.fraction_at(turn);
    let inner = (distance.max(1.0) as u32).min(per_vertex);
    let share = (distance - inner as f32).clamp(0.0, 1.0);
    if share == 0.0 || inner == per_vertex {
        return at(inner);
    }
    let (below, above) = (at(inner), at(inner + 1));
    below + share * (above - below)
}
