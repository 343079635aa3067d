//! Vertices as a user names them: by their place in the mesh file, or by a point near them.

use glam::DVec3;

use crate::error::{Error, Result};
use crate::mesh::reading::UserMesh;
use crate::mesh::rings::Rings;
use crate::mesh::surface_bvh::SurfaceBvh;

/// A user's mesh, ready to be asked for vertices.
#[derive(Clone, Copy)]
pub struct UserVertices<'a> {
    /// The mesh and the way back to its file.
    pub user: &'a UserMesh,
    /// Its rings.
    pub rings: &'a Rings,
    /// Its triangles, for points.
    pub tree: &'a SurfaceBvh,
}

impl UserVertices<'_> {
    /// The vertex that a file says by its number or by a point, of which it must give one. `place` says where.
    pub fn at(&self, vertex: Option<u64>, point: Option<[f64; 3]>, place: &str) -> Result<usize> {
        match (vertex, point) {
            (Some(vertex), None) => self.numbered(vertex, place),
            (None, Some(point)) if point.iter().all(|c| c.is_finite()) => {
                self.nearest(point, place)
            }
            _ => Err(Error::data(place, "neither one vertex nor one point")
                .expected("\"vertex\" or \"point\"")),
        }
    }

    /// Whether a vertex is part of a face.
    pub fn is_used(&self, vertex: usize) -> bool {
        !self.rings.edges.row(vertex).is_empty()
    }

    fn numbered(&self, vertex: u64, place: &str) -> Result<usize> {
        let map = &self.user.from_file;
        match usize::try_from(vertex).ok().and_then(|v| map.get(v)) {
            Some(&ours) if self.is_used(ours as usize) => Ok(ours as usize),
            Some(_) => Err(Error::data(place, format!("vertex {vertex} is in no face"))
                .expected("a vertex of the surface")),
            None => Err(Error::data(place, format!("vertex {vertex}"))
                .expected(format!("below {} vertices", map.len()))),
        }
    }

    /// The corner nearest to a point of the triangle nearest to it.
    fn nearest(&self, point: [f64; 3], place: &str) -> Result<usize> {
        let local = (DVec3::from_array(point) - self.user.origin).as_vec3();
        let Some(nearest) = self.tree.nearest(local) else {
            return Err(Error::data(place, "a point").expected("a mesh with triangles"));
        };
        let corners = self.user.mesh.triangles[nearest.triangle as usize];
        let largest = |best, k| match nearest.weights[k] > nearest.weights[best] {
            true => k,
            false => best,
        };
        Ok(corners[(0..3).fold(0, largest)] as usize)
    }
}
