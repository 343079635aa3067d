//! `mesotex textons`.

use std::path::PathBuf;

use clap::Args;
use serde_json::json;

use crate::btf::sample::Sample;
use crate::cli::outcome::Outcome;
use crate::cli::session::{Common, Session};
use crate::error::Result;
use crate::texton::{self, TextonOptions, Vocabulary};

/// Find the 3D textons of a BTF sample: filter bank, representative images, K-means.
#[derive(Clone, Debug, Args)]
#[command(after_help = "\
Examples:
  mesotex textons weave.sample -o weave.textons.npz
  mesotex textons weave.sample -o weave.textons.npz --textons 200 --images all --levels 3
  mesotex textons ubo.sample -o ubo.textons.npz --memory 3GiB --no-tile")]
pub struct Arguments {
    /// The BTF sample, a folder NAME.sample.
    pub sample: PathBuf,
    /// The vocabulary to write, NAME.textons.npz.
    #[arg(long, short)]
    pub output: PathBuf,
    #[command(flatten)]
    pub options: TextonOptions,
    #[command(flatten)]
    pub common: Common,
}

impl Arguments {
    /// Runs the command.
    pub fn run(&self, session: &Session) -> Result<Outcome> {
        let _lock = session.claim(&self.output, &[&self.sample])?;
        let sample = Sample::open(&self.sample)?;
        let options = TextonOptions {
            seed: session.seed(),
            ..self.options.clone()
        };
        let texton::Analysis { mut vocabulary, report: _ } =
            texton::analyze(&sample, &options, session.progress())?;
        vocabulary.write(&self.output)?;
        Ok(self.outcome(&vocabulary))
    }

    fn outcome(&self, vocabulary: &Vocabulary) -> Outcome {
        let images = vocabulary.representatives.len();
        let mut outcome = Outcome::default()
            .line(format!("{images} images, {} channels", vocabulary.channels))
            .figure("images", images)
            .figure("channels", vocabulary.channels)
            .figure("id", vocabulary.id.to_string());
        let mut levels = Vec::new();
        for (at, level) in vocabulary.levels.iter().enumerate() {
            outcome = outcome.line(format!(
                "level {at}: {} × {} texels, {} textons, inertia {:.6e} after {} steps",
                level.grid.width,
                level.grid.height,
                level.counts.len(),
                level.inertia,
                level.iterations
            ));
            levels.push(json!({
                "width": level.grid.width,
                "height": level.grid.height,
                "textons": level.counts.len(),
                "inertia": level.inertia,
                "iterations": level.iterations,
            }));
        }
        outcome
            .figure("levels", levels)
            .wrote(&self.output)
            .next(format!(
                "mesotex gram {} -o NAME.space.npz",
                self.output.display()
            ))
    }
}
