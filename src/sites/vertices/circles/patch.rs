//! The surface patch that the cylinders round a vertex cut (Chen 2008 §4.3): the triangles that face along the
//! vertex's normal and are connected with the vertex inside the outermost cylinder.
//!
//! Deviation: the paper intersects "the surface patch around the vertex" and says nothing of surface that
//! turns under. Triangles that face away or stand almost upright are no part of the patch here, so that
//! every circle runs once round the axis.

use glam::{DVec2, DVec3};

use super::frame::{AxisFrame, Manifold};
use crate::mesh::topology::NONE;

/// The least cosine between a triangle's normal and the axis.
const LEAST_FACING: f64 = 0.05;

/// A vertex of the patch, seen along the axis.
#[derive(Clone, Copy, Debug)]
pub(super) struct Corner {
    pub(super) vertex: u32,
    /// Across the axis (x, y) and along it (z), in mesh units.
    pub(super) place: DVec3,
    /// Its squared distance from the axis, in mesh units squared.
    pub(super) square: f64,
    /// How many circles it lies outside of.
    pub(super) band: u32,
}

/// A triangle of the patch.
#[derive(Clone, Copy, Debug)]
pub(super) struct Facet {
    pub(super) triangle: u32,
    /// Its corners, as indices into [`Patch::corners`].
    pub(super) corners: [u32; 3],
    /// How its height along the axis grows with x and with y.
    pub(super) slope: DVec2,
}

/// The end of a crossing: where a half-edge goes out of a circle or into it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Way {
    Out,
    In,
}

/// Grows patches; keeps its memory from one vertex to the next.
pub(super) struct Patch<'a> {
    surface: Manifold<'a>,
    /// Unit normals of the mesh's triangles, 0 where they have no area.
    normals: &'a [DVec3],
    /// The frame about the vertex's axis.
    frame: AxisFrame,
    /// Radius of circle 1, in mesh units.
    pub(super) radius: f64,
    /// Number of the outermost circle.
    outermost: u32,
    stamp: u32,
    /// Per vertex of the mesh its place among `corners`, where the stamp says so.
    corner_of: Vec<(u32, u32)>,
    /// Per triangle of the mesh its place among `facets`, where the stamp says so.
    facet_of: Vec<(u32, u32)>,
    pub(super) corners: Vec<Corner>,
    /// In the order in which the front reaches them.
    pub(super) facets: Vec<Facet>,
    /// Half-edges inside the outermost circle behind which the patch ends.
    pub(super) border: Vec<u32>,
}

impl<'a> Patch<'a> {
    /// No patch yet.
    pub(super) fn new(surface: Manifold<'a>, normals: &'a [DVec3]) -> Self {
        Self {
            surface,
            normals,
            frame: AxisFrame::default(),
            radius: 0.0,
            outermost: 0,
            stamp: 0,
            corner_of: vec![(0, 0); surface.mesh.positions.len()],
            facet_of: vec![(0, 0); surface.mesh.triangles.len()],
            corners: Vec::new(),
            facets: Vec::new(),
            border: Vec::new(),
        }
    }

    /// Begins the patch round a vertex, with the triangles there; `radius` is that of circle 1, in mesh units.
    pub(super) fn begin(&mut self, vertex: usize, radius: f64) {
        self.radius = radius;
        self.frame = AxisFrame::new(self.surface, vertex);
        self.corners.clear();
        self.facets.clear();
        self.stamp = self.stamp.wrapping_add(1);
        if self.stamp == 0 {
            self.corner_of.fill((0, 0));
            self.facet_of.fill((0, 0));
            self.stamp = 1;
        }
        for edge in self.surface.rings.edges.row(vertex) {
            if edge.triangle != NONE {
                self.accept(edge.triangle);
            }
        }
    }

    /// Grows the patch to what is connected inside circle `outermost`; a larger one may follow.
    pub(super) fn grow(&mut self, outermost: u32) {
        self.outermost = outermost;
        self.border.clear();
        let mut next = 0;
        while next < self.facets.len() {
            let triangle = self.facets[next].triangle;
            for half_edge in 3 * triangle..3 * triangle + 3 {
                if self.reaches_inside(half_edge, next) {
                    self.pass(half_edge);
                }
            }
            next += 1;
        }
    }

    /// Moves the front over a half-edge, or notes that the patch ends there.
    fn pass(&mut self, half_edge: u32) {
        let twin = self.surface.topology.opposite[half_edge as usize];
        if twin == NONE || !self.accept(twin / 3) {
            self.border.push(half_edge);
        }
    }

    /// Whether a triangle belongs to the patch; takes it in when it is new.
    fn accept(&mut self, triangle: u32) -> bool {
        if self.facet_of[triangle as usize].0 == self.stamp {
            return true;
        }
        let normal = self.frame.turned(self.normals[triangle as usize]);
        if normal.z < LEAST_FACING {
            return false;
        }
        let ids = self.surface.mesh.triangles[triangle as usize];
        let corners = ids.map(|vertex| self.corner(vertex));
        self.facet_of[triangle as usize] = (self.stamp, self.facets.len() as u32);
        self.facets.push(Facet {
            triangle,
            corners,
            slope: -normal.truncate() / normal.z,
        });
        true
    }

    /// The place of a vertex among the corners, given out when it is first met.
    fn corner(&mut self, vertex: u32) -> u32 {
        let entry = &mut self.corner_of[vertex as usize];
        if entry.0 != self.stamp {
            *entry = (self.stamp, self.corners.len() as u32);
            let place = self
                .frame
                .place(self.surface.mesh.positions[vertex as usize]);
            let square = place.truncate().length_squared();
            let band = (square / (self.radius * self.radius)).sqrt() as u32;
            self.corners.push(Corner {
                vertex,
                place,
                square,
                band,
            });
        }
        entry.1
    }

    /// Whether part of a half-edge lies inside the outermost circle.
    fn reaches_inside(&self, half_edge: u32, facet: usize) -> bool {
        let [from, to] = self.ends(half_edge, &self.facets[facet]);
        let outermost = self.outermost;
        from.band < outermost || to.band < outermost || self.dips(from, to, outermost)
    }

    /// The radius of a circle, in mesh units.
    pub(super) fn radius_of(&self, circle: u32) -> f64 {
        f64::from(circle) * self.radius
    }

    /// The facet of a half-edge's triangle, if it belongs to the patch.
    pub(super) fn facet_at(&self, half_edge: u32) -> Option<&Facet> {
        let (stamp, facet) = self.facet_of[half_edge as usize / 3];
        (stamp == self.stamp).then(|| &self.facets[facet as usize])
    }

    /// The half-edge on the other side, if it belongs to the patch.
    pub(super) fn twin(&self, half_edge: u32) -> Option<u32> {
        let twin = self.surface.topology.opposite[half_edge as usize];
        (twin != NONE && self.facet_at(twin).is_some()).then_some(twin)
    }

    /// Whether a half-edge crosses circle `circle` (1 is the innermost) in this direction.
    pub(super) fn crosses(&self, half_edge: u32, facet: &Facet, circle: u32, way: Way) -> bool {
        let [from, to] = self.ends(half_edge, facet);
        match (from.band < circle, to.band < circle) {
            (true, false) => way == Way::Out,
            (false, true) => way == Way::In,
            (true, true) => false,
            (false, false) => self.dips(from, to, circle),
        }
    }

    /// Where a half-edge crosses a circle in this direction.
    pub(super) fn crossing(&self, half_edge: u32, facet: &Facet, circle: u32, way: Way) -> DVec2 {
        let [from, to] = self.ends(half_edge, facet).map(|end| end.place.truncate());
        let radius = self.radius_of(circle);
        let along = to - from;
        let (square, middle) = (along.length_squared(), -from.dot(along));
        let half = (middle * middle - square * (from.length_squared() - radius * radius))
            .max(0.0)
            .sqrt();
        let root = match way {
            Way::Out => middle + half,
            Way::In => middle - half,
        };
        let share = if square > 0.0 { root / square } else { 0.0 };
        from + along * share.clamp(0.0, 1.0)
    }

    /// Whether an edge between two points outside a circle enters it. Both half-edges give the same answer,
    /// to the last bit: the ends are taken in the order of their vertices.
    fn dips(&self, from: &Corner, to: &Corner, circle: u32) -> bool {
        let radius = self.radius_of(circle);
        let [a, b] = if from.vertex < to.vertex {
            [from, to]
        } else {
            [to, from]
        };
        let (a, b) = (a.place.truncate(), b.place.truncate());
        let along = b - a;
        let (square, middle) = (along.length_squared(), -a.dot(along));
        if middle <= 0.0 || middle >= square {
            return false;
        }
        a.perp_dot(along).powi(2) < radius * radius * square
    }

    #[inline]
    fn ends(&self, half_edge: u32, facet: &Facet) -> [&Corner; 2] {
        let first = half_edge as usize % 3;
        [first, (first + 1) % 3].map(|k| &self.corners[facet.corners[k] as usize])
    }
}
