//! The frame of a vertex: s is the orientation field, n the normal, t = n × s.

use glam::{DVec3, Vec3};

use crate::maps::vertex_map::SurfaceTextonMap;

/// A vertex's frame in double precision.
#[derive(Clone, Copy, Debug)]
pub struct Axes {
    /// s, t and n.
    axes: [DVec3; 3],
}

impl Axes {
    /// The frame of a vertex.
    #[inline(always)]
    pub fn of_vertex(map: &SurfaceTextonMap, vertex: usize) -> Self {
        Self::new(map.normals[vertex], map.orientations[vertex])
    }

    /// The frame of a normal and an orientation.
    #[inline(always)]
    pub fn new(normal: Vec3, orientation: Vec3) -> Self {
        let (n, s) = (normal.as_dvec3(), orientation.as_dvec3());
        Self {
            axes: [s, n.cross(s), n],
        }
    }

    /// The frame of the other side, where `inside` is seen.
    #[inline(always)]
    pub fn turned(mut self, inside: bool) -> Self {
        if inside {
            self.axes[2] = -self.axes[2];
        }
        self
    }

    /// A mesh-space direction in the frame, as a unit vector.
    #[inline(always)]
    pub fn local(&self, direction: DVec3) -> DVec3 {
        let [s, t, n] = self.axes;
        let local = DVec3::new(direction.dot(s), direction.dot(t), direction.dot(n));
        local * (1.0 / local.length())
    }

    /// The offset of a point from the vertex, along s and t.
    #[inline(always)]
    pub fn offset(&self, from_vertex: Vec3) -> (f64, f64) {
        let offset = from_vertex.as_dvec3();
        (offset.dot(self.axes[0]), offset.dot(self.axes[1]))
    }
}
