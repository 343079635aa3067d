//! A scene opened: its stages, and what is known of those that were run.

use std::path::{Path, PathBuf};

use crate::cli::Command;
use crate::cli::run::check::{self, Stage};
use crate::cli::run::faults::Faults;
use crate::cli::run::quality::Quality;
use crate::cli::run::record::Record;
use crate::cli::run::scene::Scene;
use crate::cli::session::Session;
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
    session: &Session,
) -> Result<Overview> {
    let text = read_text(path)?;
    enter(path.parent().unwrap_or(Path::new("")))?;
    let (scene, stages, record) = opened(path, &text, quality)?;
    let seed = session.or_seed(scene.seed).seed();
    let stages = stages
        .into_iter()
        .map(|stage| overview_of(stage, &record, seed));
    Ok(Overview {
        name: scene.name,
        stages: stages.collect::<Result<_>>()?,
    })
}

/// The text of a scene.
pub(super) fn read_text(path: &Path) -> Result<String> {
    Ok(text::read(path, LARGEST_SCENE)?.text.into_owned())
}

/// The scene, its stages, and what is known of earlier runs; all that is wrong with it is one error.
pub(super) fn opened(
    path: &Path,
    text: &str,
    quality: Quality,
) -> Result<(Scene, Vec<Stage>, Record)> {
    guarded(path, || {
        let mut faults = Faults::default();
        let mut scene = Scene::parse(text, &mut faults);
        quality.apply(&mut scene);
        let record = Record::open(&scene.output.join("run.json"))?;
        let mut stages = Vec::new();
        if !scene.name.is_empty() {
            stages = check::stages(&scene, &record, &mut faults);
        }
        faults.into_result(path)?;
        Ok((scene, stages, record))
    })
}

/// Makes the paths of a scene relative to its file.
pub(super) fn enter(folder: &Path) -> Result<()> {
    if folder.as_os_str().is_empty() {
        return Ok(());
    }
    std::env::set_current_dir(folder).map_err(Error::io(folder, "enter"))
}

fn overview_of(stage: Stage, record: &Record, seed: u64) -> Result<StageOverview> {
    let finished = record
        .finished(&Record::key(&stage.words, seed))
        .unwrap_or_default();
    let of_output = |output: &PathBuf| {
        let mut written = finished.outputs.iter();
        written.find(|(path, _)| path.starts_with(output))
    };
    let ids = stage.outputs.iter().filter_map(of_output);
    Ok(StageOverview {
        command_line: command_line(&stage, seed),
        seed,
        reads: stage.command.files()?.reads,
        seconds: finished.seconds,
        ids: ids.map(|(path, id)| (path.clone(), id.clone())).collect(),
        name: stage.name,
        command: stage.command,
        outputs: stage.outputs,
    })
}

/// The command of a stage as a line for a shell.
pub(super) fn command_line(stage: &Stage, seed: u64) -> String {
    let words: Vec<_> = stage.words.iter().map(|word| quoted_word(word)).collect();
    format!("mesotex {} --seed {seed}", words.join(" "))
}

/// A word of a command line as a shell takes it whole; of an option, the value.
fn quoted_word(word: &str) -> String {
    match word.split_once('=') {
        // The names of options are letters and dashes: others are refused before.
        Some((name, value)) if name.starts_with("--") => format!("{name}={}", quoted(value)),
        _ => quoted(word),
    }
}

/// A text as a shell takes it whole.
pub(super) fn quoted(word: &str) -> String {
    shlex::try_quote(word).map_or_else(|_| word.to_owned(), |word| word.into_owned())
}
