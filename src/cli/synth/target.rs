//! What synthesis writes on: a mesh that is prepared here, or a flat grid.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use serde::{Deserialize, Serialize};

use crate::cli::machine::Need;
use crate::cli::session::Session;
use crate::error::{Error, Result};
use crate::exemplar::neighbor_table::{NeighborTable, TableLevel};
use crate::exemplar::space::Space;
use crate::maps::vertex_map::{check_scale, varying};
use crate::mesh::reading::UserMesh;
use crate::neighborhood::{Neighborhood, window_width};
use crate::sites::grid::target::GridTarget;
use crate::sites::level::Sites;
use crate::sites::target::{Target, TargetSites, TargetSurface};
use crate::sites::vertices::cache;
use crate::sites::vertices::circles::{self, CircleSource, RoundOptions};
use crate::sites::vertices::memory::{bytes_to_march, bytes_to_prepare};
use crate::sites::vertices::surface::{self, Surface};
use crate::sites::vertices::surface_options::{SurfaceOptions, texel_on};
use crate::synthesis::memory;
use crate::synthesis::options::{Method, SynthesisOptions};

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

/// Kinds of sites.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Onto {
    /// The vertices of the mesh
    Vertices,
    /// A flat grid, of the size that --grid says
    Grid,
}

/// A target ready for synthesis, and how it came about.
pub struct Prepared {
    /// It.
    pub target: Target,
    /// Where the circles round its vertices came from, if it has any.
    pub circles: Option<CircleSource>,
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
    /// What the map is made on; --grid means grid
    #[arg(long, value_enum)]
    pub onto: Option<Onto>,
    /// What lies beyond the grid's border
    #[arg(long, value_enum, default_value_t = Border::Wrap, requires = "grid")]
    pub border: Border,
    #[command(flatten)]
    pub surface: SurfaceOptions,
}

impl TargetArguments {
    /// Refuses sites that the target does not have.
    pub fn check(&self) -> Result<()> {
        match (self.onto, self.grid) {
            (Some(Onto::Grid), None) => Err(Error::option("onto", "grid", "--grid WxH beside it")),
            (Some(Onto::Vertices), Some(_)) => Err(Error::option(
                "onto",
                "vertices, but --grid has none",
                "a mesh, or --onto grid",
            )),
            _ => Ok(()),
        }
    }

    /// Prepares the target for the neighbourhoods of a method; `is_measured` says whether all figures are wanted.
    pub fn prepare(
        &self,
        (space, table): (&Space, &NeighborTable),
        options: &SynthesisOptions,
        is_measured: bool,
        session: &Session,
    ) -> Result<Prepared> {
        let exemplar = memory::exemplar_bytes(space, table);
        let levels = options
            .levels
            .map_or(table.levels.len(), |levels| levels as usize);
        let of_table = |target| Prepared {
            target,
            circles: None,
        };
        let is_round = options.method == Method::Adaptive;
        let levels_of_round = options.adaptive_levels(space.levels.len());
        match (&self.mesh, self.grid) {
            (_, Some(_)) => {
                let grid = self.checked_grid(exemplar)?;
                Ok(of_table(match is_round {
                    true => round_grid(grid, table, options, levels_of_round)?,
                    false => flat_grid(grid, &table.levels[..levels])?,
                }))
            }
            (Some(path), None) if is_round => {
                let user = crate::mesh::reading::read(path, session.progress())?;
                let round = RoundOptions {
                    rings: options.adaptive.rings,
                    levels: levels_of_round as u32,
                    texel: self.surface.texel,
                    guides: self.surface.guides(),
                    seed: session.seed(),
                };
                let round = RoundMesh {
                    path,
                    user: &user,
                    options: &round,
                    exemplar,
                };
                let mut prepared = round.prepare(session)?;
                if is_measured {
                    let surface = prepare_mesh(path, &user, self, (table, exemplar), 1, session)?;
                    prepared.target.measured = Some(TargetSites::Vertices(surface.hierarchy));
                }
                Ok(prepared)
            }
            (Some(path), None) => {
                let user = crate::mesh::reading::read(path, session.progress())?;
                let surface = prepare_mesh(path, &user, self, (table, exemplar), levels, session)?;
                check_density(&surface, self.surface.texel)?;
                let scale = varying(user.scale.as_deref()).map(<[f32]>::to_vec);
                Ok(of_table(Target::of_surface(surface, scale, user.origin)))
            }
            (None, None) => Err(Error::option("grid", "no target", "a mesh, or --grid WxH")),
        }
    }

    /// The grid that was asked for, if there is memory for it.
    fn checked_grid(&self, exemplar: u64) -> Result<GridTarget> {
        let Some(grid) = self.grid else {
            return Err(Error::option("grid", "none", "WxH"));
        };
        if self.surface.texel.is_some() {
            return Err(Error::option(
                "texel",
                "a flat grid",
                "a mesh; on a grid a site is a texel",
            ));
        }
        check_memory(
            "grid",
            format!("{}x{} sites", grid.width, grid.height),
            exemplar + memory::grid_bytes(grid.width, grid.height),
            "a smaller --grid",
        )?;
        Ok(GridTarget {
            toroidal: self.border == Border::Wrap,
            ..grid
        })
    }
}

/// A flat grid with the square windows of a table.
fn flat_grid(grid: GridTarget, levels: &[TableLevel]) -> Result<Target> {
    let neighborhoods = levels.iter().map(|level| level.neighborhood.clone());
    let neighborhoods: Vec<Neighborhood> = neighborhoods.collect();
    Ok(Target {
        sites: TargetSites::Grid(grid.hierarchy(&neighborhoods)?),
        surface: TargetSurface::of_grid(grid),
        measured: None,
    })
}

/// A flat grid with round neighbourhoods; its map is measured in the square window of the table.
fn round_grid(
    grid: GridTarget,
    table: &NeighborTable,
    options: &SynthesisOptions,
    levels: usize,
) -> Result<Target> {
    let square = Neighborhood::square(window_width(&table.levels[0].neighborhood.offsets), 0);
    Ok(Target {
        sites: TargetSites::RoundGrid(grid.round_hierarchy(options.adaptive.rings, levels)?),
        surface: TargetSurface::of_grid(grid),
        measured: Some(TargetSites::Grid(grid.hierarchy(&[square])?)),
    })
}

/// A mesh that gets round neighbourhoods.
struct RoundMesh<'a> {
    path: &'a Path,
    user: &'a UserMesh,
    options: &'a RoundOptions,
    exemplar: u64,
}

impl RoundMesh<'_> {
    fn prepare(&self, session: &Session) -> Result<Prepared> {
        let (user, options) = (self.user, self.options);
        let texel = texel_on(&user.mesh, options.texel)?;
        check_memory(
            "rings",
            format!(
                "{} vertices at a texel of {texel}",
                user.mesh.positions.len()
            ),
            self.exemplar + bytes_to_march(user, options, texel),
            "fewer --rings or --levels, a smaller --texel, or a mesh of fewer vertices",
        )?;
        let cache = cache::folder_of(self.path);
        let round = circles::prepare(user, options, Some(&cache), session.progress())
            .map_err(|error| error.in_file(self.path))?;
        let was_marched = round
            .levels
            .iter()
            .any(|level| level.source == CircleSource::Marched);
        let source = match was_marched {
            true => CircleSource::Marched,
            false => CircleSource::Read,
        };
        let surface = TargetSurface {
            mesh: user.mesh.clone(),
            normals: round.frames.iter().map(|frame| frame.n).collect(),
            orientations: round.frames.iter().map(|frame| frame.s).collect(),
            scale: varying(user.scale.as_deref()).map(<[f32]>::to_vec),
            texel,
            origin: user.origin,
            grid: None,
        };
        Ok(Prepared {
            target: Target {
                surface,
                sites: TargetSites::Vertices(round.hierarchy),
                measured: None,
            },
            circles: Some(source),
        })
    }
}

/// The file's mesh with everything synthesis needs of it, cached beside it.
fn prepare_mesh(
    path: &Path,
    user: &UserMesh,
    arguments: &TargetArguments,
    (table, exemplar): (&NeighborTable, u64),
    levels: usize,
    session: &Session,
) -> Result<Surface> {
    let options = SurfaceOptions {
        levels: levels as u32,
        neighborhood: window_width(&table.levels[0].neighborhood.offsets),
        coarse_neighborhood: window_width(&table.levels[0].neighborhood.coarse_offsets),
        seed: session.seed(),
        ..arguments.surface.clone()
    };
    options.validate()?;
    let texel = options.texel_on(&user.mesh)?;
    if let Some(scale) = varying(user.scale.as_deref()) {
        check_scale(scale, texel).map_err(|error| error.in_file(path))?;
    }
    check_memory(
        "texel",
        format!(
            "{} vertices at a texel of {texel}",
            user.mesh.positions.len()
        ),
        exemplar + bytes_to_prepare(user, &options, texel),
        "a smaller --texel, a mesh of fewer vertices (mesh --vertices), or a table of a smaller \
         knn --neighborhood",
    )?;
    let cache = cache::folder_of(path);
    surface::prepare(user, &options, Some(&cache), session.progress())
        .map_err(|error| error.in_file(path))
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
    let on_surface = (0..sites.count()).filter(|&site| sites.areas[site] > 0.0);
    let (mut count, mut alone) = (0usize, 0usize);
    for site in on_surface {
        count += 1;
        alone += usize::from(sites.neighbors.row(site).is_empty());
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
