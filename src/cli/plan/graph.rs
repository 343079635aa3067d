//! The tasks of scenes: what each runs, reads and makes, which it follows, and what it takes.

use std::collections::{BTreeSet, HashMap, HashSet};
use std::path::{Path, PathBuf};

use crate::cli::plan::stage_tasks::{Made, StageTask, joined, stage_tasks};
use crate::cli::run::check::Stage;
use crate::cli::run::cost::Cost;
use crate::cli::run::overview::{Opened, enter, opened, read_text};
use crate::cli::run::quality::Quality;
use crate::cli::run::scene::Scene;
use crate::cli::run::seeded;
use crate::cli::run::sizes::Sizes;
use crate::cli::session::Session;
use crate::error::{Error, Result};

/// What the tasks shall be.
pub(super) struct Wanted {
    /// Parts of a stage at most.
    pub(super) shards: u32,
    /// Threads of each task.
    pub(super) threads: usize,
    /// The quality of the scenes.
    pub(super) quality: Quality,
}

/// One command of a plan.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Task {
    /// What it is told apart by: scene, stage, varied values, part.
    pub(super) id: String,
    /// The stage: its command, and for renderings their name.
    pub(super) stage: String,
    /// The folder in which the command is run; empty for that of the plan.
    pub(super) folder: PathBuf,
    /// The command line, without the program.
    pub(super) words: Vec<String>,
    /// What it reads, relative to the folder of the plan.
    pub(super) inputs: Vec<PathBuf>,
    /// What it makes, relative to the folder of the plan.
    pub(super) makes: Vec<Made>,
    /// The tasks that must be finished before.
    pub(super) after: BTreeSet<usize>,
    /// How many tasks follow each other up to this one, from 0.
    pub(super) step: usize,
    /// What it takes; `None` where that is not known yet.
    pub(super) cost: Option<Cost>,
    /// The record that says when it is done, relative to `folder`; `None` where the command keeps its part or its
    /// frames by itself.
    pub(super) record: Option<PathBuf>,
}

/// The folder for records of tasks, in the output of their scene.
const RECORDS: &str = "tasks";

/// The tasks of a plan, each after those it needs.
#[derive(Default)]
pub(super) struct Graph {
    pub(super) tasks: Vec<Task>,
    /// Folders that the tasks write into and that `mesotex run` would make.
    pub(super) folders: BTreeSet<PathBuf>,
    /// Threads of each task.
    pub(super) threads: usize,
    /// The task that makes a file or folder.
    makers: HashMap<PathBuf, usize>,
    /// The stage that makes a file or folder, frames among them.
    owners: HashMap<PathBuf, Owner>,
    /// The folders and commands of all tasks.
    known: HashSet<(PathBuf, Vec<String>)>,
    ids: HashMap<String, usize>,
}

/// The stage that makes something.
#[derive(Clone)]
struct Owner {
    folder: PathBuf,
    stage: Vec<String>,
    id: String,
}

impl Graph {
    /// The tasks of scenes; everything wrong with them is one error.
    pub(super) fn of(scenes: &[PathBuf], wanted: &Wanted, session: &Session) -> Result<Self> {
        let here = std::env::current_dir().map_err(Error::io(Path::new("."), "find"))?;
        let mut graph = Self {
            threads: wanted.threads,
            ..Self::default()
        };
        let mut errors = Vec::new();
        for path in scenes {
            let added = graph.add_scene(path, wanted, session);
            enter(&here)?;
            match added {
                Err(Error::Interrupted) => return Err(Error::Interrupted),
                Err(error) => errors.push((path, error)),
                Ok(()) => {}
            }
        }
        match together(errors) {
            None => Ok(graph),
            Some(error) => Err(error),
        }
    }

    fn add_scene(&mut self, path: &Path, wanted: &Wanted, session: &Session) -> Result<()> {
        let text = read_text(path)?;
        let folder = path.parent().unwrap_or(Path::new("")).to_path_buf();
        enter(&folder)?;
        let Opened { runs, stages, .. } = opened(path, &text, wanted.quality, None)?;
        let seed = seeded(session, &runs)?.seed();
        self.folders.insert(joined(&folder, &runs[0].output));
        let mut sizes = Sizes::new(session.progress(), false);
        for stage in &stages.list {
            session.progress().check()?;
            for mut task in stage_tasks(stage, &mut sizes, wanted.shards)? {
                task.words
                    .extend(["--seed".into(), stage.seed_or(seed).to_string()]);
                task.words
                    .extend(["--threads".into(), wanted.threads.to_string()]);
                self.add(task, (&runs[0], stage), &folder)?;
            }
        }
        Ok(())
    }

    fn add(
        &mut self,
        task: StageTask,
        (scene, stage): (&Scene, &Stage),
        folder: &Path,
    ) -> Result<()> {
        let id = self.id_of(&scene.name, stage, &task.part);
        let is_whole = |made: &Made| matches!(made, Made::File(_) | Made::Folder(_));
        let record = scene.output.join(RECORDS).join(format!("{id}.json"));
        let record = task.makes.iter().all(is_whole).then_some(record);
        let makes: Vec<Made> = task.makes.iter().map(|made| made.inside(folder)).collect();
        let inputs = task.reads.iter().map(|input| joined(folder, input));
        let (inputs, after) = self.resolved(inputs);
        let task = Task {
            id,
            stage: stage.name.clone(),
            folder: folder.to_path_buf(),
            words: task.words,
            inputs,
            step: after
                .iter()
                .map(|at| self.tasks[*at].step + 1)
                .max()
                .unwrap_or(0),
            after,
            makes,
            cost: task.cost,
            record,
        };
        if !self.known.insert((task.folder.clone(), task.words.clone())) {
            return Ok(());
        }
        self.claim(&task, &stage.words)?;
        let at = self.tasks.len();
        for made in task.makes.iter().filter_map(Made::path) {
            self.makers.insert(made.to_path_buf(), at);
        }
        *self.ids.entry(task.id.clone()).or_default() += 1;
        self.tasks.push(task);
        Ok(())
    }

    /// What is read, folders of the plan in place of the files inside, and the tasks that make it.
    fn resolved(&self, inputs: impl Iterator<Item = PathBuf>) -> (Vec<PathBuf>, BTreeSet<usize>) {
        let (mut paths, mut after) = (BTreeSet::new(), BTreeSet::new());
        for input in inputs {
            let made = input
                .ancestors()
                .find_map(|part| Some((part.to_path_buf(), *self.makers.get(part)?)));
            match made {
                Some((path, maker)) => {
                    after.insert(maker);
                    paths.insert(path);
                }
                None => {
                    paths.insert(input);
                }
            }
        }
        (paths.into_iter().collect(), after)
    }

    /// Notes what a task makes; two stages that make the same are an error.
    fn claim(&mut self, task: &Task, stage: &[String]) -> Result<()> {
        for made in &task.makes {
            let owner = Owner {
                folder: task.folder.clone(),
                stage: stage.to_vec(),
                id: task.id.clone(),
            };
            let place = made.place();
            let first = self
                .owners
                .entry(place.to_path_buf())
                .or_insert_with(|| owner.clone());
            if (&first.folder, &first.stage) != (&owner.folder, &owner.stage) {
                let both = format!("{} and {} both make {}", first.id, task.id, place.display());
                return Err(Error::data("scene", both)
                    .expected("files of their own")
                    .advice("give the scenes other names or another `output`"));
            }
        }
        Ok(())
    }

    fn id_of(&self, scene: &str, stage: &Stage, part: &str) -> String {
        let words = [scene, &stage.name, &stage.variant, part];
        let words: Vec<String> = words
            .iter()
            .filter(|word| !word.is_empty())
            .map(|word| word.replace(' ', "-"))
            .collect();
        let id = words.join(".");
        match self.ids.get(&id) {
            Some(count) => format!("{id}~{}", count + 1),
            None => id,
        }
    }

    /// Steps: tasks of one step do not wait for each other.
    pub(super) fn steps(&self) -> usize {
        let steps = self.tasks.iter().map(|task| task.step + 1);
        steps.max().unwrap_or(0)
    }

    /// The tasks of a step.
    pub(super) fn of_step(&self, step: usize) -> impl Iterator<Item = &Task> {
        self.tasks.iter().filter(move |task| task.step == step)
    }

    /// What a task takes, in seconds.
    pub(super) fn seconds_of(&self, task: &Task) -> Option<f64> {
        Some(task.cost?.seconds_on(self.threads))
    }

    /// What all tasks take, as far as that is known.
    pub(super) fn seconds(&self) -> f64 {
        let seconds = self.tasks.iter().filter_map(|task| self.seconds_of(task));
        (seconds.sum::<f64>() * 1e3).round() / 1e3
    }

    /// What a person reads of the plan.
    pub(super) fn describe(&self) -> String {
        let unknown = self.tasks.iter().filter(|task| task.cost.is_none()).count();
        let more = match unknown {
            0 => String::new(),
            count => format!(", and {count} tasks of unknown length"),
        };
        format!(
            "{} tasks in {} steps, {:.0} s of work{more}",
            self.tasks.len(),
            self.steps(),
            self.seconds()
        )
    }
}

/// The errors of several scenes as one.
fn together(mut errors: Vec<(&PathBuf, Error)>) -> Option<Error> {
    if errors.len() < 2 {
        return Some(errors.pop()?.1);
    }
    let path = format!("{} scenes", errors.len()).into();
    let mut all_lines = Vec::new();
    let mut has_usage = false;
    for (scene, error) in errors {
        match error {
            Error::Faults { path, lines, usage } => {
                has_usage |= usage;
                let named = lines
                    .iter()
                    .map(|line| format!("{}: {line}", path.display()));
                all_lines.extend(named);
            }
            Error::Io { .. } => all_lines.push(error.to_string()),
            other => all_lines.push(format!("{}: {other}", scene.display())),
        }
    }
    Some(Error::Faults {
        path,
        lines: all_lines,
        usage: has_usage,
    })
}
