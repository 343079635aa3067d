//! Any target: sites on all levels, and the surface they lie on.

use glam::{DVec3, Vec3};

use crate::mesh::triangle_mesh::TriangleMesh;
use crate::sites::grid::GridSites;
use crate::sites::grid::target::GridTarget;
use crate::sites::level::{SiteEdge, SiteHierarchy, Sites};
use crate::sites::vertices::surface::Surface;

/// A target ready for synthesis.
pub enum Target {
    /// A prepared mesh, and what its positions count from.
    Vertices(Box<Surface>, DVec3),
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
            Self::Vertices(surface, _) => work.run(&surface.hierarchy),
            Self::Grid { sites, .. } => work.run(sites),
        }
    }

    /// The surface of level 0.
    pub fn mesh(&self) -> &TriangleMesh {
        match self {
            Self::Vertices(surface, _) => &surface.meshes[0],
            Self::Grid { mesh, .. } => mesh,
        }
    }

    /// What the positions of the surface count from.
    pub fn origin(&self) -> DVec3 {
        match self {
            Self::Vertices(_, origin) => *origin,
            Self::Grid { .. } => DVec3::ZERO,
        }
    }

    /// Unit normals of the sites.
    pub fn normals(&self) -> Vec<Vec3> {
        match self {
            Self::Vertices(surface, _) => surface.normals[0].clone(),
            Self::Grid { mesh, .. } => vec![Vec3::Z; mesh.positions.len()],
        }
    }

    /// The orientation field.
    pub fn orientations(&self) -> Vec<Vec3> {
        match self {
            Self::Vertices(surface, _) => surface.frames[0].iter().map(|frame| frame.s).collect(),
            Self::Grid { mesh, .. } => vec![Vec3::X; mesh.positions.len()],
        }
    }

    /// Mesh units that a texel covers.
    pub fn texel(&self) -> f64 {
        match self {
            Self::Vertices(surface, _) => surface.texel,
            Self::Grid { .. } => 1.0,
        }
    }

    /// Every edge i < j, with the place of j seen from i in texels.
    pub fn edges(&self) -> Vec<SiteEdge> {
        match self {
            Self::Vertices(surface, _) => mesh_edges(surface),
            Self::Grid { grid, .. } => grid.edges(),
        }
    }
}

fn mesh_edges(surface: &Surface) -> Vec<SiteEdge> {
    let (mesh, frames) = (&surface.meshes[0], &surface.frames[0]);
    let corners = mesh.triangles.iter();
    let mut pairs: Vec<[u32; 2]> = corners
        .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]])
        .map(|[a, b]| [a.min(b), a.max(b)])
        .collect();
    pairs.sort_unstable();
    pairs.dedup();
    let edge = |&[from, to]: &[u32; 2]| {
        let along = mesh.positions[to as usize] - mesh.positions[from as usize];
        let seen = frames[from as usize].frame_from_mesh(along) / surface.texel as f32;
        SiteEdge {
            from,
            to,
            offset: [seen.x, seen.y],
        }
    };
    pairs.iter().map(edge).collect()
}
