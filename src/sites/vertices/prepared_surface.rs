//! A prepared surface: what [`surface`](crate::sites::vertices::surface) makes and
//! [`cache`](crate::sites::vertices::cache) keeps.

use crate::mesh::frame::Frame;
use crate::mesh::triangle_mesh::TriangleMesh;
use crate::sites::level::SiteHierarchy;
use crate::sites::vertices::VertexSites;
use crate::sites::vertices::sampling::SampleCounts;

/// A surface ready for synthesis.
#[derive(Clone, Debug, PartialEq)]
pub struct PreparedSurface {
    /// Level 0 is the user's own vertices; each next level has about a quarter.
    pub levels: Vec<SurfaceLevel>,
    /// Mesh units per texel of the finest level.
    pub texel: f64,
}

/// One level of a prepared surface.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceLevel {
    /// The mesh whose vertices are the sites.
    pub mesh: TriangleMesh,
    /// Per vertex the texture frame, per-vertex rotation included. For a vertex in no triangle, n is (0, 0, 1) and s is
    /// (1, 0, 0).
    pub frames: Vec<Frame>,
    /// Stencils, neighbours and parents.
    pub sites: VertexSites,
    /// What became of the samples of the fine stencils.
    pub samples: SampleCounts,
}

impl PreparedSurface {
    /// The sites of all levels.
    pub fn into_sites(self) -> SiteHierarchy<VertexSites> {
        let levels = self.levels.into_iter().map(|level| level.sites);
        SiteHierarchy {
            levels: levels.collect(),
        }
    }
}
