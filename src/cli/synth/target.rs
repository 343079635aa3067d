//! What synthesis writes on: a mesh that is prepared here, or a flat grid.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use glam::{DVec3, Vec3};
use serde::{Deserialize, Serialize};

use crate::cli::machine::Need;
use crate::cli::session::Session;
use crate::error::{Error, Result};
use crate::exemplar::neighbor_table::{NeighborTable, Neighborhood};
use crate::exemplar::space::Space;
use crate::mesh::cache;
use crate::mesh::hierarchy::SiteHierarchy;
use crate::mesh::memory::bytes_to_prepare;
use crate::mesh::surface::{self, Surface};
use crate::mesh::surface_options::SurfaceOptions;
use crate::mesh::triangle_mesh::TriangleMesh;
use crate::synthesis::check::window_width;
use crate::synthesis::grid_target::GridTarget;
use crate::synthesis::memory;
use crate::synthesis::options::SynthesisOptions;
use crate::synthesis::quality::coherence::SiteEdge;

/// What happens at a flat grid's border.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Border {
    /// Opposite borders continue each other: the result tiles
    #[default]
    Wrap,
    /// Beyond the border lies the default texton
    Open,
}

/// The target and how it is prepared.
#[derive(Debug, Args)]
#[command(next_help_heading = "Target")]
pub struct TargetArguments {
    /// The mesh: OBJ, PLY, STL, OFF, glTF or GLB
    #[arg(required_unless_present = "grid", conflicts_with = "grid")]
    pub mesh: Option<PathBuf>,
    /// A flat grid of WxH sites instead of a mesh
    #[arg(long, value_name = "WxH")]
    pub grid: Option<GridTarget>,
    /// What lies beyond the grid's border
    #[arg(long, value_enum, default_value_t = Border::Wrap, requires = "grid")]
    pub border: Border,
    #[command(flatten)]
    pub surface: SurfaceOptions,
}

/// A target ready for synthesis.
pub enum Target {
    /// A prepared mesh, and what its positions count from.
    Surface(Box<Surface>, DVec3),
    /// A flat grid.
    Grid {
        /// Its size.
        grid: GridTarget,
        /// Its sites.
        sites: SiteHierarchy,
        /// It as a surface.
        mesh: TriangleMesh,
    },
}

impl Target {
    /// Prepares the target for the neighbourhoods of an exemplar's table.
    pub fn prepare(
        arguments: &TargetArguments,
        (space, table): (&Space, &NeighborTable),
        options: &SynthesisOptions,
        session: &Session,
    ) -> Result<Self> {
        let levels = options
            .levels
            .map_or(table.levels.len(), |levels| levels as usize);
        let exemplar = memory::exemplar_bytes(space, table);
        match (&arguments.mesh, arguments.grid) {
            (_, Some(grid)) => {
                if arguments.surface.texel.is_some() {
                    return Err(Error::option(
                        "texel",
                        "a flat grid",
                        "a mesh; on a grid a site is a texel",
                    ));
                }
                let grid = GridTarget {
                    toroidal: arguments.border == Border::Wrap,
                    ..grid
                };
                let sites = format!("{}x{} sites", grid.width, grid.height);
                check_memory(
                    "grid",
                    sites,
                    exemplar + memory::grid_bytes(grid.width, grid.height),
                    "a smaller --grid",
                )?;
                let neighborhoods: Vec<Neighborhood> = table.levels[..levels]
                    .iter()
                    .map(|level| level.neighborhood.clone())
                    .collect();
                Ok(Self::Grid {
                    sites: grid.hierarchy(&neighborhoods)?,
                    mesh: grid.mesh(),
                    grid,
                })
            }
            (Some(path), None) => {
                let (surface, origin) =
                    prepare_mesh(path, arguments, (table, exemplar), levels, session)?;
                check_density(&surface, arguments.surface.texel)?;
                Ok(Self::Surface(Box::new(surface), origin))
            }
            (None, None) => Err(Error::option("grid", "no target", "a mesh, or --grid WxH")),
        }
    }

    /// The sites of all levels.
    pub fn sites(&self) -> &SiteHierarchy {
        match self {
            Self::Surface(surface, _) => &surface.hierarchy,
            Self::Grid { sites, .. } => sites,
        }
    }

    /// The surface of level 0.
    pub fn mesh(&self) -> &TriangleMesh {
        match self {
            Self::Surface(surface, _) => &surface.meshes[0],
            Self::Grid { mesh, .. } => mesh,
        }
    }

    /// What the positions of the surface count from.
    pub fn origin(&self) -> DVec3 {
        match self {
            Self::Surface(_, origin) => *origin,
            Self::Grid { .. } => DVec3::ZERO,
        }
    }

    /// Unit normals of the sites.
    pub fn normals(&self) -> Vec<Vec3> {
        match self {
            Self::Surface(surface, _) => surface.normals[0].clone(),
            Self::Grid { mesh, .. } => vec![Vec3::Z; mesh.positions.len()],
        }
    }

    /// The orientation field.
    pub fn orientations(&self) -> Vec<Vec3> {
        match self {
            Self::Surface(surface, _) => surface.frames[0].iter().map(|frame| frame.s).collect(),
            Self::Grid { mesh, .. } => vec![Vec3::X; mesh.positions.len()],
        }
    }

    /// Mesh units a texel covers.
    pub fn texel(&self) -> f64 {
        match self {
            Self::Surface(surface, _) => surface.texel,
            Self::Grid { .. } => 1.0,
        }
    }

    /// Every edge i < j, with the place of j seen from i in texels.
    pub fn edges(&self) -> Vec<SiteEdge> {
        match self {
            Self::Surface(surface, _) => mesh_edges(surface),
            Self::Grid { grid, .. } => grid.edges(),
        }
    }
}

/// The file's mesh with everything synthesis needs of it, cached beside it.
fn prepare_mesh(
    path: &Path,
    arguments: &TargetArguments,
    (table, exemplar): (&NeighborTable, u64),
    levels: usize,
    session: &Session,
) -> Result<(Surface, DVec3)> {
    let user = crate::mesh::reading::read(path, session.progress())?;
    let options = SurfaceOptions {
        levels: levels as u32,
        neighborhood: window_width(&table.levels[0].neighborhood.offsets),
        coarse_neighborhood: window_width(&table.levels[0].neighborhood.coarse_offsets),
        seed: session.seed(),
        ..arguments.surface.clone()
    };
    options.validate()?;
    let texel = options.texel_on(&user.mesh)?;
    check_memory(
        "texel",
        format!(
            "{} vertices at a texel of {texel}",
            user.mesh.positions.len()
        ),
        exemplar + bytes_to_prepare(&user, &options, texel),
        "a smaller --texel, a mesh of fewer vertices (mesh --vertices), or a table of a smaller \
         knn --neighborhood",
    )?;
    let cache = cache::folder_of(path);
    let surface = surface::prepare(&user, &options, Some(&cache), session.progress())
        .map_err(|error| error.in_file(path))?;
    Ok((surface, user.origin))
}

/// Refuses a target that this machine has too little memory for.
fn check_memory(option: &'static str, work: String, bytes: u64, advice: &str) -> Result<()> {
    let need = Need {
        bytes,
        work,
        option,
        advice: advice.into(),
    };
    need.check()
}

/// Refuses a mesh so coarse that most sites see no other.
///
/// That is the fault of `texel` where it was asked for, else of the mesh's own scale.
fn check_density(surface: &Surface, texel: Option<f64>) -> Result<()> {
    let sites = &surface.hierarchy.levels[0];
    let on_surface = (0..sites.site_count).filter(|&site| sites.areas[site] > 0.0);
    let (mut count, mut alone) = (0usize, 0usize);
    for site in on_surface {
        count += 1;
        alone += usize::from(sites.neighbors.of_site(site).next().is_none());
    }
    if 2 * alone <= count {
        return Ok(());
    }
    let area = surface.meshes[0].area();
    let found = format!("{alone} of {count} vertices have no other within the neighbourhood");
    let Some(texel) = texel else {
        return Err(Error::data("vertices", found)
            .advice("check the property `scale`, or retile the mesh with mesh --vertices"));
    };
    Err(Error::option(
        "texel",
        format!("{texel}: {found}"),
        format!(
            "about {:.3e} for this mesh, or mesh --vertices {} for this texel",
            (area / count.max(1) as f64).sqrt(),
            (area / texel.powi(2)).ceil()
        ),
    ))
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
