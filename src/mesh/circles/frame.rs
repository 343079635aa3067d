//! The axis of a vertex's circles and the plane across it: z along the normal, x along the reference
//! tangent of the vertex's [`Rings`], y = z × x. No texture direction enters.

use glam::{DVec2, DVec3, Vec3};

use crate::mesh::rings::Rings;
use crate::mesh::stencil::turn_of;
use crate::mesh::triangle_mesh::TriangleMesh;

/// Coordinates about the normal of one vertex.
#[derive(Clone, Copy, Debug)]
pub(super) struct AxisFrame {
    origin: DVec3,
    x: DVec3,
    y: DVec3,
    z: DVec3,
}

impl AxisFrame {
    pub(super) fn new(mesh: &TriangleMesh, rings: &Rings, vertex: usize) -> Self {
        let (x, z) = (
            rings.axes[vertex].as_dvec3(),
            rings.normals[vertex].as_dvec3(),
        );
        Self {
            origin: mesh.positions[vertex].as_dvec3(),
            x,
            y: z.cross(x),
            z,
        }
    }

    /// A point of space in these coordinates.
    #[inline]
    pub(super) fn place(&self, point: Vec3) -> DVec3 {
        let arm = point.as_dvec3() - self.origin;
        DVec3::new(arm.dot(self.x), arm.dot(self.y), arm.dot(self.z))
    }

    /// The angle of a direction from x, counter-clockwise about the normal, in turns from 0 up to 1.
    pub(super) fn turn_of(&self, direction: Vec3) -> f64 {
        let direction = direction.as_dvec3();
        turn_of(DVec2::new(direction.dot(self.x), direction.dot(self.y)))
    }
}
