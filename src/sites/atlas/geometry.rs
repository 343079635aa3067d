//! The mesh under an atlas: orientation field and edges at its vertices, scale, and the way over it. The same
//! for all levels.

use crate::error::Result;
use crate::mesh::atlas::Atlas;
use crate::mesh::connection::Connection;
use crate::mesh::field::guides::{GuideOptions, GuidedSurface};
use crate::mesh::frame::Frame;
use crate::mesh::reading::{UserMesh, varying};
use crate::mesh::rings::Rings;
use crate::mesh::surface_bvh::{SurfaceBvh, SurfacePoint};
use crate::mesh::topology::Topology;
use crate::mesh::triangle_mesh::TriangleMesh;
use crate::progress::Progress;
use crate::sites::vertices::surface::guided_angles;

/// A mesh and its charts, ready to be sampled.
pub struct Geometry<'a> {
    /// Positions and triangles.
    pub mesh: &'a TriangleMesh,
    /// Texture coordinates.
    pub atlas: &'a Atlas,
    /// Neighbours across every edge.
    pub topology: Topology,
    /// Normals, and edges round every vertex.
    pub rings: Rings,
    /// Texture frames of the vertices, the user's rotation included.
    pub connection: Connection,
    /// Factor on the texel at each vertex; `None` for 1 everywhere.
    pub scale: Option<&'a [f32]>,
}

impl<'a> Geometry<'a> {
    /// Makes the orientation field of a mesh; `texel` is the texture's, in mesh units.
    pub fn new(
        user: &'a UserMesh,
        atlas: &'a Atlas,
        texel: f64,
        (guides, seed): (&GuideOptions, u64),
        progress: Progress<'_>,
    ) -> Result<Self> {
        progress.begin("orientation field", 1);
        let topology = Topology::new(&user.mesh.triangles);
        let rings = Rings::new(&user.mesh, &topology);
        let tree = SurfaceBvh::new(&user.mesh);
        let surface = GuidedSurface {
            user,
            rings: &rings,
            tree: &tree,
            texel,
        };
        let angles = guided_angles(surface, guides, seed, progress)?;
        let connection = Connection::new(&rings, &angles);
        progress.advance(1)?;
        progress.end();
        Ok(Self {
            mesh: &user.mesh,
            atlas,
            topology,
            rings,
            connection,
            scale: varying(user.scale.as_deref()),
        })
    }

    /// The texture frame at a surface point: those of the corners, blended. Where they cancel out, at a
    /// singularity of the field, that of the nearest corner.
    pub fn frame(&self, point: &SurfacePoint) -> Frame {
        let corners = self.mesh.triangles[point.triangle as usize];
        let frames = corners.map(|corner| self.connection.frames[corner as usize]);
        let blended = |of: fn(&Frame) -> glam::Vec3| -> glam::Vec3 {
            (0..3).map(|k| of(&frames[k]) * point.weights[k]).sum()
        };
        let nearest = frames[largest(point.weights)];
        Frame::new(blended(|frame| frame.n), blended(|frame| frame.s)).unwrap_or(nearest)
    }

    /// The factor on the texel at a surface point.
    pub fn scale_at(&self, point: &SurfacePoint) -> f32 {
        let Some(scale) = self.scale else { return 1.0 };
        let corners = self.mesh.triangles[point.triangle as usize];
        (0..3)
            .map(|k| scale[corners[k] as usize] * point.weights[k])
            .sum()
    }
}

/// The place of the largest weight; ties to the first.
pub fn largest<const N: usize>(weights: [f32; N]) -> usize {
    (1..N).fold(0, |best, k| match weights[k] > weights[best] {
        true => k,
        false => best,
    })
}
