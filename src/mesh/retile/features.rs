//! What retiling must not smooth away: boundaries, creases sharper than an angle, and the points
//! where they end, meet or turn.
//!
//! Features depend on scale. On a coarse level of a pyramid a crease shorter than a few edges is ignored, and a jagged
//! border counts as straight if it is straight over the length of an edge.

use glam::Vec3;

use crate::mesh::retile::edge_operations::Freedom;
use crate::mesh::retile::lines::Lines;
use crate::mesh::surface_bvh::SurfaceBvh;
use crate::mesh::topology::{NONE, Topology};
use crate::mesh::triangle_mesh::TriangleMesh;

/// A crease shorter than so many edges is no line of its own.
const SHORTEST: f32 = 4.0;

/// The lines of a surface, and what they ask of its vertices.
pub struct SharpFeatures {
    /// Half-edges on a boundary or crease.
    pub sharp: Vec<bool>,
    /// Per vertex its freedom.
    pub freedom: Vec<Freedom>,
    /// The lines as segments, for [`nearest`](Self::nearest).
    segments: Option<SurfaceBvh>,
}

impl SharpFeatures {
    /// Finds boundaries, edges whose triangles turn by more than `crease` radians, and corners:
    /// vertices where a line ends, meets another, or itself turns by more than `crease`. Half-edges that
    /// `lines` names (none, if empty) are lines as well.
    pub fn find(mesh: &TriangleMesh, crease: f64, lines: &[bool]) -> Self {
        let topology = Topology::new(&mesh.triangles);
        let mut sharp = sharp_half_edges(mesh, &topology, crease);
        for (sharp, &line) in sharp.iter_mut().zip(lines) {
            *sharp |= line;
        }
        Self::of_lines(mesh, &topology, sharp, crease, 0.0)
    }

    /// The same at the scale of edges of length `edge`, among the half-edges that are `known` to
    /// be sharp.
    pub fn at_scale(
        mesh: &TriangleMesh,
        known: impl Fn(usize) -> bool,
        crease: f64,
        edge: f32,
    ) -> Self {
        let topology = Topology::new(&mesh.triangles);
        let mut sharp = sharp_half_edges(mesh, &topology, crease);
        for (half_edge, sharp) in sharp.iter_mut().enumerate() {
            *sharp &= topology.opposite[half_edge] == NONE || known(half_edge);
        }
        Self::of_lines(mesh, &topology, sharp, crease, edge)
    }

    fn of_lines(
        mesh: &TriangleMesh,
        topology: &Topology,
        mut sharp: Vec<bool>,
        crease: f64,
        edge: f32,
    ) -> Self {
        Lines::new(mesh, topology, &sharp).drop_short(topology, &mut sharp, SHORTEST * edge);
        let lines = Lines::new(mesh, topology, &sharp);
        let segments = lines.segments();
        Self {
            freedom: lines.freedom(crease, edge),
            segments: (!segments.is_empty()).then(|| SurfaceBvh::of_corners(&segments)),
            sharp,
        }
    }

    /// The nearest point of the lines.
    pub fn nearest(&self, point: Vec3) -> Option<Vec3> {
        let found = self.segments.as_ref()?.nearest(point)?;
        Some(found.position)
    }
}

fn sharp_half_edges(mesh: &TriangleMesh, topology: &Topology, crease: f64) -> Vec<bool> {
    let least = crease.cos() as f32;
    let normals: Vec<Vec3> = (0..mesh.triangles.len())
        .map(|t| mesh.area_normal_f64(t).normalize_or_zero().as_vec3())
        .collect();
    let sharp = |(half_edge, &twin): (usize, &u32)| {
        twin == NONE || normals[half_edge / 3].dot(normals[twin as usize / 3]) < least
    };
    topology.opposite.iter().enumerate().map(sharp).collect()
}
