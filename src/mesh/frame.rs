//! The local texture frame of a vertex (Tong 2002 §5.1): s along the orientation field, n the
//! normal, t = n × s.

use glam::Vec3;

/// Three orthonormal, right-handed vectors in mesh space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// "Right": the orientation field.
    pub s: Vec3,
    /// "Up": n × s.
    pub t: Vec3,
    /// The surface normal.
    pub n: Vec3,
}

impl Frame {
    /// The frame of a normal and a wanted s: s is projected on the tangent plane; `None` when it
    /// stands on it.
    pub fn new(normal: Vec3, s: Vec3) -> Option<Self> {
        let n = normal.try_normalize()?;
        let s = (s - n * n.dot(s)).try_normalize()?;
        Some(Self {
            s,
            t: n.cross(s),
            n,
        })
    }

    /// A mesh-space vector in the frame's coordinates (s, t, n).
    pub fn frame_from_mesh(&self, v: Vec3) -> Vec3 {
        Vec3::new(v.dot(self.s), v.dot(self.t), v.dot(self.n))
    }
}
