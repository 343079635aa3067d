//! What pictures show: a mesh, the space it fills, and its front.

use glam::DVec3;

use crate::error::Result;
use crate::mesh::triangle_mesh::TriangleMesh;
use crate::render::bounds::Bounds;
use crate::render::front::Front;
use crate::render::options::RenderOptions;

/// A mesh to be seen.
#[derive(Clone, Copy, Debug)]
pub struct Subject<'a> {
    /// The mesh.
    pub mesh: &'a TriangleMesh,
    /// The space it fills.
    pub bounds: Bounds,
    /// Where its coordinates count from, in those of its file.
    pub origin: DVec3,
    /// The side seen at azimuth 0.
    pub front: Front,
}

impl<'a> Subject<'a> {
    /// Measures a mesh. Its front is that of the options, or guessed.
    pub fn new(mesh: &'a TriangleMesh, origin: DVec3, options: &RenderOptions) -> Result<Self> {
        Ok(Self {
            mesh,
            bounds: Bounds::of(mesh)?,
            origin,
            front: Front::of(mesh, options.camera.up, options.camera.front)?,
        })
    }
}
