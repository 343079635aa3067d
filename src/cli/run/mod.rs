//! `mesotex run`: a scene file → every stage in order, skipping what is done.
//!
//! [`scene`] (from the [`document`], and its [`matrix`] of values) says which stages there are, each a [`draft`],
//! [`check`] holds them against the rules of their commands before the first one runs, [`record`] knows which are done.
//! [`quality`] makes a draft of a scene, [`until`] cuts it short, and [`plan`] says beforehand what it takes, by the
//! [`sizes`] and the [`cost`] of each stage. [`pages`] come last; [`overview`] is what they tell of the stages.

pub(in crate::cli) mod check;
pub(in crate::cli) mod cost;
mod document;
pub(in crate::cli) mod draft;
pub(crate) mod faults;
mod known_files;
mod matrix;
pub(in crate::cli) mod overview;
mod pages;
mod plan;
pub(in crate::cli) mod quality;
pub(in crate::cli) mod record;
pub(crate) mod scene;
pub(crate) mod sections;
mod side_outputs;
pub(in crate::cli) mod sizes;
mod tag;
mod until;

use std::collections::HashSet;
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
use crate::cli::run::overview::{Opened, command_line, enter, opened, quoted, read_text};
use crate::cli::run::pages::Pages;
use crate::cli::run::plan::Plan;
use crate::cli::run::quality::Quality;
use crate::cli::run::record::Record;
use crate::cli::session::{Common, Session};
use crate::cli::subcommand::{CHAIN_IF_INTERRUPTED, Subcommand};
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
  mesotex run sweep.toml --only oak-bunny            one run of a scene with a [matrix]
  mesotex run scene.toml --fresh --seed 7")]
pub struct Arguments {
    /// The scene file.
    pub scene: PathBuf,
    /// Run every stage, even if nothing has changed.
    #[arg(long)]
    pub fresh: bool,
    /// How finely the scene is run.
    #[arg(long, value_enum, default_value_t)]
    pub quality: Quality,
    /// Stop after this stage: bake, import, exemplar, textons, gram, knn, mesh, synth or render, or the name of a
    /// rendering.
    #[arg(long, value_name = "STAGE")]
    pub until: Option<String>,
    /// For a scene with a [matrix]: make only this run, named by the varied values in the names of its outputs.
    #[arg(long, value_name = "RUN")]
    pub only: Option<String>,
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

impl Subcommand for Arguments {
    fn common(&self) -> &Common {
        &self.common
    }

    fn if_interrupted(&self) -> &'static str {
        CHAIN_IF_INTERRUPTED
    }

    fn run(&self, session: &Session) -> Result<Outcome> {
        let text = read_text(&self.scene)?;
        let folder = self.scene.parent().unwrap_or(Path::new("")).to_path_buf();
        enter(&folder)?;
        let Opened {
            runs,
            stages,
            record,
        } = opened(&self.scene, &text, self.quality, self.only.as_deref())?;
        let list = until::up_to(stages.list, self.until.as_deref())?;
        let session = seeded(session, &runs)?;
        let chain = Chain {
            session: &session,
            folder,
            fresh: self.fresh,
            record,
        };
        let pages: Vec<RunPages<'_>> = match self.has_pages() {
            true => runs.iter().zip(stages.of_runs).collect(),
            false => Vec::new(),
        };
        match (self.dry_run, self.plan) {
            (true, _) => chain.commands(&list),
            (_, true) => chain.expectations(&list, &pages),
            _ => self.run_stages(chain, &runs[0].output, &list, &pages),
        }
    }
}

impl Arguments {
    /// Whether pages are made: by runs of the whole scene.
    fn has_pages(&self) -> bool {
        !self.no_pages && self.until.is_none()
    }

    fn run_stages(
        &self,
        mut chain: Chain<'_>,
        output: &Path,
        stages: &[Stage],
        pages: &[RunPages<'_>],
    ) -> Result<Outcome> {
        fs::create_dir_all(output).map_err(Error::io(output, "create"))?;
        let _lock = OutputLock::acquire(&output.join("scene"))?;
        leftovers::remove(output, &[]);
        if chain.record.is_damaged {
            chain
                .session
                .progress()
                .warn("run.json: damaged, or of another version; every stage runs again");
        }
        chain.tell_plan(stages, pages)?;
        let reports = chain.run(stages)?;
        let mut made = Vec::new();
        for (scene, of_run) in pages {
            let pages = Pages {
                scene,
                file: self.scene.file_name().unwrap_or_default().into(),
                quality: self.quality,
                common: &self.common,
            };
            let stages: Vec<&Stage> = of_run.iter().map(|at| &stages[*at]).collect();
            made.extend(pages.make(&stages, &mut chain.record, chain.session)?);
        }
        chain.record.close()?;
        let outcome = Outcome::default().figure("stages", reports);
        Ok(chain.where_to_look(outcome, stages, &made))
    }
}

/// A run whose pages are made, and the places of its stages.
type RunPages<'a> = (&'a Scene, Vec<usize>);

/// The session with the seed of a scene's runs; `--seed` goes before it, but not before one that varies.
pub(in crate::cli) fn seeded(session: &Session, runs: &[Scene]) -> Result<Session> {
    match runs.iter().any(|run| run.has_own_seed) && session.given_seed().is_some() {
        true => Err(Error::option(
            "seed",
            "given beside a [matrix] that varies `seed`",
            "one of the two",
        )),
        false => Ok(session.or_seed(runs.first().and_then(|run| run.seed))),
    }
}

/// Says which stages a scene has and what they make; everything wrong with it is an error.
pub fn describe(path: &Path, session: &Session) -> Result<Outcome> {
    let text = read_text(path)?;
    let folder = path.parent().unwrap_or(Path::new("")).to_path_buf();
    enter(&folder)?;
    let Opened {
        runs,
        stages,
        record,
    } = opened(path, &text, Quality::Final, None)?;
    let session = session.with_seed(runs[0].seed);
    let chain = Chain {
        session: &session,
        folder,
        fresh: false,
        record,
    };
    chain.products(&runs, &stages.list)
}

/// What the pages of runs show: the varied values that tell a run apart, its sample and its map.
fn shown(pages: &[RunPages<'_>]) -> Vec<(String, [PathBuf; 2])> {
    let runs = pages.iter().map(|(scene, _)| scene);
    runs.map(|scene| (scene.variant(), scene.sample_and_map()))
        .collect()
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
    fn run(&mut self, stages: &[Stage]) -> Result<Vec<Value>> {
        let mut reports = Vec::new();
        for stage in stages {
            let (key, title) = (self.key(stage), stage.title());
            if !self.fresh && self.record.is_done(&key, &stage.command.files()?)? {
                self.session
                    .say(&format!("{title:<10} skipped, nothing changed"))?;
                reports.push(json!({ "stage": title, "skipped": true, "report": null }));
                continue;
            }
            match self.run_stage(stage, &key) {
                Ok(report) => {
                    reports.push(json!({ "stage": title, "skipped": false, "report": report }))
                }
                Err(error) => {
                    let so_far = Outcome::default()
                        .figure("stages", reports)
                        .figure("failed", title)
                        .figure("error", failure::parts(&error));
                    self.session.report_json(&so_far)?;
                    return Err(error);
                }
            }
        }
        Ok(reports)
    }

    /// What a stage is told apart by.
    fn key(&self, stage: &Stage) -> String {
        Record::key(&stage.words, stage.seed_or(self.session.seed()))
    }

    fn run_stage(&mut self, stage: &Stage, key: &str) -> Result<Value> {
        let begun = Instant::now();
        self.record.make_way(&stage.command.files()?)?;
        let seed = stage.seed_or(self.session.seed());
        let report = stage.command.run(&self.session.with_seed(Some(seed)))?;
        // What a file names may have changed while the stage ran.
        self.record.note(
            key,
            (&stage.command.files()?, &report.inside),
            begun.elapsed().as_secs_f64(),
        )?;
        let seconds = begun.elapsed().as_secs_f64();
        let mut text = format!("{:<10} {seconds:.1} s", stage.title());
        for line in &report.lines {
            text += &format!("\n           {line}");
        }
        self.session.say(&text)?;
        Ok(report.json(&[]))
    }

    /// Says what a run will take; writes nothing.
    fn expectations(mut self, stages: &[Stage], pages: &[RunPages<'_>]) -> Result<Outcome> {
        let done = self.done(stages)?;
        let plan = Plan::of(stages, &done, &shown(pages), self.session.progress())?;
        let outcome = Outcome::default().figure("plan", plan.figures());
        Ok(plan.lines().into_iter().fold(outcome, Outcome::line))
    }

    /// Says what the run will take, where something is to be done.
    fn tell_plan(&mut self, stages: &[Stage], pages: &[RunPages<'_>]) -> Result<()> {
        let done = self.done(stages)?;
        if done.iter().all(|is_done| *is_done) {
            return Ok(());
        }
        let plan = Plan::of(stages, &done, &shown(pages), self.session.progress())?;
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
                true => outcome.line(format!("# {}: skipped, nothing changed", stage.title())),
                false => outcome
                    .line(format!("# {}: would run", stage.title()))
                    .line(command_line(stage, self.session.seed())),
            };
            reports.push(json!({ "stage": stage.title(), "skipped": is_done, "command": command_line(stage, self.session.seed()) }));
        }
        Ok(outcome.figure("stages", reports))
    }

    /// Which stages a run would skip.
    fn done(&mut self, stages: &[Stage]) -> Result<Vec<bool>> {
        // Without running a stage, the record cannot vouch for those that read what it writes.
        let mut stale: HashSet<&Path> = HashSet::new();
        let mut done = Vec::new();
        for stage in stages {
            let files = stage.command.files()?;
            let key = self.key(stage);
            let is_stale = |input: &PathBuf| input.ancestors().any(|part| stale.contains(part));
            let reads_stale = files.reads.iter().any(is_stale);
            let skip = !self.fresh && !reads_stale && self.record.is_done(&key, &files)?;
            if !skip {
                stale.extend(stage.outputs.iter().map(PathBuf::as_path));
            }
            done.push(skip);
        }
        Ok(done)
    }

    /// Says what a scene's stages make, and what of it is there.
    fn products(mut self, runs: &[Scene], stages: &[Stage]) -> Result<Outcome> {
        let name = &runs[0].name;
        let of_runs = match runs.len() {
            1 => String::new(),
            count => format!(" of {count} runs"),
        };
        let mut outcome = Outcome::default().line(format!(
            "scene `{name}`: {} stages{of_runs}, seed {}",
            stages.len(),
            self.session.seed()
        ));
        let mut reports = Vec::new();
        for (stage, is_done) in stages.iter().zip(self.done(stages)?) {
            let outputs = stage.outputs.iter().map(|output| self.folder.join(output));
            let outputs: Vec<String> = outputs.map(|path| path.display().to_string()).collect();
            let state = match (is_done, stage.output.exists()) {
                (true, _) => "done",
                (false, true) => "exists, but would run again",
                (false, false) => "not made yet",
            };
            outcome = outcome.line(format!(
                "{:<10} {}: {state}",
                stage.title(),
                outputs.join(", ")
            ));
            reports.push(json!({ "stage": stage.title(), "products": outputs, "done": is_done }));
        }
        Ok(outcome
            .figure("kind", "scene")
            .figure("name", name.as_str())
            .figure("runs", runs.len())
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
