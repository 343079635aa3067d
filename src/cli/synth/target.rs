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
use crate::surface_map::{check_scale, varying};
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
    /// A prepared mesh.
    Surface(MeshTarget),
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

/// A prepared mesh, and what of its file the map keeps.
pub struct MeshTarget {
    surface: Box<Surface>,
    /// What its positions count from.
    origin: DVec3,
    /// Factor on the texel at each vertex; `None` for 1 everywhere.
    scale: Option<Vec<f32>>,
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
                let target = prepare_mesh(path, arguments, (table, exemplar), levels, session)?;
                check_density(&target.surface, arguments.surface.texel)?;
                Ok(Self::Surface(target))
            }
            (None, None) => Err(Error::option("grid", "no target", "a mesh, or --grid WxH")),
        }
    }

    /// The sites of all levels.
    pub fn sites(&self) -> &SiteHierarchy {
        match self {
            Self::Surface(target) => &target.surface.hierarchy,
            Self::Grid { sites, .. } => sites,
        }
    }

    /// The surface of level 0.
    pub fn mesh(&self) -> &TriangleMesh {
        match self {
            Self::Surface(target) => &target.surface.meshes[0],
            Self::Grid { mesh, .. } => mesh,
        }
    }

    /// What the positions of the surface count from.
    pub fn origin(&self) -> DVec3 {
        match self {
            Self::Surface(target) => target.origin,
            Self::Grid { .. } => DVec3::ZERO,
        }
    }

    /// Unit normals of the sites.
    pub fn normals(&self) -> Vec<Vec3> {
        match self {
            Self::Surface(target) => target.surface.normals[0].clone(),
            Self::Grid { mesh, .. } => vec![Vec3::Z; mesh.positions.len()],
        }
    }

    /// The orientation field.
    pub fn orientations(&self) -> Vec<Vec3> {
        match self {
            Self::Surface(target) => {
                let frames = target.surface.frames[0].iter();
                frames.map(|frame| frame.s).collect()
            }
            Self::Grid { mesh, .. } => vec![Vec3::X; mesh.positions.len()],
        }
    }

    /// Factor on the texel at each site; `None` for 1 everywhere.
    pub fn scale(&self) -> Option<&[f32]> {
        match self {
            Self::Surface(target) => target.scale.as_deref(),
            Self::Grid { .. } => None,
        }
    }

    /// Mesh units a texel covers where the scale is 1.
    pub fn texel(&self) -> f64 {
        match self {
            Self::Surface(target) => target.surface.texel,
            Self::Grid { .. } => 1.0,
        }
    }

    /// Every edge i < j, with the place of j seen from i in texels.
    pub fn edges(&self) -> Vec<SiteEdge> {
        match self {
            Self::Surface(target) => target.edges(),
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

impl MeshTarget {
    /// Every edge of the mesh, measured in texels of the vertex it is seen from.
    fn edges(&self) -> Vec<SiteEdge> {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::{TexCoord, TexelGrid};
    use crate::mesh::reading::UserMesh;
    use crate::mesh::shapes;
    use crate::progress::Progress;
    use crate::synthesis::quality::coherence::Coherence;

    const TEXEL: f64 = 0.5;
    const SAMPLE: TexelGrid = TexelGrid {
        width: 8,
        height: 8,
        tileable: true,
    };

    /// A plane cut down its middle, of scale 1 left and 2 right of the cut.
    fn plane_of_two_scales() -> MeshTarget {
        let (mut mesh, mut right) = (shapes::grid(6, 6, 0.5), shapes::grid(6, 6, 0.5));
        let half = mesh.positions.len();
        mesh.positions
            .extend(right.positions.iter().map(|p| *p + 3.0 * Vec3::X));
        right
            .triangles
            .iter_mut()
            .flatten()
            .for_each(|v| *v += half as u32);
        mesh.triangles.extend(right.triangles);
        let scale: Vec<f32> = (0..2 * half)
            .map(|v| if v < half { 1.0 } else { 2.0 })
            .collect();
        let user = UserMesh {
            from_file: (0..2 * half as u32).collect(),
            orientation: Some(vec![Vec3::X; 2 * half]),
            scale: Some(scale.clone()),
            mesh,
            ..UserMesh::default()
        };
        let options = SurfaceOptions {
            levels: 1,
            texel: Some(TEXEL),
            neighborhood: 3,
            ..SurfaceOptions::default()
        };
        MeshTarget {
            surface: Box::new(surface::prepare(&user, &options, None, Progress::silent()).unwrap()),
            origin: DVec3::ZERO,
            scale: Some(scale),
        }
    }

    /// Coordinates that run over the surface at one texel a `TEXEL` times the scale.
    fn copied(target: &MeshTarget) -> Vec<TexCoord> {
        let positions = target.surface.meshes[0].positions.iter();
        let scale = target.scale.as_ref().unwrap();
        let coord = |(at, scale): (&Vec3, &f32)| TexCoord {
            s: (at.x / (TEXEL as f32 * scale)).rem_euclid(8.0),
            t: (at.y / (TEXEL as f32 * scale)).rem_euclid(8.0),
        };
        positions.zip(scale).map(coord).collect()
    }

    #[test]
    fn a_copy_at_the_pace_of_each_half_does_not_drift() {
        let mut target = plane_of_two_scales();
        let coords = copied(&target);
        let found = Coherence::measure(SAMPLE, &coords, &target.edges());
        assert_eq!((found.half, found.one), (1.0, 1.0));
        for (row, expected) in found.drift.iter().zip([[1.0, 0.0], [0.0, 1.0]]) {
            for (found, expected) in row.iter().zip(expected) {
                assert!((found - expected).abs() < 1e-5, "{row:?}");
            }
        }
        // At one pace everywhere, the right half runs at half of it: 0.75 over the edges of both.
        target.scale = None;
        let found = Coherence::measure(SAMPLE, &coords, &target.edges());
        assert!((found.drift[0][0] - 0.75).abs() < 1e-5, "{found:?}");
        assert!((found.drift[1][1] - 0.75).abs() < 1e-5, "{found:?}");
    }
}
