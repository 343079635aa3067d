//! `mesotex run`: a scene file → every stage in order, skipping what is done.

mod record;
pub mod scene;

use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::{Args, Parser};
use serde_json::json;

use crate::cli::CommandLine;
use crate::cli::outcome::Outcome;
use crate::cli::run::record::Record;
use crate::cli::run::scene::{Scene, Stage};
use crate::cli::session::{Common, Session};
use crate::error::{Error, Result};

/// Run a whole scene, stage by stage; stages whose inputs and options did not change are skipped.
///
/// A scene is a TOML file with a section a stage; a key is the name of that stage's option, and
/// paths are relative to the scene file (docs/scenes.md).
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  mesotex run scene.toml
  mesotex run scene.toml --dry-run
  mesotex run scene.toml --fresh --seed 7")]
pub struct Arguments {
    /// The scene file.
    pub scene: PathBuf,
    /// Run every stage, even where nothing changed.
    #[arg(long)]
    pub fresh: bool,
    /// Say what would be run and what skipped, and stop.
    #[arg(long)]
    pub dry_run: bool,
    #[command(flatten)]
    pub common: Common,
}

impl Arguments {
    /// Runs the command.
    pub fn run(&self, session: &Session) -> Result<Outcome> {
        let scene = Scene::read(&self.scene)?;
        let folder = self.scene.parent().unwrap_or(Path::new("")).to_path_buf();
        let session = session.with_seed(self.common.seed.or(scene.seed));
        enter(&folder)?;
        std::fs::create_dir_all(&scene.output).map_err(Error::io(&scene.output, "create"))?;
        let _lock = session.claim(&scene.output.join("scene"), &[])?;
        let stages = scene.stages()?;
        Chain {
            session: &session,
            folder,
            fresh: self.fresh,
            dry_run: self.dry_run,
            record: Record::open(&scene.output.join("run.json"))?,
        }
        .run(&stages)
    }
}

/// Makes the paths of a scene relative to its file.
fn enter(folder: &Path) -> Result<()> {
    if folder.as_os_str().is_empty() {
        return Ok(());
    }
    std::env::set_current_dir(folder).map_err(Error::io(folder, "enter"))
}

/// The stages of a scene on their way.
struct Chain<'a> {
    session: &'a Session,
    folder: PathBuf,
    fresh: bool,
    dry_run: bool,
    record: Record,
}

impl Chain<'_> {
    fn run(mut self, stages: &[Stage]) -> Result<Outcome> {
        let mut outcome = Outcome::default();
        let mut reports = Vec::new();
        // Without running a stage, the record cannot vouch for those that read what it writes.
        let mut stale: Vec<&PathBuf> = Vec::new();
        for stage in stages {
            let key = self.record.key(stage, self.session.seed());
            let must = self.fresh || stage.inputs.iter().any(|input| stale.contains(&input));
            let skip = !must && self.record.is_done(stage, &key)?;
            if self.dry_run && !skip {
                stale.extend(&stage.outputs);
            }
            let (line, report) = match (skip, self.dry_run) {
                (true, _) => ("skipped, nothing changed".into(), json!(null)),
                (false, true) => (
                    format!("would run: mesotex {}", stage.words.join(" ")),
                    json!(null),
                ),
                (false, false) => self.run_stage(stage, &key)?,
            };
            outcome = outcome.line(format!("{:<10} {line}", stage.name));
            reports.push(json!({ "stage": stage.name, "skipped": skip, "report": report }));
        }
        let outcome = outcome.figure("stages", reports);
        if self.dry_run {
            return Ok(outcome);
        }
        Ok(self.where_to_look(outcome, stages))
    }

    fn run_stage(&mut self, stage: &Stage, key: &str) -> Result<(String, serde_json::Value)> {
        let words = std::iter::once("mesotex").chain(stage.words.iter().map(String::as_str));
        let command = CommandLine::try_parse_from(words).map_err(|error| {
            Error::option(
                format!("{} in the scene", stage.name),
                error.render().to_string(),
                format!("the options of `mesotex {} --help`", stage.words[0]),
            )
        })?;
        let begun = Instant::now();
        let report = command.command.run(self.session)?;
        self.record.note(stage, key)?;
        let line = format!("{:.1} s", begun.elapsed().as_secs_f64());
        let detail: String = report
            .lines
            .iter()
            .map(|line| format!("\n           {line}"))
            .collect();
        Ok((line + &detail, report.json(&[])))
    }

    /// Names what a person wants to open: the outputs of the last stages.
    fn where_to_look(&self, mut outcome: Outcome, stages: &[Stage]) -> Outcome {
        for output in stages.iter().flat_map(|stage| &stage.outputs) {
            outcome = outcome.wrote(&self.folder.join(output));
        }
        for stage in stages.iter().filter(|stage| stage.words[0] == "render") {
            let sheet = self.folder.join(&stage.outputs[0]).join("contact.png");
            outcome = outcome.line(format!("look at {}", sheet.display()));
        }
        outcome
    }
}
