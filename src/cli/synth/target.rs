//! What synthesis writes on: a mesh that is prepared here, or a flat grid.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use serde::{Deserialize, Serialize};

use crate::cli::machine::Need;
use crate::cli::session::Session;
use crate::error::{Error, Result};
use crate::exemplar::neighbor_table::NeighborTable;
use crate::exemplar::space::Space;
use crate::maps::vertex_map::{check_scale, varying};
use crate::neighborhood::{Neighborhood, window_width};
use crate::sites::grid::target::GridTarget;
use crate::sites::level::Sites;
use crate::sites::target::{MeshTarget, Target};
use crate::sites::vertices::cache;
use crate::sites::vertices::memory::bytes_to_prepare;
use crate::sites::vertices::surface::{self, Surface};
use crate::sites::vertices::surface_options::SurfaceOptions;
use crate::synthesis::memory;
use crate::synthesis::options::SynthesisOptions;

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

impl TargetArguments {
    /// Prepares the target for the neighbourhoods of an exemplar's table.
    pub fn prepare(
        &self,
        (space, table): (&Space, &NeighborTable),
        options: &SynthesisOptions,
        session: &Session,
    ) -> Result<Target> {
        let levels = options
            .levels
            .map_or(table.levels.len(), |levels| levels as usize);
        let exemplar = memory::exemplar_bytes(space, table);
        match (&self.mesh, self.grid) {
            (_, Some(grid)) => {
                if self.surface.texel.is_some() {
                    return Err(Error::option(
                        "texel",
                        "a flat grid",
                        "a mesh; on a grid a site is a texel",
                    ));
                }
                let grid = GridTarget {
                    toroidal: self.border == Border::Wrap,
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
                Ok(Target::Grid {
                    sites: grid.hierarchy(&neighborhoods)?,
                    mesh: grid.mesh(),
                    grid,
                })
            }
            (Some(path), None) => {
                let target = prepare_mesh(path, self, (table, exemplar), levels, session)?;
                check_density(&target.surface, self.surface.texel)?;
                Ok(Target::Vertices(target))
            }
            (None, None) => Err(Error::option("grid", "no target", "a mesh, or --grid WxH")),
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
) -> Result<MeshTarget> {
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
    let scale = varying(user.scale.as_deref());
    if let Some(scale) = scale {
        check_scale(scale, texel).map_err(|error| error.in_file(path))?;
    }
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
    Ok(MeshTarget {
        surface: Box::new(surface),
        origin: user.origin,
        scale: scale.map(<[f32]>::to_vec),
    })
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
