//! The surface that is marched on, and the axis of a vertex's circles with the plane across it: z along the
//! normal, x along the reference tangent of the vertex's [`Rings`], y = z × x. No texture direction enters.

use glam::{DVec2, DVec3, Vec3};

use crate::mesh::rings::Rings;
use crate::mesh::topology::Topology;
use crate::mesh::triangle_mesh::TriangleMesh;
use crate::neighborhood::turn_of;

/// A manifold mesh, ready to be marched on.
#[derive(Clone, Copy, Debug)]
pub struct Manifold<'a> {
    /// Positions and triangles.
    pub mesh: &'a TriangleMesh,
    /// Neighbours across every edge.
    pub topology: &'a Topology,
    /// Normals and reference tangents.
    pub rings: &'a Rings,
}

/// Coordinates about the normal of one vertex.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct AxisFrame {
    origin: DVec3,
    x: DVec3,
    y: DVec3,
    z: DVec3,
}

impl AxisFrame {
    pub(super) fn new(surface: Manifold<'_>, vertex: usize) -> Self {
        let (x, z) = (
            surface.rings.axes[vertex].as_dvec3(),
            surface.rings.normals[vertex].as_dvec3(),
        );
        Self {
            origin: surface.mesh.positions[vertex].as_dvec3(),
            x,
            y: z.cross(x),
            z,
        }
    }

    /// A point of space in these coordinates.
    #[inline]
    pub(super) fn place(&self, point: Vec3) -> DVec3 {
        self.turned(point.as_dvec3() - self.origin)
    }

    /// A direction of space in these coordinates.
    #[inline]
    pub(super) fn turned(&self, direction: DVec3) -> DVec3 {
        let [x, y, z] = [self.x, self.y, self.z].map(|axis| direction.dot(axis));
        DVec3::new(x, y, z)
    }

    /// The angle of a direction from x, counter-clockwise about the normal, in turns from 0 up to 1.
    pub(super) fn turn_of(&self, direction: Vec3) -> f64 {
        let direction = direction.as_dvec3();
        turn_of(DVec2::new(direction.dot(self.x), direction.dot(self.y)))
    }
}
