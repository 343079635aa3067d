//! Any target: the surface that is textured, and its sites on all levels.

use std::mem;
use std::path::Path;

use glam::{DVec3, Vec3};

use crate::error::{Error, Result};
use crate::mesh::frame::Frame;
use crate::mesh::reading::{UserMesh, varying};
use crate::mesh::triangle_mesh::TriangleMesh;
use crate::neighborhood::Neighborhood;
use crate::progress::Progress;
use crate::sites::atlas::AtlasSites;
use crate::sites::atlas::options::AtlasOptions;
use crate::sites::atlas::preparation::{self, AtlasSurface};
use crate::sites::controls::SiteControls;
use crate::sites::grid::GridSites;
use crate::sites::grid::round::RoundGridSites;
use crate::sites::grid::window::SiteGrid;
use crate::sites::level::{SiteEdge, SiteHierarchy, Sites};
use crate::sites::vertices::VertexSites;
use crate::sites::vertices::circles::{self, CircleSource, RoundOptions};
use crate::sites::vertices::prepared_surface::{PreparedSurface, SurfaceLevel};
use crate::sites::vertices::surface;
use crate::sites::vertices::surface_options::{SurfaceOptions, texel_on};

/// A target ready for synthesis.
pub struct Target {
    /// The surface, of which every vertex is a site of level 0.
    pub surface: TargetSurface,
    /// Where synthesis writes.
    pub sites: TargetSites,
    /// Level 0 with the square window of the neighbour table, in which a map is measured, where `sites` has
    /// other neighbourhoods.
    pub measured: Option<TargetSites>,
    /// What a texture that changes follows on it.
    pub controls: Option<SiteControls>,
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
    pub grid: Option<SiteGrid>,
    /// The atlas that it is, if it is one: its mesh has a vertex at every texel inside a chart.
    pub atlas: Option<Box<AtlasSurface>>,
}

/// The sites of a target, by their kind.
pub enum TargetSites {
    /// Vertices of a mesh and of its pyramid.
    Vertices(SiteHierarchy<VertexSites>),
    /// Vertices of one mesh with round neighbourhoods.
    RoundVertices(SiteHierarchy<VertexSites>),
    /// A flat grid.
    Grid(SiteHierarchy<GridSites>),
    /// A flat grid with round neighbourhoods.
    RoundGrid(SiteHierarchy<RoundGridSites>),
    /// The texels of an atlas and of its pyramid.
    Atlas(SiteHierarchy<AtlasSites>),
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
            Self::Vertices(sites) | Self::RoundVertices(sites) => work.run(sites),
            Self::Grid(sites) => work.run(sites),
            Self::RoundGrid(sites) => work.run(sites),
            Self::Atlas(sites) => work.run(sites),
        }
    }
}

impl Target {
    /// A flat grid with the square windows of as many levels, finest first.
    pub fn grid(grid: SiteGrid, neighborhoods: &[Neighborhood]) -> Result<Self> {
        Ok(Self {
            sites: TargetSites::Grid(grid.hierarchy(neighborhoods)?),
            surface: TargetSurface::of_grid(grid),
            measured: None,
            controls: None,
        })
    }

    /// A flat grid with round neighbourhoods of this many rings at every level; its map is measured in the window
    /// `square`.
    pub fn round_grid(
        grid: SiteGrid,
        (rings, levels): (u32, usize),
        square: Neighborhood,
    ) -> Result<Self> {
        Ok(Self {
            sites: TargetSites::RoundGrid(grid.round_hierarchy(rings, levels)?),
            surface: TargetSurface::of_grid(grid),
            measured: Some(TargetSites::Grid(grid.hierarchy(&[square])?)),
            controls: None,
        })
    }

    /// A mesh with square windows, prepared or taken from the folder `cache`.
    ///
    /// Refuses one so coarse that most of its vertices see no other.
    pub fn mesh(
        user: &UserMesh,
        options: &SurfaceOptions,
        cache: Option<&Path>,
        progress: Progress<'_>,
    ) -> Result<Self> {
        let surface = surface::prepare(user, options, cache, progress)?;
        check_density(&surface, options.texel)?;
        Ok(Self::of_surface(surface, user))
    }

    /// A mesh with round neighbourhoods, and where the circles round its vertices came from.
    pub fn round_mesh(
        user: &UserMesh,
        options: &RoundOptions,
        cache: Option<&Path>,
        progress: Progress<'_>,
    ) -> Result<(Self, CircleSource)> {
        // Prepare the sites.
        let round = circles::prepare(user, options, cache, progress)?;
        let was_marched = round
            .levels
            .iter()
            .any(|level| level.source == CircleSource::Marched);
        let source = match was_marched {
            true => CircleSource::Marched,
            false => CircleSource::Read,
        };
        // Take the surface.
        let surface = TargetSurface {
            mesh: user.mesh.clone(),
            normals: round.frames.iter().map(|frame| frame.n).collect(),
            orientations: round.frames.iter().map(|frame| frame.s).collect(),
            scale: varying(user.scale.as_deref()).map(<[f32]>::to_vec),
            texel: texel_on(&user.mesh, options.texel)?,
            origin: user.origin,
            grid: None,
            atlas: None,
        };
        let target = Self {
            surface,
            sites: TargetSites::RoundVertices(round.hierarchy),
            measured: None,
            controls: None,
        };
        Ok((target, source))
    }

    /// The texture atlas of a mesh: its own texture coordinates, or new ones.
    pub fn atlas(user: &UserMesh, options: &AtlasOptions, progress: Progress<'_>) -> Result<Self> {
        let (surface, hierarchy) = preparation::prepare(user, options, progress)?;
        let surface = TargetSurface {
            mesh: TriangleMesh {
                positions: surface.positions.clone(),
                triangles: surface.triangles.clone(),
            },
            normals: surface.normals.clone(),
            orientations: surface.orientations.clone(),
            scale: surface.scale.clone(),
            texel: surface.texel,
            origin: user.origin,
            grid: None,
            atlas: Some(Box::new(surface)),
        };
        Ok(Self {
            surface,
            sites: TargetSites::Atlas(hierarchy),
            measured: None,
            controls: None,
        })
    }

    /// The target of a prepared mesh.
    pub fn of_surface(mut surface: PreparedSurface, user: &UserMesh) -> Self {
        let finest = &mut surface.levels[0];
        let (mesh, frames) = (mem::take(&mut finest.mesh), mem::take(&mut finest.frames));
        Self {
            surface: TargetSurface {
                mesh,
                normals: frames.iter().map(|frame| frame.n).collect(),
                orientations: frames.iter().map(|frame| frame.s).collect(),
                scale: varying(user.scale.as_deref()).map(<[f32]>::to_vec),
                texel: surface.texel,
                origin: user.origin,
                grid: None,
                atlas: None,
            },
            sites: TargetSites::Vertices(surface.into_sites()),
            measured: None,
            controls: None,
        }
    }

    /// Does some work on the sites that a map is measured on; `None` where there are none.
    pub fn with_measured<W: WithSites>(&self, work: W) -> Option<W::Found> {
        let own = matches!(
            &self.sites,
            TargetSites::Vertices(_) | TargetSites::Grid(_) | TargetSites::Atlas(_)
        );
        let sites = match &self.measured {
            Some(sites) => Some(sites),
            None => own.then_some(&self.sites),
        };
        sites.map(|sites| sites.with(work))
    }
}

impl TargetSurface {
    /// The surface of a flat grid.
    fn of_grid(grid: SiteGrid) -> Self {
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
            atlas: None,
        }
    }

    /// Every edge i < j, with the place of j seen from i in texels of i.
    pub fn edges(&self) -> Vec<SiteEdge> {
        // Take the edges of grids and atlases.
        if let Some(grid) = self.grid {
            return grid.edges();
        }
        if let Some(atlas) = &self.atlas {
            return atlas.edges.clone();
        }
        // List those of a mesh, each once.
        let corners = self.mesh.triangles.iter();
        let mut pairs: Vec<[u32; 2]> = corners
            .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]])
            .map(|[a, b]| [a.min(b), a.max(b)])
            .collect();
        pairs.sort_unstable();
        pairs.dedup();
        // See each from its first end.
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

/// Refuses a mesh so coarse that most sites see no other.
///
/// That is the fault of `texel` where it was asked for, else of the mesh's own scale.
fn check_density(surface: &PreparedSurface, texel: Option<f64>) -> Result<()> {
    let SurfaceLevel { mesh, sites, .. } = &surface.levels[0];
    let on_surface = (0..sites.count()).filter(|&site| sites.areas[site] > 0.0);
    let (mut count, mut alone) = (0usize, 0usize);
    for site in on_surface {
        count += 1;
        alone += usize::from(sites.neighbors.row(site).is_empty());
    }
    if 2 * alone <= count {
        return Ok(());
    }
    let area = mesh.area();
    let found = format!("{alone} of {count} vertices have no other within the neighbourhood");
    let Some(texel) = texel else {
        return Err(Error::data("vertices", found)
            .advice("check the property `scale`, or retile the mesh with mesh --vertices"));
    };
    Err(Error::option(
        "texel",
        format!("{texel}: {found}"),
        format!(
            "--texel {:.3e} for this mesh, or mesh --vertices {} for this texel",
            (area / count.max(1) as f64).sqrt(),
            (area / texel.powi(2)).ceil()
        ),
    ))
}
