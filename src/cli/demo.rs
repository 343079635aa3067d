//! `mesotex demo`: the whole chain on the built-in material and mesh.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use clap::Args;

use crate::cli::endings::check_folder;
use crate::cli::outcome::Outcome;
use crate::cli::run;
use crate::cli::run::quality::Quality;
use crate::cli::session::{Common, Session};
use crate::cli::subcommand::{CHAIN_IF_INTERRUPTED, Subcommand};
use crate::error::{Error, Result};
use crate::format::atomic;
use crate::mesh::builtin::kettlebell;
use crate::mesh::writing;

/// The scene that is run; it is also the example of a scene file.
const SCENE: &str = include_str!("demo.toml");
/// Vertices of the built-in mesh, before it is made even.
const VERTICES: usize = 60_000;

/// Run everything on the built-in material and mesh: bake, textons, synthesis, a light sweep.
///
/// Writes a scene file and runs it. A second run skips finished stages.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  mesotex demo
  mesotex demo -o somewhere --seed 3")]
pub struct Arguments {
    /// The folder to fill.
    #[arg(short, long, default_value = "demo")]
    pub output: PathBuf,
    #[command(flatten)]
    pub common: Common,
}

impl Subcommand for Arguments {
    fn common(&self) -> &Common {
        &self.common
    }

    /// Refuses the name of a file.
    fn check(&self) -> Result<()> {
        check_folder("output", &self.output, None)
    }

    fn if_interrupted(&self) -> &'static str {
        CHAIN_IF_INTERRUPTED
    }

    fn run(&self, session: &Session) -> Result<Outcome> {
        fs::create_dir_all(&self.output).map_err(Error::io(&self.output, "create"))?;
        let scene = self.output.join("scene.toml");
        write_if_missing(&scene)?;
        let mesh = self.output.join("kettlebell.ply");
        if !mesh.exists() {
            writing::write_mesh(&mesh, &kettlebell(VERTICES))?;
        }
        let scene_run = run::Arguments {
            scene: scene.clone(),
            fresh: false,
            dry_run: false,
            plan: false,
            no_pages: false,
            quality: Quality::Final,
            until: None,
            only: None,
            common: self.common.clone(),
        };
        Ok(scene_run
            .run(session)?
            .next(format!("edit {0}, then: mesotex run {0}", scene.display())))
    }
}

/// Writes the scene, unless the user has one there and may have changed it.
fn write_if_missing(scene: &Path) -> Result<()> {
    if scene.exists() {
        return Ok(());
    }
    atomic::write_file(scene, |sink| sink.write_all(SCENE.as_bytes()))
}
