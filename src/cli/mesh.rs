//! `mesotex mesh`: clean a mesh, retile it, give it an orientation field, measure it.

mod look;
mod oriented;
mod report;

use std::path::PathBuf;

use clap::Args;
use serde_json::Value;

use self::look::{draw, picture_files, picture_names};
use self::oriented::Oriented;
use self::report::{carried_outcome, describe_levels, warn_of_count, warn_of_scales};
pub use self::report::{read_outcome, with_shape};
use crate::cli::info::kind::MESHES;
use crate::cli::machine::{self, Need};
use crate::cli::outcome::Outcome;
use crate::cli::outputs::{Files, Product};
use crate::cli::session::{Common, Session};
use crate::cli::subcommand::Subcommand;
use crate::error::{Error, Result};
use crate::format::json as json_file;
use crate::format::mesh_formats::{companions, listed_extensions};
use crate::format::ours::Format;
use crate::mesh::quality::hausdorff;
use crate::mesh::reading::{CleaningOptions, UserMesh, read_with};
use crate::mesh::retile::carrying::retile_with_numbers;
use crate::mesh::writing;
use crate::sites::vertices::cache;
use crate::sites::vertices::memory;
use crate::sites::vertices::surface::prepare;
use crate::sites::vertices::surface_options::SurfaceOptions;

const EXAMPLES: &str = "Examples:
  mesotex mesh bunny.obj -o bunny.ply                      clean and convert
  mesotex mesh bunny.obj -o even.ply --vertices 250000     retile to 250,000 even vertices
  mesotex mesh bunny.obj -o guided.ply --orient --direction 0,1,0
                                                           add a field that follows the y axis
  mesotex mesh bunny.obj -o even.ply --vertices 20000 --report mesh.json --pictures look
                                                           measure it and look at it
  mesotex mesh scan.stl -o scan.ply --strict               refuse a scan that needs repair";

/// What is done to a mesh.
#[derive(Clone, Debug, PartialEq, Args)]
pub struct MeshOptions {
    /// Retile to this number of vertices, spread evenly over the same surface (100 to 20,000,000). [default: the mesh's
    /// own vertices]
    #[arg(long)]
    pub vertices: Option<usize>,
    /// Refuse a mesh that needs repair.
    #[arg(long)]
    pub strict: bool,
    /// Remove components smaller than this fraction of the mesh, by the diagonals of bounding boxes.
    #[arg(long, default_value_t = 0.0)]
    pub specks: f64,
    /// Write the orientation field into the mesh (PLY: sx sy sz), for viewing or as a guide.
    #[arg(long)]
    pub orient: bool,
    /// Write measurements as JSON: evenness, distance to the input, field, singularities, samples. The prepared
    /// surface is kept beside the output, where synth finds it.
    #[arg(long, value_name = "FILE.json")]
    pub report: Option<PathBuf>,
    /// Draw the field with its singularities, the levels and the distortion of patches into this
    /// folder, as PNG and coloured PLY.
    #[arg(long, value_name = "DIR")]
    pub pictures: Option<PathBuf>,
    /// Levels of the mesh pyramid that are measured and drawn.
    #[arg(long, default_value_t = SurfaceOptions::default().levels)]
    pub levels: u32,
}

impl MeshOptions {
    /// Checks every field.
    pub fn validate(&self) -> Result<()> {
        if let Some(vertices) = self.vertices {
            if !(100..=20_000_000).contains(&vertices) {
                return Err(Error::option(
                    "vertices",
                    vertices.to_string(),
                    "100 to 20,000,000",
                ));
            }
            check_memory(vertices)?;
        }
        if !(0.0..1.0).contains(&self.specks) {
            return Err(Error::option(
                "specks",
                self.specks.to_string(),
                "a fraction, 0 to below 1",
            ));
        }
        Ok(())
    }
}

/// Refuses more vertices than this machine has memory for, where that is known.
fn check_memory(vertices: usize) -> Result<()> {
    let available = machine::available_memory().map_or(u64::MAX, |size| size.0);
    let need = Need {
        bytes: memory::bytes_to_retile(vertices),
        work: format!("{vertices} vertices"),
        option: "vertices",
        advice: format!("{} vertices", memory::vertices_retiled_in(available)),
    };
    need.check()
}

/// Refuses a surface that this machine has too little memory to prepare.
fn check_field_memory(user: &UserMesh, options: &SurfaceOptions) -> Result<()> {
    let texel = options.texel_on(&user.mesh)?;
    let need = Need {
        bytes: memory::bytes_to_prepare(user, options, texel),
        work: format!(
            "{} vertices at a texel of {texel}",
            user.mesh.positions.len()
        ),
        option: "texel",
        advice: "a smaller --texel, or fewer --vertices".into(),
    };
    need.check()
}

/// Clean a mesh, retile it evenly, give it an orientation field.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// The mesh.
    #[arg(help = format!("The mesh: {}, each also with .gz", listed_extensions()))]
    pub input: PathBuf,
    /// The mesh to write.
    #[arg(long, short, help = format!("Where to write it: {}", writing::listed_extensions()))]
    pub output: PathBuf,
    /// What is done.
    #[command(flatten)]
    pub options: MeshOptions,
    /// How field, levels and patches are prepared.
    #[command(flatten)]
    pub surface: SurfaceOptions,
    /// Options of every command.
    #[command(flatten)]
    pub common: Common,
}

impl Subcommand for Arguments {
    fn common(&self) -> &Common {
        &self.common
    }

    fn check(&self) -> Result<()> {
        self.options.validate()?;
        self.surface_options(0).validate()?;
        writing::check_name(&self.output)?;
        let as_ply = self
            .output
            .extension()
            .is_some_and(|e| e.eq_ignore_ascii_case("ply"));
        if self.options.orient && !as_ply {
            return Err(Error::option(
                "orient",
                self.output.display().to_string(),
                "an output that ends in .ply",
            ));
        }
        Ok(())
    }

    fn files(&self) -> Result<Files> {
        let mesh = Product::File(Format::Mesh);
        let mut files = Files::default()
            .read_as(&MESHES, &self.input)
            .read(&companions(&self.input)?)
            .read(&self.surface.guide)
            .read(&self.surface.keys)
            .write("output", [&self.output], mesh)
            .write("report", &self.options.report, Product::File(Format::Json));
        for folder in self
            .options
            .pictures
            .iter()
            .filter(|folder| folder.is_dir())
        {
            for name in picture_names(self.options.levels) {
                let [ply, png] = picture_files(folder, &name);
                files = files.write("pictures", [&ply], mesh).write(
                    "pictures",
                    [&png],
                    Product::File(Format::Picture),
                );
            }
        }
        Ok(files)
    }

    fn run(&self, session: &Session) -> Result<Outcome> {
        // Claim the outputs.
        let surface_options = self.surface_options(session.seed());
        let _locks = self.files()?.claim()?;
        // Read, clean and retile.
        let cleaning = CleaningOptions {
            strict: self.options.strict,
            specks: self.options.specks,
        };
        let read = read_with(&self.input, &cleaning, session.progress())?;
        warn_of_scales(session, &read.mesh);
        let mut outcome = read_outcome(&self.input, &read);
        let mut user = match self.options.vertices {
            None => read,
            Some(vertices) => {
                let (user, more) = self.retiled(session, outcome, &read, vertices)?;
                outcome = more;
                user
            }
        };
        outcome = with_shape(outcome, &user);
        // Find the field where something needs it.
        if self.wants_field() {
            check_field_memory(&user, &surface_options)?;
            outcome = self.with_field(session, outcome, &mut user, &surface_options)?;
        }
        // Write the mesh and the report.
        writing::write_user(&self.output, &user)?;
        if let Some(report) = &self.options.report {
            json_file::write(report, &Value::Object(outcome.figures.clone()))?;
            outcome = outcome.wrote(report);
        }
        let next = format!(
            "mesotex synth X.space.npz X.knn.npz {} -o Y.map.ply",
            self.output.display()
        );
        Ok(outcome.wrote(&self.output).next(next))
    }
}

impl Arguments {
    fn surface_options(&self, seed: u64) -> SurfaceOptions {
        SurfaceOptions {
            levels: self.options.levels,
            seed,
            ..self.surface.clone()
        }
    }

    /// Whether the surface is measured or drawn.
    pub fn is_measured(&self) -> bool {
        self.options.report.is_some() || self.options.pictures.is_some()
    }

    /// Whether an orientation field is made.
    pub fn wants_field(&self) -> bool {
        self.options.orient || self.is_measured()
    }

    /// The mesh with this many even vertices, and how near it came to that.
    fn retiled(
        &self,
        session: &Session,
        outcome: Outcome,
        read: &UserMesh,
        vertices: usize,
    ) -> Result<(UserMesh, Outcome)> {
        let crease = self.surface.crease.to_radians();
        let (user, carried) = retile_with_numbers(read, vertices, crease, session.progress())?;
        let distance = hausdorff(&read.mesh, &user.mesh) / read.mesh.diagonal();
        warn_of_count(session, user.mesh.positions.len(), vertices);
        let outcome = outcome
            .line(format!(
                "distance to the input {:.4} % of its diagonal",
                100.0 * distance
            ))
            .figure("hausdorff_over_diagonal", distance);
        Ok((user, carried_outcome(session, outcome, carried)))
    }

    fn with_field(
        &self,
        session: &Session,
        outcome: Outcome,
        user: &mut UserMesh,
        options: &SurfaceOptions,
    ) -> Result<Outcome> {
        let oriented = Oriented::new(user, options, session.progress())?;
        let mut outcome = oriented.describe(outcome, user);
        if self.is_measured() {
            let folder = cache::folder_of(&self.output);
            let surface = prepare(user, options, Some(&folder), session.progress())?;
            outcome = describe_levels(outcome, &surface);
            if let Some(folder) = &self.options.pictures {
                outcome = draw(outcome, folder, user, &oriented, &surface)?;
            }
        }
        if self.options.orient {
            user.orientation = Some(oriented.directions());
        }
        Ok(outcome)
    }
}
