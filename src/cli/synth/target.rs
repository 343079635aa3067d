//! What synthesis writes on: a mesh that is prepared here, or a flat grid.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use glam::Vec3;
use serde::{Deserialize, Serialize};

use crate::cli::session::Session;
use crate::error::{Error, Result};
use crate::exemplar::neighbor_table::{NeighborTable, Neighborhood};
use crate::mesh::hierarchy::SiteHierarchy;
use crate::mesh::triangle_mesh::TriangleMesh;
use crate::synthesis::check::window_width;
use crate::synthesis::grid_target::GridTarget;
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
}

/// A target ready for synthesis.
pub enum Target {
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
    /// Prepares the target for a table's neighbourhoods.
    pub fn prepare(
        arguments: &TargetArguments,
        table: &NeighborTable,
        options: &SynthesisOptions,
        session: &Session,
    ) -> Result<Self> {
        let levels = options
            .levels
            .map_or(table.levels.len(), |levels| levels as usize);
        match (&arguments.mesh, arguments.grid) {
            (_, Some(grid)) => {
                let grid = GridTarget {
                    toroidal: arguments.border == Border::Wrap,
                    ..grid
                };
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
            _ => Err(Error::option("grid", "no target", "a mesh, or --grid WxH")),
        }
    }

    /// The sites of all levels.
    pub fn sites(&self) -> &SiteHierarchy {
        match self {
            Self::Grid { sites, .. } => sites,
        }
    }

    /// The surface of level 0.
    pub fn mesh(&self) -> &TriangleMesh {
        match self {
            Self::Grid { mesh, .. } => mesh,
        }
    }

    /// Unit normals of the sites.
    pub fn normals(&self) -> Vec<Vec3> {
        match self {
            Self::Grid { mesh, .. } => vec![Vec3::Z; mesh.positions.len()],
        }
    }

    /// The orientation field.
    pub fn orientations(&self) -> Vec<Vec3> {
        match self {
            Self::Grid { mesh, .. } => vec![Vec3::X; mesh.positions.len()],
        }
    }

    /// Mesh units a texel covers.
    pub fn texel(&self) -> f64 {
        match self {
            Self::Grid { .. } => 1.0,
        }
    }

    /// Every edge i < j, with the place of j seen from i in texels.
    pub fn edges(&self) -> Vec<SiteEdge> {
        match self {
            Self::Grid { grid, .. } => grid.edges(),
        }
    }
}
