//! Any target: the surface that is textured, and its sites on all levels.

use glam::{DVec3, Vec3};

use crate::mesh::frame::Frame;
use crate::mesh::triangle_mesh::TriangleMesh;
use crate::sites::grid::GridSites;
use crate::sites::grid::round::RoundGridSites;
use crate::sites::grid::target::GridTarget;
use crate::sites::level::{SiteEdge, SiteHierarchy, Sites};
use crate::sites::vertices::VertexSites;
use crate::sites::vertices::surface::Surface;

/// A target ready for synthesis.
pub struct Target {
    /// The surface, of which every vertex is a site of level 0.
    pub surface: TargetSurface,
    /// Where synthesis writes.
    pub sites: TargetSites,
    /// Level 0 with the square window of the neighbour table, in which a map is measured, where `sites` has
    /// other neighbourhoods.
    pub measured: Option<TargetSites>,
}

/// The surface of a target.
pub struct TargetSurface {
    /// It as a mesh.
    pub mesh: TriangleMesh,
    /// Unit normals.
    pub normals: Vec<Vec3>,
    /// The orientation field: s in space.
    pub orientations: Vec<Vec3>,
    /// Factor on the texel at each site; `None` for 1 everywhere.
    pub scale: Option<Vec<f32>>,
    /// Mesh units that a texel covers where the scale is 1.
    pub texel: f64,
    /// What positions count from.
    pub origin: DVec3,
    /// The flat grid that it is, if it is one.
    pub grid: Option<GridTarget>,
}

/// The sites of a target, by their kind.
pub enum TargetSites {
    /// Vertices of a mesh and of its pyramid, or of one mesh with round neighbourhoods.
    Vertices(SiteHierarchy<VertexSites>),
    /// A flat grid.
    Grid(SiteHierarchy<GridSites>),
    /// A flat grid with round neighbourhoods.
    RoundGrid(SiteHierarchy<RoundGridSites>),
}

/// Work on the sites of a target, whatever they are.
pub trait WithSites {
    /// What comes of it.
    type Found;

    /// Does the work.
    fn run<const N: usize, S: Sites<N>>(self, sites: &SiteHierarchy<S>) -> Self::Found;
}

impl TargetSites {
    /// Does some work on the sites of all levels.
    pub fn with<W: WithSites>(&self, work: W) -> W::Found {
        match self {
            Self::Vertices(sites) => work.run(sites),
            Self::Grid(sites) => work.run(sites),
            Self::RoundGrid(sites) => work.run(sites),
        }
    }
}

impl Target {
    /// The target of a prepared mesh; `scale` is that of its vertices.
    pub fn of_surface(surface: Surface, scale: Option<Vec<f32>>, origin: DVec3) -> Self {
        let first = |frames: Vec<Vec<Frame>>| frames.into_iter().next().unwrap_or_default();
        let frames = first(surface.frames);
        Self {
            surface: TargetSurface {
                mesh: surface.meshes.into_iter().next().unwrap_or_default(),
                normals: surface.normals.into_iter().next().unwrap_or_default(),
                orientations: frames.iter().map(|frame| frame.s).collect(),
                scale,
                texel: surface.texel,
                origin,
                grid: None,
            },
            sites: TargetSites::Vertices(surface.hierarchy),
            measured: None,
        }
    }

    /// Does some work on the sites that a map is measured on; `None` where there are none.
    pub fn with_measured<W: WithSites>(&self, work: W) -> Option<W::Found> {
        let own = matches!(&self.sites, TargetSites::Vertices(_) | TargetSites::Grid(_));
        let sites = match &self.measured {
            Some(sites) => Some(sites),
            None => own.then_some(&self.sites),
        };
        sites.map(|sites| sites.with(work))
    }
}

impl TargetSurface {
    /// The surface of a flat grid.
    pub fn of_grid(grid: GridTarget) -> Self {
        let mesh = grid.mesh();
        let sites = mesh.positions.len();
        Self {
            mesh,
            normals: vec![Vec3::Z; sites],
            orientations: vec![Vec3::X; sites],
            scale: None,
            texel: 1.0,
            origin: DVec3::ZERO,
            grid: Some(grid),
        }
    }

    /// Every edge i < j, with the place of j seen from i in texels of i.
    pub fn edges(&self) -> Vec<SiteEdge> {
        if let Some(grid) = self.grid {
            return grid.edges();
        }
        let corners = self.mesh.triangles.iter();
        let mut pairs: Vec<[u32; 2]> = corners
            .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]])
            .map(|[a, b]| [a.min(b), a.max(b)])
            .collect();
        pairs.sort_unstable();
        pairs.dedup();
        let scale = |vertex: u32| self.scale.as_ref().map_or(1.0, |of| of[vertex as usize]);
        let edge = |&[from, to]: &[u32; 2]| {
            let at = from as usize;
            let along = self.mesh.positions[to as usize] - self.mesh.positions[at];
            let (n, s) = (self.normals[at], self.orientations[at]);
            let frame = Frame {
                s,
                t: n.cross(s),
                n,
            };
            let seen = frame.frame_from_mesh(along) / (self.texel as f32 * scale(from));
            SiteEdge {
                from,
                to,
                offset: [seen.x, seen.y],
            }
        };
        pairs.iter().map(edge).collect()
    }
}
