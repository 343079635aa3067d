//! A scene opened: its stages, and what is known of those that were run.

use std::path::{Path, PathBuf};

use crate::cli::Command;
use crate::cli::failure::likely_names::suggestion;
use crate::cli::run::check::{self, Stage, Stages};
use crate::cli::run::faults::Faults;
use crate::cli::run::quality::Quality;
use crate::cli::run::record::Record;
use crate::cli::run::scene::Scene;
use crate::cli::session::Session;
use crate::cli::subcommand::Subcommand;
use crate::error::{Error, Result};
use crate::format::guard::guarded;
use crate::format::id::ContentId;
use crate::format::text;

/// The largest scene read, in bytes.
const LARGEST_SCENE: u64 = 1 << 20;

/// What a scene's stages are, and what is known of those that were run.
pub(in crate::cli) struct Overview {
    /// The scene's name.
    pub name: String,
    /// Its stages, in order.
    pub stages: Vec<StageOverview>,
}

/// A stage, and what is known of it.
pub(in crate::cli) struct StageOverview {
    /// What the user reads: the command, and for renderings their name.
    pub name: String,
    /// The command, parsed.
    pub command: Command,
    /// The command as a line for a shell.
    pub command_line: String,
    /// The seed.
    pub seed: u64,
    /// What it reads.
    pub reads: Vec<PathBuf>,
    /// What it writes.
    pub outputs: Vec<PathBuf>,
    /// How long it took.
    pub seconds: Option<f64>,
    /// The ids of what it wrote: of a folder, the first file.
    pub ids: Vec<(PathBuf, ContentId)>,
}

/// Enters a scene's folder and says what its stages are; everything wrong with it is an error.
pub(in crate::cli) fn overview(
    path: &Path,
    quality: Quality,
    only: Option<&str>,
    session: &Session,
) -> Result<Overview> {
    let text = read_text(path)?;
    enter(path.parent().unwrap_or(Path::new("")))?;
    let opened = opened(path, &text, quality, only)?;
    let [scene] = &opened.runs[..] else {
        let some = opened.runs.iter().take(MOST_NAMED).map(Scene::variant);
        let advice = format!(
            "name one of them by --only: {}",
            some.collect::<Vec<_>>().join(", ")
        );
        return Err(
            Error::data("[matrix]", format!("{} runs", opened.runs.len()))
                .expected("one")
                .advice(advice)
                .in_file(path),
        );
    };
    let seed = session.or_seed(scene.seed).seed();
    let stages = opened.stages.list.into_iter();
    let stages = stages.map(|stage| overview_of(stage, &opened.record, seed));
    Ok(Overview {
        name: scene.title(),
        stages: stages.collect::<Result<_>>()?,
    })
}

/// Runs that a message names at most.
const MOST_NAMED: usize = 12;

/// A scene, checked: its runs, their stages, and what is known of earlier ones.
pub(in crate::cli) struct Opened {
    /// One scene, or one for every run of its `[matrix]`.
    pub(in crate::cli) runs: Vec<Scene>,
    /// The stages of all runs.
    pub(in crate::cli) stages: Stages,
    /// What earlier runs have done.
    pub(in crate::cli) record: Record,
}

/// The text of a scene.
pub(in crate::cli) fn read_text(path: &Path) -> Result<String> {
    Ok(text::read(path, LARGEST_SCENE)?.text.into_owned())
}

/// The scene, its stages, and what is known of earlier runs; of a `[matrix]`, all runs or the one named `only`. All
/// that is wrong with it is one error.
pub(in crate::cli) fn opened(
    path: &Path,
    text: &str,
    quality: Quality,
    only: Option<&str>,
) -> Result<Opened> {
    guarded(path, || {
        let mut faults = Faults::default();
        let mut runs = Scene::all(text, &mut faults);
        let Some(first) = runs.first() else {
            faults.into_result(path)?;
            return Err(Error::data("scene", "no run").in_file(path));
        };
        let record = Record::open(&first.output.join("run.json"))?;
        if let Some(only) = only {
            runs = one_of(runs, only)?;
        }
        runs.iter_mut().for_each(|run| quality.apply(run));
        let mut stages = Stages::default();
        if runs.iter().all(|run| !run.name.is_empty()) {
            stages = check::stages(&runs, &record, &mut faults);
        }
        faults.into_result(path)?;
        Ok(Opened {
            runs,
            stages,
            record,
        })
    })
}

/// The run of this name.
fn one_of(mut runs: Vec<Scene>, name: &str) -> Result<Vec<Scene>> {
    let names: Vec<String> = runs.iter().map(Scene::variant).collect();
    if names == [""] {
        let found = format!("`{name}` of a scene without a [matrix]");
        return Err(Error::option("only", found, "no --only"));
    }
    match names.iter().position(|other| other == name) {
        Some(at) => Ok(vec![runs.swap_remove(at)]),
        None => {
            let meant = suggestion(name, names.iter().map(String::as_str));
            let some: Vec<&str> = names.iter().take(MOST_NAMED).map(String::as_str).collect();
            let expected = format!("a run of the [matrix], as {}{meant}", some.join(", "));
            Err(Error::option("only", format!("`{name}`"), expected))
        }
    }
}

/// Makes the paths of a scene relative to its file.
pub(in crate::cli) fn enter(folder: &Path) -> Result<()> {
    if folder.as_os_str().is_empty() {
        return Ok(());
    }
    std::env::set_current_dir(folder).map_err(Error::io(folder, "enter"))
}

fn overview_of(stage: Stage, record: &Record, seed: u64) -> Result<StageOverview> {
    let finished = record
        .finished(&Record::key(&stage.words, stage.seed_or(seed)))
        .unwrap_or_default();
    let of_output = |output: &PathBuf| {
        let mut written = finished.outputs.iter();
        written.find(|(path, _)| path.starts_with(output))
    };
    let ids = stage.outputs.iter().filter_map(of_output);
    Ok(StageOverview {
        command_line: command_line(&stage, seed),
        seed: stage.seed_or(seed),
        reads: stage.command.files()?.reads,
        seconds: finished.seconds,
        ids: ids.map(|(path, id)| (path.clone(), id.clone())).collect(),
        name: stage.title(),
        command: stage.command,
        outputs: stage.outputs,
    })
}

/// The command of a stage as a line for a shell.
pub(super) fn command_line(stage: &Stage, seed: u64) -> String {
    let words: Vec<_> = stage.words.iter().map(|word| quoted_word(word)).collect();
    let seed = stage.seed_or(seed);
    format!("mesotex {} --seed {seed}", words.join(" "))
}

/// A word of a command line as a shell takes it whole; of an option, the value.
pub(in crate::cli) fn quoted_word(word: &str) -> String {
    match word.split_once('=') {
        // The names of options are letters and dashes: others are refused before.
        Some((name, value)) if name.starts_with("--") => format!("{name}={}", quoted(value)),
        _ => quoted(word),
    }
}

/// A text as a shell takes it whole.
pub(in crate::cli) fn quoted(word: &str) -> String {
    shlex::try_quote(word).map_or_else(|_| word.to_owned(), |word| word.into_owned())
}
