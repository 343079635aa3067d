//! What retiling must not smooth away: boundaries, creases sharper than an angle, and the points
//! where they end, meet or turn.

use glam::Vec3;

use crate::mesh::retile::surgery::Freedom;
use crate::mesh::surface_tree::SurfaceTree;
use crate::mesh::topology::{NONE, Topology, ends};
use crate::mesh::triangle_mesh::TriangleMesh;

/// The lines of a surface, and what they ask of its vertices.
pub struct Features {
    /// Half-edges on a boundary or crease.
    pub sharp: Vec<bool>,
    /// Per vertex its freedom.
    pub freedom: Vec<Freedom>,
    /// The lines as segments, for [`nearest`](Self::nearest).
    segments: Option<SurfaceTree>,
}

impl Features {
    /// Finds boundaries, edges whose triangles turn by more than `crease` radians, and corners:
    /// vertices where a line ends, meets another, or itself turns by more than `crease`.
    pub fn find(mesh: &TriangleMesh, crease: f64) -> Self {
        let topology = Topology::new(&mesh.triangles);
        let sharp = sharp_half_edges(mesh, &topology, crease);
        let mut arms: Vec<Vec<Vec3>> = vec![Vec::new(); mesh.positions.len()];
        let mut segments = Vec::new();
        for (half_edge, _) in sharp.iter().enumerate().filter(|&(_, &sharp)| sharp) {
            let twin = topology.opposite[half_edge];
            if twin == NONE || (half_edge as u32) < twin {
                let [a, b] = ends(&mesh.triangles, half_edge as u32);
                let [p, q] = [a, b].map(|v| mesh.positions[v as usize]);
                arms[a as usize].push(q - p);
                arms[b as usize].push(p - q);
                segments.push([p, q, q]);
            }
        }
        let freedom = arms.iter().map(|arms| freedom(arms, crease)).collect();
        Self {
            sharp,
            freedom,
            segments: (!segments.is_empty()).then(|| SurfaceTree::of_corners(&segments)),
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

fn freedom(arms: &[Vec3], crease: f64) -> Freedom {
    match arms {
        [] => Freedom::Surface,
        [one, other] => {
            let straight = -one.normalize_or_zero().dot(other.normalize_or_zero());
            if f64::from(straight) > crease.cos() {
                Freedom::Line
            } else {
                Freedom::Fixed
            }
        }
        _ => Freedom::Fixed,
    }
}
