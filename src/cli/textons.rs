//! `mesotex textons`.

use std::path::PathBuf;

use clap::Args;
use serde_json::{Value, json};

use crate::btf::sample::{self, Sample};
use crate::cli::info::kind::Kind;
use crate::cli::machine::{self, Need};
use crate::cli::outcome::Outcome;
use crate::cli::outputs::{Files, Product};
use crate::cli::parts::{InShards, outcome_of_kept, refuse_other_seed};
use crate::cli::session::{Common, Session};
use crate::cli::subcommand::Subcommand;
use crate::error::{Error, Result};
use crate::format::json;
use crate::format::ours::Format;
use crate::shard::Shard;
use crate::texton::montage::{label_map, montage};
use crate::texton::report::{AnalysisReport, LevelReport};
use crate::texton::vocabulary::FoundVocabulary;
use crate::texton::{self, Analysis, PartReport, Parts, Study, TextonOptions};

/// Find the 3D textons of a BTF sample: filter bank, representative images, K-means.
#[derive(Clone, Debug, Args)]
#[command(after_help = "\
Examples:
  mesotex textons weave.sample -o weave.textons.npz
  mesotex textons weave.sample -o weave.textons.npz --textons 200 --images all --levels 3
  mesotex textons ubo.sample -o ubo.textons.npz --memory 3GiB --no-tile
  mesotex textons weave.sample -o weave.textons.npz --report r.json --montage textons.png
  mesotex textons weave.sample --shard 0/2 -o part0.npz    (and --shard 1/2 -o part1.npz, elsewhere)
  mesotex textons weave.sample --reduce part0.npz part1.npz -o weave.textons.npz")]
pub struct Arguments {
    /// The BTF sample, a folder NAME.sample.
    pub sample: PathBuf,
    /// The vocabulary to write, NAME.textons.npz; with --shard, a part of the analysis, PART.npz.
    #[arg(long, short)]
    pub output: PathBuf,
    /// Write times, routes, inertia and cluster sizes as JSON.
    #[arg(long, value_name = "FILE.json")]
    pub report: Option<PathBuf>,
    /// Write a picture that shows each texton, the most frequent first.
    #[arg(long, value_name = "FILE.png")]
    pub montage: Option<PathBuf>,
    /// Write a picture of the finest texton map. A label has the same colour in every picture.
    #[arg(long, value_name = "FILE.png")]
    pub label_map: Option<PathBuf>,
    /// Analyse only shard i of n (counted from 0) of the images and write it as a part; --reduce joins the parts. An
    /// existing part of the same sample and options is kept.
    #[arg(long, value_name = "I/N", conflicts_with = "reduce")]
    pub shard: Option<Shard>,
    /// Join the parts of all shards to the vocabulary that one run without --shard finds, byte for byte. The options
    /// are those of the parts.
    #[arg(long, value_name = "PART.npz", num_args = 1..)]
    pub reduce: Vec<PathBuf>,
    #[command(flatten)]
    pub options: TextonOptions,
    #[command(flatten)]
    pub common: Common,
}

impl Subcommand for Arguments {
    fn common(&self) -> &Common {
        &self.common
    }

    fn check(&self) -> Result<()> {
        self.options.validate()
    }

    fn files(&self) -> Result<Files> {
        let picture = Product::File(Format::Picture);
        Ok(Files::default()
            .read_as(&[Kind::Sample], &self.sample)
            .read(&sample::files_of(&self.sample))
            .read(&self.reduce)
            .write("output", [&self.output], Product::File(Format::Archive))
            .write("report", &self.report, Product::File(Format::Json))
            .write("montage", &self.montage, picture)
            .write("label-map", &self.label_map, picture))
    }

    fn run(&self, session: &Session) -> Result<Outcome> {
        let _locks = self.files()?.claim()?;
        let sample = Sample::open(&self.sample)?;
        if !self.reduce.is_empty() {
            return self.join(&sample, session);
        }
        let options = TextonOptions {
            seed: session.seed(),
            memory: self.options.memory.or_else(machine::quarter_of_memory),
            ..self.options.clone()
        };
        let study = Study::new(&sample, &options)?;
        let work = format!(
            "{} textons of {} images",
            options.textons,
            options.image_count(&sample)?
        );
        let need = |bytes: u64| Need {
            bytes,
            work,
            option: "memory",
            advice: "a smaller --memory, fewer --images or --textons".into(),
        };
        match self.shard {
            Some(shard) => {
                need(study.part_bytes).check()?;
                let report = texton::write_part(&study, shard, &self.output, session.progress())?;
                Ok(self.outcome_of_part(shard, &report))
            }
            None => {
                need(study.plan.bytes).check()?;
                self.finish(&sample, texton::find(&study, None, session.progress())?)
            }
        }
    }
}

impl InShards for Arguments {
    fn parts(&self) -> &[PathBuf] {
        &self.reduce
    }
}

impl Arguments {
    /// Joins parts.
    fn join(&self, sample: &Sample, session: &Session) -> Result<Outcome> {
        let parts = Parts::open(&self.reduce, sample)?;
        refuse_other_seed(session, parts.options.seed)?;
        let options = parts.options.clone();
        let study = parts.study(sample, &options, machine::quarter_of_memory())?;
        let need = Need {
            bytes: study.plan.bytes,
            work: format!("{} textons of these parts", options.textons),
            option: "reduce",
            advice: "parts made with a smaller --memory, fewer --images or --textons".into(),
        };
        need.check()?;
        self.finish(
            sample,
            texton::find(&study, Some(parts), session.progress())?,
        )
    }

    /// Writes what was found.
    fn finish(&self, sample: &Sample, analysis: Analysis) -> Result<Outcome> {
        self.write_side_outputs(sample, &analysis)?;
        let Analysis { vocabulary, report } = analysis;
        let outcome = self.outcome(&vocabulary, &report)?;
        let id = vocabulary.write(&self.output)?;
        Ok(outcome.figure("id", id.to_string()))
    }

    fn outcome_of_part(&self, shard: Shard, report: &PartReport) -> Outcome {
        let PartReport { images, is_kept } = report;
        let outcome = match is_kept {
            true => outcome_of_kept(&self.output, shard, "sample"),
            false => Outcome::default()
                .wrote(&self.output)
                .figure("shard", shard.to_string())
                .figure("kept", false),
        };
        outcome
            .line(format!("images {} to {}", images.start, images.end - 1))
            .figure("images", images.len())
            .figure("peak_bytes", machine::peak_memory().map(|size| size.0))
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
            montage(sample, &finest.labels, &finest.counts)?.write(path)?;
        }
        if let Some(path) = &self.label_map {
            label_map(finest.grid, &finest.labels).write(path)?;
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
