//! What synthesis writes on, as it is asked for: a mesh, its atlas or its faces, or a flat grid.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use serde::Serialize;

use crate::cli::session::Session;
use crate::cli::synth::controls;
use crate::cli::synth::physical_scale::{MeshUnit, PhysicalTexel};
use crate::cli::synth::prepared::{MeshTarget, PlannedSites, Prepared, Windows, check_memory};
use crate::error::{Error, Result};
use crate::exemplar::neighbor_table::NeighborTable;
use crate::exemplar::space::Space;
use crate::format::mesh_formats::listed_names;
use crate::mesh::reading::UserMesh;
use crate::neighborhood::{Neighborhood, window_width};
use crate::sites::atlas::options::AtlasOptions;
use crate::sites::faces::plan::FaceOptions;
use crate::sites::grid::window::SiteGrid;
use crate::sites::target::{Target, TargetSites};
use crate::sites::vertices::circles::RoundOptions;
use crate::sites::vertices::surface_options::{SurfaceOptions, texel_on};
use crate::synthesis::check::Plan;
use crate::synthesis::level_choice::LevelChoice;
use crate::synthesis::memory;
use crate::synthesis::method::MethodSites;
use crate::synthesis::options::{Method, SynthesisOptions};

/// What happens at a flat grid's border.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, ValueEnum)]
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
    /// A flat grid, of the size of --grid
    Grid,
    /// The texels of a texture atlas over the mesh
    Atlas,
    /// The faces of a subdivided mesh; implied by --method choosy
    Faces,
}

/// The target and how it is prepared.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Target")]
pub struct TargetArguments {
    /// The mesh
    #[arg(conflicts_with = "grid", help = format!("The mesh: {}", listed_names()))]
    pub mesh: Option<PathBuf>,
    /// Synthesize on a flat grid of WxH sites instead of a mesh
    #[arg(long, value_name = "WxH")]
    pub grid: Option<SiteGrid>,
    /// Sites of the map; with --grid always grid
    #[arg(long, value_enum)]
    pub onto: Option<Onto>,
    /// What is beyond the grid's border
    #[arg(long, value_enum, default_value_t = Border::Wrap)]
    pub border: Border,
    /// The unit of the mesh's coordinates: texels get the physical size that the sample states, in place of --texel
    #[arg(long, value_enum, value_name = "UNIT", conflicts_with = "texel")]
    pub mesh_unit: Option<MeshUnit>,
    #[command(flatten)]
    pub surface: SurfaceOptions,
    #[command(flatten)]
    pub atlas: AtlasOptions,
    #[command(flatten)]
    pub faces: FaceOptions,
}

impl TargetArguments {
    /// Refuses sites that the target does not have.
    pub fn check(&self, method: Method) -> Result<()> {
        if self.is_atlas() && method.is_round() {
            let name = method.name();
            return Err(Error::option(
                "onto",
                format!("atlas with --method {name}, whose neighbourhoods are round"),
                "vertices or grid, or another --method",
            ));
        }
        if self.is_onto_faces(method) {
            return self.check_faces(method);
        }
        match (self.onto, self.grid) {
            (Some(Onto::Grid), None) => Err(Error::option("onto", "grid", "--grid WxH as well")),
            (Some(Onto::Vertices), Some(_)) => Err(Error::option(
                "onto",
                "vertices, but --grid has none",
                "a mesh, or --onto grid",
            )),
            (Some(Onto::Atlas), Some(_)) => Err(Error::option(
                "onto",
                "atlas, but --grid has none",
                "a mesh, or --onto grid",
            )),
            (Some(Onto::Atlas), None) => self.guided_atlas().validate(),
            _ => Ok(()),
        }
    }

    /// Whether sites are faces.
    pub fn is_onto_faces(&self, method: Method) -> bool {
        method.writes_faces() || self.onto == Some(Onto::Faces)
    }

    /// Refuses faces for methods of other sites, and other sites for methods of faces.
    fn check_faces(&self, method: Method) -> Result<()> {
        let name = method.name();
        if !method.writes_faces() {
            let found = format!("faces with --method {name}");
            return Err(Error::option(
                "onto",
                found,
                "--method choosy, or other sites",
            ));
        }
        let others = "a mesh and --onto faces, or another --method";
        match (self.onto, self.grid) {
            (_, Some(_)) => {
                let found = format!("given for --method {name}");
                Err(Error::option("grid", found, others))
            }
            (Some(Onto::Faces) | None, None) => Ok(()),
            (Some(_), None) => Err(Error::option(
                "onto",
                format!("other sites than faces with --method {name}"),
                others,
            )),
        }
    }

    /// What a message calls the target.
    pub fn named(&self, method: Method) -> String {
        match (self.grid, self.onto) {
            (Some(_), _) => "a flat grid".into(),
            (None, Some(Onto::Atlas)) => "--onto atlas".into(),
            (None, _) => format!("--method {}", method.name()),
        }
    }

    /// The size of a texel where the mesh's unit is given; refused where the space does not say it.
    pub fn physical_texel(&self, space: &Space) -> Result<Option<PhysicalTexel>> {
        let size = |unit| PhysicalTexel::new(unit, space.texel_mm);
        self.mesh_unit.map(size).transpose()
    }

    /// The same target with a texel of that size, if there is one.
    pub fn with_texel(&self, physical: Option<PhysicalTexel>) -> Self {
        let mut target = self.clone();
        if let Some(physical) = physical {
            target.surface.texel = Some(physical.mesh_units());
        }
        target
    }

    /// Reads the mesh, where the target is one.
    pub fn read_mesh(&self, session: &Session) -> Result<Option<UserMesh>> {
        let read = |path: &PathBuf| crate::mesh::reading::read(path, session.progress());
        self.mesh.as_ref().map(read).transpose()
    }

    /// The levels on which a mesh's vertices are synthesized, where none are asked for and the method has them chosen.
    pub fn choose_levels(
        &self,
        (space, table): (&Space, &NeighborTable),
        user: Option<&UserMesh>,
        options: &SynthesisOptions,
    ) -> Result<Option<LevelChoice>> {
        let chooses = options.method.description().chooses_levels;
        let Some(user) = user.filter(|_| chooses && !self.is_atlas()) else {
            return Ok(None);
        };
        if options.levels.is_some() {
            return Ok(None);
        }
        let vertices = user.mesh.positions.len();
        // A texel wider than an edge leaves the windows fewer texels than there are vertices.
        let texel = texel_on(&user.mesh, self.surface.texel)?;
        let edge = texel_on(&user.mesh, None)?;
        let texels = vertices as f64 * (edge / texel).powi(2);
        let sites = vertices.min(texels as usize);
        Ok(Some(LevelChoice::new(space, table, sites)))
    }

    /// Prepares the target for the neighbourhoods of a method; `is_measured` says whether all figures are wanted.
    pub fn prepare(
        &self,
        user: Option<UserMesh>,
        (space, table): (&Space, &NeighborTable),
        (options, plan): (&SynthesisOptions, &Plan),
        is_measured: bool,
        session: &Session,
    ) -> Result<Prepared> {
        // Find which neighbourhoods the sites have.
        let sites = PlannedSites {
            windows: Windows::new(table, plan, options),
            round: self.round_options(options, plan, session),
            is_measured,
        };
        // Count the memory that is needed beside the target.
        let most_sites = self.most_sites(user.as_ref());
        let exemplar = memory::exemplar_bytes((space, table), most_sites, options);
        let mesh = self.mesh.as_ref().zip(user.as_ref());
        let mesh = mesh.map(|(path, user)| MeshTarget {
            path,
            user,
            exemplar,
            session,
        });
        let mut prepared = self.prepare_sites(mesh, &sites, exemplar, session)?;
        // Read the controls of the surface.
        let method = options.method.description();
        if method.follows_controls {
            let keys = self.surface.keys.as_deref();
            let surface = &prepared.target.surface;
            prepared.target.controls =
                controls::of_target((surface, method.name), user, keys, session)?;
        }
        Ok(prepared)
    }

    /// How a mesh is prepared for round neighbourhoods, if the method has them.
    fn round_options(
        &self,
        options: &SynthesisOptions,
        plan: &Plan,
        session: &Session,
    ) -> Option<RoundOptions> {
        match options.method.description().sites {
            MethodSites::Circles(rings) => Some(RoundOptions {
                rings: rings(options),
                levels: plan.levels as u32,
                texel: self.surface.texel,
                guides: self.surface.guides(),
                seed: session.seed(),
            }),
            MethodSites::Windows(_) | MethodSites::Faces => None,
        }
    }

    /// Prepares a grid, an atlas or a mesh; the sites that a map is measured on too where they are others.
    fn prepare_sites(
        &self,
        mesh: Option<MeshTarget<'_>>,
        sites: &PlannedSites,
        exemplar: u64,
        session: &Session,
    ) -> Result<Prepared> {
        if self.grid.is_some() {
            return Ok(self.grid_target(sites, exemplar)?.into());
        }
        let Some(mesh) = mesh else {
            return Err(Error::option("grid", "no target", "a mesh, or --grid WxH"));
        };
        let (own, others) = (&sites.windows.own, sites.others_measured());
        if self.is_atlas() {
            let mut target = mesh.prepare_atlas(&self.atlas_options(own, session))?;
            if let Some(others) = others {
                let measured = mesh.prepare_atlas(&self.atlas_options(others, session))?;
                target.measured = Some(measured.sites);
            }
            return Ok(target.into());
        }
        let mut prepared = match &sites.round {
            Some(round) => mesh.prepare_round(round)?,
            None => mesh.prepare(&self.surface_options(own, session))?,
        };
        if let Some(others) = others {
            let measured = mesh.measured_sites(&self.surface_options(others, session))?;
            prepared.target.measured = Some(measured);
        }
        Ok(prepared)
    }

    /// Sites of level 0 at the most.
    fn most_sites(&self, user: Option<&UserMesh>) -> u64 {
        match (self.grid, user) {
            (Some(grid), _) => u64::from(grid.width) * u64::from(grid.height),
            (None, _) if self.is_atlas() => u64::from(self.atlas.resolution).pow(2),
            (None, user) => user.map_or(0, |user| user.mesh.positions.len() as u64),
        }
    }

    /// Whether sites are texels of an atlas.
    pub fn is_atlas(&self) -> bool {
        self.onto == Some(Onto::Atlas)
    }

    /// The options of an atlas with what guides its field.
    fn guided_atlas(&self) -> AtlasOptions {
        AtlasOptions {
            guides: self.surface.guides(),
            ..self.atlas.clone()
        }
    }

    /// How an atlas is prepared for square windows.
    fn atlas_options(&self, neighborhoods: &[Neighborhood], session: &Session) -> AtlasOptions {
        AtlasOptions {
            seed: session.seed(),
            ..self.guided_atlas().with_neighborhoods(neighborhoods)
        }
    }

    /// A flat grid, round neighbourhoods on it if asked for.
    fn grid_target(&self, sites: &PlannedSites, exemplar: u64) -> Result<Target> {
        let grid = self.checked_grid(exemplar)?;
        let windows = &sites.windows;
        let width = window_width(&windows.measured.offsets);
        let measured = Neighborhood::square(width, 0);
        if let Some(round) = &sites.round {
            return Target::round_grid(grid, (round.rings, round.levels as usize), measured);
        }
        let mut target = Target::grid(grid, &windows.own)?;
        if windows.are_others_measured() {
            target.measured = Some(TargetSites::Grid(grid.hierarchy(&[measured])?));
        }
        Ok(target)
    }

    /// How a mesh is prepared for square windows.
    fn surface_options(&self, neighborhoods: &[Neighborhood], session: &Session) -> SurfaceOptions {
        SurfaceOptions {
            seed: session.seed(),
            ..self.surface.clone().with_neighborhoods(neighborhoods)
        }
    }

    /// The grid that was asked for, if there is memory for it.
    fn checked_grid(&self, exemplar: u64) -> Result<SiteGrid> {
        let Some(grid) = self.grid else {
            return Err(Error::option("grid", "none", "WxH"));
        };
        check_memory(
            "grid",
            format!("{}x{} sites", grid.width, grid.height),
            exemplar + memory::grid_bytes(grid.width, grid.height),
            "a smaller --grid",
        )?;
        Ok(SiteGrid {
            toroidal: self.border == Border::Wrap,
            ..grid
        })
    }
}
