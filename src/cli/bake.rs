//! `mesotex bake`: a material, from maps or built in, to a sample folder.

use std::path::PathBuf;
use std::time::Instant;

use clap::Args;

use crate::btf::bake::material::Material;
use crate::btf::bake::presets::Preset;
use crate::btf::bake::{BakeOptions, Baked, bake};
use crate::cli::outcome::Outcome;
use crate::cli::session::{Common, Session};
use crate::error::{Error, Result};

/// Ray-trace a BTF from height, colour and roughness.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  mesotex bake --preset weave --size 64 -o weave.sample
  mesotex bake --preset cobbles --size 128 --views bonn81 --lights bonn81 -o cobbles.sample
  mesotex bake bark.toml --size 128 --views fibonacci:50 --lights fibonacci:50 -o bark.sample")]
pub struct Arguments {
    /// The sample folder to write, as bark.sample.
    #[arg(short, long)]
    pub output: PathBuf,
    /// A built-in procedural material.
    #[arg(long, value_enum)]
    pub preset: Option<Preset>,
    /// Texels along the longer side.
    #[arg(long, default_value_t = 128)]
    pub size: u32,
    #[command(flatten)]
    pub options: BakeOptions,
    #[command(flatten)]
    pub common: Common,
}

impl Arguments {
    /// Runs the command.
    pub fn run(&self, session: &Session) -> Result<Outcome> {
        let _lock = session.claim(&self.output, &[])?;
        let options = BakeOptions {
            seed: session.seed(),
            ..self.options.clone()
        };
        options.validate()?;
        let material = self.material(options.seed)?;
        let started = Instant::now();
        let baked = bake(&material, &options, &self.output, &session.progress())?;
        Ok(self.outcome(&material, &baked, started.elapsed().as_secs_f64()))
    }

    fn material(&self, seed: u64) -> Result<Material> {
        match self.preset {
            Some(preset) => preset.material(self.size, seed),
            None => Err(Error::option("preset", "none", "--preset NAME")),
        }
    }

    fn outcome(&self, material: &Material, baked: &Baked, seconds: f64) -> Outcome {
        let description = &baked.description;
        let (views, lights) = (description.views.len(), description.lights.len());
        let (width, height) = (description.width, description.height);
        let rate = baked.rays as f64 / seconds / 1e6;
        Outcome::default()
            .line(format!(
                "{}: {width} × {height} texels, {views} views × {lights} lights",
                material.name
            ))
            .line(format!(
                "{} rays in {seconds:.2} s, {rate:.1} million a second",
                baked.rays
            ))
            .figure("name", material.name.clone())
            .figure("width", width)
            .figure("height", height)
            .figure("views", views)
            .figure("lights", lights)
            .figure("rays", baked.rays)
            .figure("seconds", seconds)
            .figure("id", description.id.to_string())
            .wrote(&self.output)
            .next(format!(
                "mesotex textons {} -o {}",
                self.output.display(),
                self.output.with_extension("textons.npz").display()
            ))
    }
}
