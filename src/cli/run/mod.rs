//! `mesotex run`: a scene file → every stage in order, skipping what is done.
//!
//! [`scene`] (from the [`document`]) says which stages there are, [`check`] holds them against the rules
//! of their commands before the first one runs, [`record`] knows which are done. [`quality`] makes a draft of a scene,
//! [`until`] cuts it short, and [`plan`] says beforehand what it takes, by the [`cost`] of each stage. [`pages`] come
//! last; [`overview`] is what they tell of the stages.

mod check;
mod cost;
mod document;
pub(crate) mod faults;
mod known_files;
pub(in crate::cli) mod overview;
mod pages;
mod plan;
pub(in crate::cli) mod quality;
mod record;
pub(crate) mod scene;
mod until;

use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;
use serde_json::{Value, json};

use crate::cli::failure;
use crate::cli::outcome::Outcome;
pub use crate::cli::run::record::FORMAT as RECORD_FORMAT;
pub use faults::Faults;
pub use scene::Scene;

use crate::cli::run::check::Stage;
use crate::cli::run::overview::{command_line, enter, opened, quoted, read_text};
use crate::cli::run::pages::Pages;
use crate::cli::run::plan::Plan;
use crate::cli::run::quality::Quality;
use crate::cli::run::record::Record;
use crate::cli::session::{Common, Session};
use crate::error::{Error, Result};
use crate::format::atomic::leftovers;
use crate::format::lock::OutputLock;

/// Run a scene, stage by stage; stages whose inputs and options did not change are skipped.
///
/// A scene is a TOML file with a section per stage; a key is the name of that stage's option, and
/// paths are relative to the scene file (docs/scenes.md). The whole scene is checked before the first
/// stage runs.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  mesotex run scene.toml
  mesotex run scene.toml --plan                      seconds and memory of each stage
  mesotex run scene.toml --quality draft             a quick look, in files NAME-draft
  mesotex run scene.toml --until synth               all stages up to the map
  mesotex run scene.toml --dry-run                   the commands, to paste
  mesotex run scene.toml --fresh --seed 7")]
pub struct Arguments {
    /// The scene file.
    pub scene: PathBuf,
    /// Run every stage, even where nothing changed.
    #[arg(long)]
    pub fresh: bool,
    /// How finely the scene is run.
    #[arg(long, value_enum, default_value_t)]
    pub quality: Quality,
    /// Stop after this stage: bake, import, exemplar, textons, gram, knn, mesh, synth or render, or the name of a
    /// rendering.
    #[arg(long, value_name = "STAGE")]
    pub until: Option<String>,
    /// Make no pages at the end.
    #[arg(long)]
    pub no_pages: bool,
    /// Check the scene, print the commands that would be run, and write nothing.
    #[arg(long, conflicts_with = "plan")]
    pub dry_run: bool,
    /// Check the scene, print the expected seconds and memory of each stage, and write nothing.
    #[arg(long)]
    pub plan: bool,
    #[command(flatten)]
    pub common: Common,
}

impl Arguments {
    /// Runs the command.
    pub fn run(&self, session: &Session) -> Result<Outcome> {
        let text = read_text(&self.scene)?;
        let folder = self.scene.parent().unwrap_or(Path::new("")).to_path_buf();
        enter(&folder)?;
        let (scene, stages, record) = opened(&self.scene, &text, self.quality)?;
        let stages = until::up_to(stages, self.until.as_deref())?;
        let session = session.with_seed(self.common.seed.or(scene.seed));
        let chain = Chain {
            session: &session,
            folder,
            fresh: self.fresh,
            record,
        };
        match (self.dry_run, self.plan) {
            (true, _) => chain.commands(&stages),
            (_, true) => chain.expectations(&stages, self.has_pages()),
            _ => self.run_stages(chain, &scene, &stages),
        }
    }

    /// Whether pages are made: by runs of the whole scene.
    fn has_pages(&self) -> bool {
        !self.no_pages && self.until.is_none()
    }

    fn run_stages(&self, mut chain: Chain<'_>, scene: &Scene, stages: &[Stage]) -> Result<Outcome> {
        fs::create_dir_all(&scene.output).map_err(Error::io(&scene.output, "create"))?;
        let _lock = OutputLock::acquire(&scene.output.join("scene"))?;
        leftovers::remove(&scene.output, &[]);
        if chain.record.is_damaged {
            chain
                .session
                .progress()
                .warn("run.json: damaged, or of another version; every stage runs again");
        }
        let pages = Pages {
            scene,
            file: self.scene.file_name().unwrap_or_default().into(),
            quality: self.quality,
            common: &self.common,
        };
        chain.tell_plan(stages, self.has_pages())?;
        chain.run(stages, self.has_pages().then_some(&pages))
    }
}

/// Says which stages a scene has and what they make; everything wrong with it is an error.
pub fn describe(path: &Path, session: &Session) -> Result<Outcome> {
    let text = read_text(path)?;
    let folder = path.parent().unwrap_or(Path::new("")).to_path_buf();
    enter(&folder)?;
    let (scene, stages, record) = opened(path, &text, Quality::Final)?;
    let session = session.with_seed(scene.seed);
    let chain = Chain {
        session: &session,
        folder,
        fresh: false,
        record,
    };
    chain.products(&scene, &stages)
}

/// The stages of a scene on their way.
struct Chain<'a> {
    session: &'a Session,
    folder: PathBuf,
    fresh: bool,
    record: Record,
}

impl Chain<'_> {
    /// Runs what is not done; every stage's report is said when it is finished.
    fn run(mut self, stages: &[Stage], pages: Option<&Pages<'_>>) -> Result<Outcome> {
        let mut reports = Vec::new();
        for stage in stages {
            let key = Record::key(&stage.words, self.session.seed());
            if !self.fresh && self.record.is_done(&key, &stage.command.files()?)? {
                self.session
                    .say(&format!("{:<10} skipped, nothing changed", stage.name))?;
                reports.push(json!({ "stage": stage.name, "skipped": true, "report": null }));
                continue;
            }
            match self.run_stage(stage, &key) {
                Ok(report) => {
                    reports.push(json!({ "stage": stage.name, "skipped": false, "report": report }))
                }
                Err(error) => {
                    let so_far = Outcome::default()
                        .figure("stages", reports)
                        .figure("failed", stage.name.as_str())
                        .figure("error", failure::parts(&error));
                    self.session.report_json(&so_far)?;
                    return Err(error);
                }
            }
        }
        let pages = match pages {
            Some(pages) => pages.make(stages, &mut self.record, self.session)?,
            None => Vec::new(),
        };
        self.record.close()?;
        let outcome = Outcome::default().figure("stages", reports);
        Ok(self.where_to_look(outcome, stages, &pages))
    }

    fn run_stage(&mut self, stage: &Stage, key: &str) -> Result<Value> {
        let begun = Instant::now();
        self.record.make_way(&stage.command.files()?)?;
        let report = stage.command.run(self.session)?;
        // What a file names may have changed while the stage ran.
        self.record.note(
            key,
            (&stage.command.files()?, &report.inside),
            begun.elapsed().as_secs_f64(),
        )?;
        let mut text = format!("{:<10} {:.1} s", stage.name, begun.elapsed().as_secs_f64());
        for line in &report.lines {
            text += &format!("\n           {line}");
        }
        self.session.say(&text)?;
        Ok(report.json(&[]))
    }

    /// Says what a run will take; writes nothing.
    fn expectations(mut self, stages: &[Stage], has_pages: bool) -> Result<Outcome> {
        let done = self.done(stages)?;
        let plan = Plan::of(stages, &done, has_pages, self.session.progress())?;
        let outcome = Outcome::default().figure("plan", plan.figures());
        Ok(plan.lines().into_iter().fold(outcome, Outcome::line))
    }

    /// Says what the run will take, where something is to be done.
    fn tell_plan(&mut self, stages: &[Stage], has_pages: bool) -> Result<()> {
        let done = self.done(stages)?;
        if done.iter().all(|is_done| *is_done) {
            return Ok(());
        }
        let plan = Plan::of(stages, &done, has_pages, self.session.progress())?;
        plan.lines()
            .iter()
            .try_for_each(|line| self.session.say(line))
    }

    /// Says what would be run, as commands to paste; writes nothing.
    fn commands(mut self, stages: &[Stage]) -> Result<Outcome> {
        let mut outcome = Outcome::default();
        let mut reports = Vec::new();
        if !self.folder.as_os_str().is_empty() {
            outcome = outcome.line(format!("cd {}", quoted(&self.folder.to_string_lossy())));
        }
        for (stage, is_done) in stages.iter().zip(self.done(stages)?) {
            outcome = match is_done {
                true => outcome.line(format!("# {}: skipped, nothing changed", stage.name)),
                false => outcome
                    .line(format!("# {}: would run", stage.name))
                    .line(command_line(stage, self.session.seed())),
            };
            reports.push(json!({ "stage": stage.name, "skipped": is_done, "command": command_line(stage, self.session.seed()) }));
        }
        Ok(outcome.figure("stages", reports))
    }

    /// Which stages a run would skip.
    fn done(&mut self, stages: &[Stage]) -> Result<Vec<bool>> {
        // Without running a stage, the record cannot vouch for those that read what it writes.
        let mut stale: Vec<&PathBuf> = Vec::new();
        let mut done = Vec::new();
        for stage in stages {
            let files = stage.command.files()?;
            let key = Record::key(&stage.words, self.session.seed());
            let reads_stale = files
                .reads
                .iter()
                .any(|input| stale.iter().any(|made| input.starts_with(made)));
            let skip = !self.fresh && !reads_stale && self.record.is_done(&key, &files)?;
            if !skip {
                stale.extend(&stage.outputs);
            }
            done.push(skip);
        }
        Ok(done)
    }

    /// Says what a scene's stages make, and what of it is there.
    fn products(mut self, scene: &Scene, stages: &[Stage]) -> Result<Outcome> {
        let mut outcome = Outcome::default().line(format!(
            "scene `{}`: {} stages, seed {}",
            scene.name,
            stages.len(),
            self.session.seed()
        ));
        let mut reports = Vec::new();
        for (stage, is_done) in stages.iter().zip(self.done(stages)?) {
            let outputs = stage.outputs.iter().map(|output| self.folder.join(output));
            let outputs: Vec<String> = outputs.map(|path| path.display().to_string()).collect();
            let state = match (is_done, stage.output.exists()) {
                (true, _) => "done",
                (false, true) => "there, but would run again",
                (false, false) => "not made yet",
            };
            outcome = outcome.line(format!(
                "{:<10} {}: {state}",
                stage.name,
                outputs.join(", ")
            ));
            reports.push(json!({ "stage": stage.name, "products": outputs, "done": is_done }));
        }
        Ok(outcome
            .figure("kind", "scene")
            .figure("name", scene.name.as_str())
            .figure("stages", reports))
    }

    /// Names what a person wants to open: the outputs of the last stages.
    fn where_to_look(&self, mut outcome: Outcome, stages: &[Stage], pages: &[PathBuf]) -> Outcome {
        for output in stages.iter().flat_map(|stage| &stage.outputs) {
            outcome = outcome.wrote(&self.folder.join(output));
        }
        for stage in stages.iter().filter(|stage| stage.words[0] == "render") {
            let sheet = self.folder.join(&stage.output).join("contact.png");
            outcome = outcome.line(format!("look at {}", sheet.display()));
        }
        for page in pages {
            let page = self.folder.join(page);
            outcome = outcome
                .line(format!("open {} in a browser", page.display()))
                .wrote(&page);
        }
        outcome
    }
}
