//! `mesotex textons`.

use std::path::{Path, PathBuf};

use clap::Args;
use serde_json::{Value, json};

use crate::btf::sample::{self, Sample};
use crate::cli::info::kind::Kind;
use crate::cli::machine::{self, Need};
use crate::cli::outcome::Outcome;
use crate::cli::outputs::{Files, Product};
use crate::cli::session::{Common, Session};
use crate::error::{Error, Result};
use crate::format::image::write_png;
use crate::format::json;
use crate::format::ours::Format;
use crate::texton::analysis::planned;
use crate::texton::picture::{self, Picture};
use crate::texton::report::{AnalysisReport, LevelReport};
use crate::texton::vocabulary::FoundVocabulary;
use crate::texton::{self, Analysis, TextonOptions};

/// Find the 3D textons of a BTF sample: filter bank, representative images, K-means.
#[derive(Clone, Debug, Args)]
#[command(after_help = "\
Examples:
  mesotex textons weave.sample -o weave.textons.npz
  mesotex textons weave.sample -o weave.textons.npz --textons 200 --images all --levels 3
  mesotex textons ubo.sample -o ubo.textons.npz --memory 3GiB --no-tile
  mesotex textons weave.sample -o weave.textons.npz --report r.json --montage textons.png")]
pub struct Arguments {
    /// The BTF sample, a folder NAME.sample.
    pub sample: PathBuf,
    /// The vocabulary to write, NAME.textons.npz.
    #[arg(long, short)]
    pub output: PathBuf,
    /// Write times, routes, inertia and cluster sizes as JSON.
    #[arg(long, value_name = "FILE.json")]
    pub report: Option<PathBuf>,
    /// Write a picture of what each texton looks like, the most frequent first.
    #[arg(long, value_name = "FILE.png")]
    pub montage: Option<PathBuf>,
    /// Write a picture of the finest texton map, a stable colour a label.
    #[arg(long, value_name = "FILE.png")]
    pub label_map: Option<PathBuf>,
    #[command(flatten)]
    pub options: TextonOptions,
    #[command(flatten)]
    pub common: Common,
}

impl Arguments {
    /// What the command reads and writes.
    pub fn files(&self) -> Files {
        let picture = Product::File(Format::Picture);
        Files::default()
            .read_as(&[Kind::Sample], &self.sample)
            .read(&sample::files_of(&self.sample))
            .write("output", [&self.output], Product::File(Format::Archive))
            .write("report", &self.report, Product::File(Format::Json))
            .write("montage", &self.montage, picture)
            .write("label-map", &self.label_map, picture)
    }

    /// Runs the command.
    pub fn run(&self, session: &Session) -> Result<Outcome> {
        let _locks = self.files().claim()?;
        let sample = Sample::open(&self.sample)?;
        let options = TextonOptions {
            seed: session.seed(),
            memory: self.options.memory.or_else(machine::quarter_of_memory),
            ..self.options.clone()
        };
        let need = Need {
            bytes: planned(&sample, &options)?.bytes,
            work: format!(
                "{} textons of {} images",
                options.textons,
                options.image_count(&sample)?
            ),
            option: "memory",
            advice: "a smaller --memory, fewer --images or --textons".into(),
        };
        need.check()?;
        let analysis = texton::analyze(&sample, &options, session.progress())?;
        self.write_side_outputs(&sample, &analysis)?;
        let Analysis { vocabulary, report } = analysis;
        let outcome = self.outcome(&vocabulary, &report)?;
        let id = vocabulary.write(&self.output)?;
        Ok(outcome.figure("id", id.to_string()))
    }

    /// Files beside the vocabulary.
    fn side_outputs(&self) -> impl Iterator<Item = &PathBuf> {
        [&self.report, &self.montage, &self.label_map]
            .into_iter()
            .flatten()
    }

    fn write_side_outputs(&self, sample: &Sample, analysis: &Analysis) -> Result<()> {
        let finest = &analysis.vocabulary.levels[0];
        if let Some(path) = &self.montage {
            write(
                path,
                &picture::montage(sample, &finest.labels, &finest.counts)?,
            )?;
        }
        if let Some(path) = &self.label_map {
            write(path, &picture::label_map(finest.grid, &finest.labels))?;
        }
        match &self.report {
            Some(path) => json::write(path, &figures(&analysis.report)?),
            None => Ok(()),
        }
    }

    fn outcome(&self, vocabulary: &FoundVocabulary, report: &AnalysisReport) -> Result<Outcome> {
        let way = match &vocabulary.factor_basis {
            Some(basis) => format!("through {} eigentextures", basis.matrix.nrows()),
            None => format!("read {} times at most", report.times_read),
        };
        let mut outcome = Outcome::default().line(format!(
            "{} of {} images, {} channels, {way}",
            report.representatives, report.images, vocabulary.channels
        ));
        for (at, level) in report.levels.iter().enumerate() {
            outcome = outcome.line(level_line(at, level));
        }
        if let Value::Object(figures) = figures(report)? {
            outcome.figures.extend(figures);
        }
        outcome = outcome.wrote(&self.output);
        for path in self.side_outputs() {
            outcome = outcome.wrote(path);
        }
        Ok(outcome.next(format!(
            "mesotex gram {} -o NAME.space.npz",
            self.output.display()
        )))
    }
}

fn write(path: &Path, picture: &Picture) -> Result<()> {
    write_png(path, picture.width, picture.height, &picture.pixels)
}

/// The report with the process' memory.
fn figures(report: &AnalysisReport) -> Result<Value> {
    let mut value =
        serde_json::to_value(report).map_err(|error| Error::data("report", error.to_string()))?;
    value["peak_bytes"] = json!(machine::peak_memory().map(|size| size.0));
    Ok(value)
}

fn level_line(at: usize, level: &LevelReport) -> String {
    let mut line = format!(
        "level {at}: {} × {} texels, {} textons, inertia {:.6e} after {} steps",
        level.width, level.height, level.textons, level.inertia, level.iterations
    );
    if level.explained_variance < 1.0 {
        line += &format!(
            ", on a sketch of {:.3} % of the variance",
            100.0 * level.explained_variance
        );
    }
    if level.duplicates > 0 {
        line += &format!(", {} duplicate texels", level.duplicates);
    }
    if level.refilled > 0 {
        line += &format!(", {} empty clusters refilled", level.refilled);
    }
    line
}
