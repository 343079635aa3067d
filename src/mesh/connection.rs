//! Parallel transport on the surface: every edge as a vector in the frame of its vertex, and the rotation from the
//! far frame's coordinates to the near one's.
//!
//! Complex numbers stand as `Vec2`; (1, 0) is the vertex's s axis, (0, 1) its t axis.

use glam::{DVec2, Vec2, Vec3};
use rayon::prelude::*;

use crate::mesh::compressed_rows::Rows;
use crate::mesh::frame::Frame;
use crate::mesh::rings::Rings;

/// One edge in the frame of the vertex it starts at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spoke {
    /// The vertex it leads to.
    pub target: u32,
    /// The triangle on its left, [`NONE`](crate::mesh::topology::NONE) past the last one.
    pub triangle: u32,
    /// The edge, in mesh units along s and t.
    pub edge: Vec2,
    /// Unit; multiplied with it, a vector in the target's frame becomes one in this frame.
    pub rotation: Vec2,
}

/// A frame at every vertex and the edges between them.
#[derive(Clone, Debug, PartialEq)]
pub struct Connection {
    /// Per vertex its edges, counter-clockwise.
    pub spokes: Rows<Spoke>,
    /// Per vertex its texture frame.
    pub frames: Vec<Frame>,
}

impl Connection {
    /// The connection between frames whose s axes stand at `angles` (radians from each ring's
    /// axis, counter-clockwise).
    pub fn new(rings: &Rings, angles: &[f64]) -> Self {
        let spokes = (0..rings.edges.len())
            .into_par_iter()
            .flat_map_iter(|vertex| {
                rings.edges.range(vertex).map(move |entry| {
                    let edge = rings.edges.entries[entry];
                    let turn =
                        rings.transport(entry) - angles[vertex] + angles[edge.target as usize];
                    let arm =
                        DVec2::from_angle(edge.angle - angles[vertex]) * f64::from(edge.length);
                    Spoke {
                        target: edge.target,
                        triangle: edge.triangle,
                        edge: arm.as_vec2(),
                        rotation: DVec2::from_angle(turn).as_vec2(),
                    }
                })
            })
            .collect();
        Self {
            spokes: Rows {
                starts: rings.edges.starts.clone(),
                entries: spokes,
            },
            frames: frames_of(rings, angles),
        }
    }
}

/// The frames whose s axes stand at `angles` (radians from each ring's axis, counter-clockwise).
pub fn frames_of(rings: &Rings, angles: &[f64]) -> Vec<Frame> {
    let frame = |vertex: usize| {
        let n = rings.normals[vertex];
        let s = if rings.edges.row(vertex).is_empty() {
            Vec3::X
        } else {
            rings.direction(vertex, angles[vertex])
        };
        Frame {
            s,
            t: n.cross(s),
            n,
        }
    };
    (0..angles.len()).into_par_iter().map(frame).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;
    use crate::mesh::topology::Topology;

    #[test]
    fn frames_of_a_plane_agree_once_their_angles_do() {
        let mesh = shapes::grid(5, 5, 1.0);
        let rings = Rings::new(&mesh, &Topology::new(&mesh.triangles));
        let along_x: Vec<f64> = (0..36)
            .map(|v| rings.angle_of(v, Vec3::X).unwrap())
            .collect();
        let connection = Connection::new(&rings, &along_x);
        for vertex in 0..36 {
            assert!((connection.frames[vertex].s - Vec3::X).length() < 1e-6);
            assert!((connection.frames[vertex].t - Vec3::Y).length() < 1e-6);
            for spoke in connection.spokes.row(vertex) {
                let arm = mesh.positions[spoke.target as usize] - mesh.positions[vertex];
                assert!((spoke.edge - arm.truncate()).length() < 1e-5);
                assert!((spoke.rotation - Vec2::X).length() < 1e-5);
            }
        }
    }
}
