//! `mesotex plan`: scenes → the tasks that many machines share, in a form that their programs read.
//!
//! | file | what it does |
//! | --- | --- |
//! | [`graph`] | the tasks of all scenes, and which come before which |
//! | [`stage_tasks`] | a stage as one task, or as the tasks it is split into |
//! | [`json`], [`shell`], [`snakefile`] | the graph as text |

mod graph;
mod json;
mod shell;
mod snakefile;
mod stage_tasks;

use std::io::Write;
use std::path::PathBuf;

use clap::{Args, ValueEnum};

use crate::cli::outcome::Outcome;
use crate::cli::outputs::{Files, Product};
use crate::cli::plan::graph::{Graph, Wanted};
use crate::cli::run::quality::Quality;
use crate::cli::session::{Common, Session};
use crate::cli::subcommand::Subcommand;
use crate::error::{Error, Result};
use crate::format::atomic;
use crate::format::ours::Format;

/// The most parts that a stage is split into.
const MOST_SHARDS: u32 = 10_000;

/// Plan scenes for many machines: each task with its command, files, dependencies, time and memory.
///
/// Prints the plan, or writes it to -o FILE. Nothing is run. Paths stay relative to the folder in which the plan is
/// made, and its commands are run there. Each task uses --threads threads, 1 by default. The same scenes and options
/// give the same bytes.
#[derive(Clone, Debug, Args)]
#[command(after_help = "\
Examples:
  mesotex plan sweep.toml                                  the tasks, as JSON
  mesotex plan sweep.toml --shards 8 --format shell -o sweep.sh
  sh sweep.sh                                              one task after the other
  mesotex plan a.toml b.toml --shards 8 --format snakemake -o Snakefile
  snakemake --executor slurm --jobs 100")]
pub struct Arguments {
    /// The scenes.
    #[arg(required = true, value_name = "SCENE.toml")]
    pub scenes: Vec<PathBuf>,
    /// Most parts that a stage is split into, if it can be split.
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub shards: u32,
    /// Format of the plan.
    #[arg(long, value_enum, default_value_t)]
    pub format: PlanFormat,
    /// The file to write, instead of printing the plan.
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// How finely the scenes are run.
    #[arg(long, value_enum, default_value_t)]
    pub quality: Quality,
    #[command(flatten)]
    pub common: Common,
}

/// What a plan is written as.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum PlanFormat {
    /// Everything, for programs
    #[default]
    Json,
    /// A command per line, step after step, for sh and GNU parallel
    Shell,
    /// A Snakefile for Snakemake 8 or later
    Snakemake,
}

impl Subcommand for Arguments {
    fn common(&self) -> &Common {
        &self.common
    }

    fn check(&self) -> Result<()> {
        match (1..=MOST_SHARDS).contains(&self.shards) {
            true => Ok(()),
            false => Err(Error::option(
                "shards",
                self.shards.to_string(),
                format!("1 to {MOST_SHARDS}"),
            )),
        }
    }

    fn files(&self) -> Result<Files> {
        let format = match self.format {
            PlanFormat::Json => Format::Json,
            PlanFormat::Shell | PlanFormat::Snakemake => Format::Plan,
        };
        let files = Files::default().read(&self.scenes);
        Ok(files.write("output", &self.output, Product::File(format)))
    }

    fn run(&self, session: &Session) -> Result<Outcome> {
        let _locks = self.files()?.claim()?;
        let output = self.output.as_deref().map(std::path::absolute).transpose();
        let output = output.map_err(Error::io(&self.scenes[0], "find the folder of"))?;
        let wanted = Wanted {
            shards: self.shards,
            threads: self.common.threads.unwrap_or(1),
            quality: self.quality,
        };
        let graph = Graph::of(&self.scenes, &wanted, session)?;
        let text = match self.format {
            PlanFormat::Json => json::text(&graph),
            PlanFormat::Shell => shell::text(&graph),
            PlanFormat::Snakemake => snakefile::text(&graph),
        };
        let outcome = Outcome::default()
            .figure("tasks", graph.tasks.len())
            .figure("steps", graph.steps())
            .figure("seconds", graph.seconds());
        let (Some(path), Some(named)) = (output, &self.output) else {
            return Ok(outcome.line(text.trim_end()).figure("plan", text));
        };
        atomic::write_file(&path, |sink| sink.write_all(text.as_bytes()))?;
        let outcome = outcome.line(graph.describe());
        Ok(outcome.wrote(named))
    }
}
