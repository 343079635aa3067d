//! Any target: sites on all levels, and the surface they lie on.

use glam::{DVec3, Vec3};

use crate::mesh::triangle_mesh::TriangleMesh;
use crate::sites::grid::GridSites;
use crate::sites::grid::target::GridTarget;
use crate::sites::level::{SiteEdge, SiteHierarchy, Sites};
use crate::sites::vertices::surface::Surface;

/// A target ready for synthesis.
pub enum Target {
    /// A prepared mesh.
    Vertices(MeshTarget),
    /// A flat grid.
    Grid {
        /// Its size.
        grid: GridTarget,
        /// Its sites.
        sites: SiteHierarchy<GridSites>,
        /// It as a surface.
        mesh: TriangleMesh,
    },
}

/// A prepared mesh, and what of its file the map keeps.
pub struct MeshTarget {
    /// The surface.
    pub surface: Box<Surface>,
    /// What its positions count from.
    pub origin: DVec3,
    /// Factor on the texel at each vertex; `None` for 1 everywhere.
    pub scale: Option<Vec<f32>>,
}

/// Work on the sites of a target, whatever they are.
pub trait WithSites {
    /// What comes of it.
    type Found;

    /// Does the work.
    fn run<const N: usize, S: Sites<N>>(self, sites: &SiteHierarchy<S>) -> Self::Found;
}

impl Target {
    /// Does some work on the sites of all levels.
    pub fn with_sites<W: WithSites>(&self, work: W) -> W::Found {
        match self {
            Self::Vertices(target) => work.run(&target.surface.hierarchy),
            Self::Grid { sites, .. } => work.run(sites),
        }
    }

    /// The surface of level 0.
    pub fn mesh(&self) -> &TriangleMesh {
        match self {
            Self::Vertices(target) => &target.surface.meshes[0],
            Self::Grid { mesh, .. } => mesh,
        }
    }

    /// What the positions of the surface count from.
    pub fn origin(&self) -> DVec3 {
        match self {
            Self::Vertices(target) => target.origin,
            Self::Grid { .. } => DVec3::ZERO,
        }
    }

    /// Unit normals of the sites.
    pub fn normals(&self) -> Vec<Vec3> {
        match self {
            Self::Vertices(target) => target.surface.normals[0].clone(),
            Self::Grid { mesh, .. } => vec![Vec3::Z; mesh.positions.len()],
        }
    }

    /// The orientation field.
    pub fn orientations(&self) -> Vec<Vec3> {
        match self {
            Self::Vertices(target) => {
                let frames = target.surface.frames[0].iter();
                frames.map(|frame| frame.s).collect()
            }
            Self::Grid { mesh, .. } => vec![Vec3::X; mesh.positions.len()],
        }
    }

    /// Factor on the texel at each site; `None` for 1 everywhere.
    pub fn scale(&self) -> Option<&[f32]> {
        match self {
            Self::Vertices(target) => target.scale.as_deref(),
            Self::Grid { .. } => None,
        }
    }

    /// Mesh units that a texel covers where the scale is 1.
    pub fn texel(&self) -> f64 {
        match self {
            Self::Vertices(target) => target.surface.texel,
            Self::Grid { .. } => 1.0,
        }
    }

    /// Every edge i < j, with the place of j seen from i in texels.
    pub fn edges(&self) -> Vec<SiteEdge> {
        match self {
            Self::Vertices(target) => target.edges(),
            Self::Grid { grid, .. } => grid.edges(),
        }
    }
}

impl MeshTarget {
    /// Every edge of the mesh, measured in texels of the vertex it is seen from.
    pub fn edges(&self) -> Vec<SiteEdge> {
        let (mesh, frames) = (&self.surface.meshes[0], &self.surface.frames[0]);
        let corners = mesh.triangles.iter();
        let mut pairs: Vec<[u32; 2]> = corners
            .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]])
            .map(|[a, b]| [a.min(b), a.max(b)])
            .collect();
        pairs.sort_unstable();
        pairs.dedup();
        let scale = |vertex: u32| self.scale.as_ref().map_or(1.0, |of| of[vertex as usize]);
        let edge = |&[from, to]: &[u32; 2]| {
            let along = mesh.positions[to as usize] - mesh.positions[from as usize];
            let texel = self.surface.texel as f32 * scale(from);
            let seen = frames[from as usize].frame_from_mesh(along) / texel;
            SiteEdge {
                from,
                to,
                offset: [seen.x, seen.y],
            }
        };
        pairs.iter().map(edge).collect()
    }
}
