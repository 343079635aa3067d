//! `mesotex init`: a material and a mesh → a commented scene whose numbers fit both.
//!
//! | file | what it does |
//! | --- | --- |
//! | [`material`] | what the material is, how finely it is baked, how deep it is |
//! | [`fitted_mesh`] | how many vertices the mesh needs, and what a texel covers |
//! | [`relative`] | paths as the scene must write them |
//! | [`text`] | the scene |

mod fitted_mesh;
mod material;
mod relative;
mod text;

use std::io::Write;
use std::path::{Path, PathBuf};

use clap::Args;

use crate::cli::info::kind::MESHES;
use crate::cli::init::fitted_mesh::FittedMesh;
use crate::cli::init::material::Material;
use crate::cli::init::relative::relative_to;
use crate::cli::init::text::{Fitted, scene_text};
use crate::cli::outcome::Outcome;
use crate::cli::outputs::{Files, Product};
use crate::cli::session::{Common, Session};
use crate::cli::subcommand::Subcommand;
use crate::error::Result;
use crate::format::atomic;
use crate::format::mesh_formats::{companions, listed_extensions};
use crate::format::ours::Format;
use crate::mesh::reading;

/// Write a commented scene for a material and a mesh, with sizes, depth and texel that fit both.
///
/// Reads the material's maps and the mesh, and writes only the scene, which `mesotex run` accepts as it is.
#[derive(Clone, Debug, Args)]
#[command(after_help = "\
Examples:
  mesotex init --material Bricks075_2K-PNG --mesh bunny.obj -o bricks.toml
  mesotex init --material weave.sample --mesh bunny.obj -o weave.toml
  mesotex init --material capture/angles.csv --mesh scan.ply
Then:
  mesotex run bricks.toml --plan
  mesotex run bricks.toml --quality draft
  mesotex run bricks.toml")]
pub struct Arguments {
    /// A folder of texture maps or a material file (TOML), a sample NAME.sample, a measured data set that `import`
    /// reads, or a plain image.
    #[arg(long, value_name = "DIR|FILE")]
    pub material: PathBuf,
    /// The mesh.
    #[arg(long, value_name = "FILE", help = format!("The mesh: {}", listed_extensions()))]
    pub mesh: PathBuf,
    /// The scene to write. An existing file is not replaced.
    #[arg(short, long, value_name = "SCENE.toml", default_value = "scene.toml")]
    pub output: PathBuf,
    #[command(flatten)]
    pub common: Common,
}

impl Subcommand for Arguments {
    fn common(&self) -> &Common {
        &self.common
    }

    fn files(&self) -> Result<Files> {
        Ok(Files::default()
            .read([&self.material])
            .read_as(&MESHES, &self.mesh)
            .read(&companions(&self.mesh)?)
            .write("output", [&self.output], Product::File(Format::Scene)))
    }

    fn run(&self, session: &Session) -> Result<Outcome> {
        let _locks = self.files()?.claim()?;
        let progress = session.progress();
        let material = Material::read(&self.material, progress)?;
        let user = reading::read(&self.mesh, progress)?;
        let surface =
            FittedMesh::new(&user, material.sides()).map_err(|error| error.in_file(&self.mesh))?;
        let folder = self.output.parent().unwrap_or(Path::new(""));
        let fitted = Fitted {
            name: self.name(),
            material_path: relative_to(&self.material, folder)?,
            mesh_path: relative_to(&self.mesh, folder)?,
            material: &material,
            surface: &surface,
        };
        let text = scene_text(&fitted);
        atomic::write_file(&self.output, |sink| sink.write_all(text.as_bytes()))?;
        let scene = self.output.display();
        let outcome = Outcome::default()
            .line(material.describe())
            .line(surface.describe())
            .figure("name", fitted.name.as_str())
            .figure("vertices", surface.vertices)
            .figure("texel", surface.texel)
            .figure("repeats", surface.repeats);
        Ok(material
            .add_figures(outcome)
            .wrote(&self.output)
            .next(format!("mesotex run {scene} --plan")))
    }
}

impl Arguments {
    /// `MATERIAL-on-MESH`, of letters and digits.
    fn name(&self) -> String {
        let stem = |path: &Path| {
            let stem = path.file_stem().unwrap_or_default().to_string_lossy();
            let plain = stem.chars().map(|c| match c.is_alphanumeric() {
                true => c,
                false => '-',
            });
            plain.collect::<String>()
        };
        format!("{}-on-{}", stem(&self.material), stem(&self.mesh))
    }
}
