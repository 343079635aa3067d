//! `mesotex mesh`: clean a mesh, retile it, see how it stands.

use std::path::{Path, PathBuf};

use clap::Args;
use serde::{Deserialize, Serialize};
use serde_json::json;

use crate::cli::outcome::Outcome;
use crate::cli::session::{Common, Session};
use crate::error::{Error, Result};
use crate::mesh::reading::{CleaningOptions, UserMesh, read_with};
use crate::mesh::retile::retile;
use crate::mesh::surface::check_crease;
use crate::mesh::topology::Topology;
use crate::mesh::triangle_mesh::TriangleMesh;
use crate::mesh::writing;

const EXAMPLES: &str = "Examples:
  mesotex mesh bunny.obj -o bunny.ply                      clean and convert
  mesotex mesh bunny.obj -o even.ply --vertices 250000     retile to 250,000 even vertices
  mesotex mesh scan.stl -o scan.ply --strict               refuse a scan that needs repair";

/// What is done to a mesh.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Args)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct MeshOptions {
    /// Retile to so many vertices, spread evenly over the same surface (100 to 20,000,000).
    /// Default: the mesh's own vertices.
    #[arg(long)]
    pub vertices: Option<usize>,
    /// Edges whose triangles turn by more than so many degrees are creases: retiling keeps them.
    #[arg(long, default_value_t = MeshOptions::default().crease)]
    pub crease: f64,
    /// Refuse a mesh that needs repair.
    #[arg(long)]
    pub strict: bool,
    /// Drop components smaller than this fraction of the mesh, by the diagonals of their boxes.
    #[arg(long, default_value_t = MeshOptions::default().specks)]
    pub specks: f64,
}

impl Default for MeshOptions {
    fn default() -> Self {
        Self {
            vertices: None,
            crease: 40.0,
            strict: false,
            specks: 0.0,
        }
    }
}

impl MeshOptions {
    /// Checks every field.
    pub fn validate(&self) -> Result<()> {
        if let Some(vertices) = self.vertices
            && !(100..=20_000_000).contains(&vertices)
        {
            return Err(Error::option(
                "vertices",
                vertices.to_string(),
                "100 to 20,000,000",
            ));
        }
        if !(0.0..1.0).contains(&self.specks) {
            return Err(Error::option(
                "specks",
                self.specks.to_string(),
                "a fraction, 0 to below 1",
            ));
        }
        check_crease(self.crease)
    }
}

/// Clean a mesh and retile it evenly.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// The mesh: .obj, .ply, .stl, .off, .glb or .gltf, each also with .gz.
    pub input: PathBuf,
    /// Where to write it: .ply, .obj or .glb.
    #[arg(long, short)]
    pub output: PathBuf,
    #[command(flatten)]
    pub options: MeshOptions,
    #[command(flatten)]
    pub common: Common,
}

impl Arguments {
    /// Runs the command.
    pub fn run(&self, session: &Session) -> Result<Outcome> {
        self.options.validate()?;
        writing::check_name(&self.output)?;
        let _lock = session.claim(&self.output, &[&self.input])?;
        let cleaning = CleaningOptions {
            strict: self.options.strict,
            specks: self.options.specks,
        };
        let user = read_with(&self.input, &cleaning)?;
        let outcome = read_outcome(&self.input, &user);
        match self.options.vertices {
            None => {
                writing::write_user(&self.output, &user)?;
                Ok(self.finish(outcome, &user.mesh))
            }
            Some(vertices) => {
                let crease = self.options.crease.to_radians();
                let even = retile(&user.mesh, vertices, crease, session.progress())?;
                warn_of_count(session, even.positions.len(), vertices);
                writing::write_mesh(&self.output, &even)?;
                Ok(self.finish(outcome, &even))
            }
        }
    }

    fn finish(&self, outcome: Outcome, mesh: &TriangleMesh) -> Outcome {
        with_shape(outcome, mesh).wrote(&self.output).next(format!(
            "mesotex synth X.space.npz X.knn.npz {} -o Y.map.ply",
            self.output.display()
        ))
    }
}

/// Adds a mesh's size and shape to a report.
pub fn with_shape(outcome: Outcome, mesh: &TriangleMesh) -> Outcome {
    let shape = Topology::new(&mesh.triangles).shape(mesh);
    let texel = (mesh.area() / mesh.referenced_count() as f64).sqrt();
    outcome
        .line(format!(
            "{} vertices, {} triangles, {} components, {} boundaries, Euler characteristic {}",
            mesh.positions.len(),
            mesh.triangles.len(),
            shape.components,
            shape.boundaries,
            shape.euler_characteristic
        ))
        .line(format!("area {:.6}, default texel {texel:.6}", mesh.area()))
        .figure("vertices", mesh.positions.len())
        .figure("triangles", mesh.triangles.len())
        .figure("components", shape.components)
        .figure("boundaries", shape.boundaries)
        .figure("euler_characteristic", shape.euler_characteristic)
        .figure("area", mesh.area())
        .figure("texel", texel)
}

/// Begins a report: what was read, and what was repaired.
pub fn read_outcome(input: &Path, user: &UserMesh) -> Outcome {
    let mut outcome = Outcome::default().line(format!(
        "read {}: {} vertices, {} triangles",
        input.display(),
        user.from_file.len(),
        user.mesh.triangles.len()
    ));
    for line in user.report.lines() {
        outcome = outcome.line(format!("repair: {line}"));
    }
    outcome.figure("repairs", json!(user.report))
}

fn warn_of_count(session: &Session, found: usize, wanted: usize) {
    if found.abs_diff(wanted) * 50 > wanted {
        session.progress().warn(format!(
            "{found} vertices instead of {wanted}: boundaries, creases or many small parts leave no fewer"
        ));
    }
}
