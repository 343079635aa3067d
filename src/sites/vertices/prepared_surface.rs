//! A prepared surface: what [`surface`](crate::sites::vertices::surface) makes and
//! [`cache`](crate::sites::vertices::cache) keeps.

use glam::Vec3;

use crate::mesh::frame::Frame;
use crate::mesh::surface_bvh::SurfacePoint;
use crate::mesh::triangle_mesh::TriangleMesh;
use crate::sites::level::SiteHierarchy;
use crate::sites::vertices::VertexSites;
use crate::sites::vertices::sampling::SampleCounts;

/// A surface ready for synthesis.
#[derive(Clone, Debug, PartialEq)]
pub struct Surface {
    /// Level 0 is the user's own vertices; each next level has about a quarter.
    pub meshes: Vec<TriangleMesh>,
    /// Per level the unit normals; (0, 0, 1) for a vertex in no triangle.
    pub normals: Vec<Vec<Vec3>>,
    /// Per level the texture frames, per-vertex rotation included; s is (1, 0, 0) for a vertex in
    /// no triangle.
    pub frames: Vec<Vec<Frame>>,
    /// Stencils, neighbours and parents of all levels.
    pub hierarchy: SiteHierarchy<VertexSites>,
    /// Mesh units a texel of the finest level covers.
    pub texel: f64,
    /// Per level the parent point of each vertex on the next coarser level (nowhere for a vertex in
    /// no triangle); empty at the coarsest.
    pub parent_points: Vec<Vec<SurfacePoint>>,
    /// What became of the samples of the fine stencils, per level.
    pub samples: Vec<SampleCounts>,
}
