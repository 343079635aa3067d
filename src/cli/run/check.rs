//! The whole scene, checked before its first stage: every option by the rules of its command, every
//! file that must be there, every name that is used twice.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use clap::{ArgAction, CommandFactory};
use toml::Value;

use crate::cli::failure::likely_names::suggestion;
use crate::cli::failure::refusal::Refusal;
use crate::cli::outputs::Files;
use crate::cli::run::document::Key;
use crate::cli::run::draft::Draft;
use crate::cli::run::faults::{Faults, Place};
use crate::cli::run::record::Record;
use crate::cli::run::scene::Scene;
use crate::cli::subcommand::Subcommand;
use crate::cli::{Command, CommandLine, unused_options};
use crate::error::Error;

/// Options that are the scene's to say, or `run`'s own.
const NOT_OF_A_STAGE: [&str; 8] = [
    "output", "seed", "threads", "quiet", "json", "once", "help", "version",
];

/// Options that make a part of a product in place of the whole.
const OF_PARTS: [&str; 2] = ["shard", "reduce"];

/// A stage ready to run.
pub struct Stage {
    /// What the user reads: the command, and for renderings their name.
    pub name: String,
    /// The command line, without the program.
    pub words: Vec<String>,
    /// The command line, parsed.
    pub command: Command,
    /// Its main output.
    pub output: PathBuf,
    /// All its outputs.
    pub outputs: Vec<PathBuf>,
    /// Its seed, where it is not that of the whole run.
    pub seed: Option<u64>,
    /// The values of `[matrix]` that reach it; empty where nothing varies.
    pub variant: String,
    /// Which stage of its run it is.
    pub place: usize,
}

impl Stage {
    /// What the user reads: the name, and the varied values.
    pub fn title(&self) -> String {
        title(&self.name, &self.variant)
    }

    /// Its seed; `whole` is that of the whole run.
    pub fn seed_or(&self, whole: u64) -> u64 {
        self.seed.unwrap_or(whole)
    }
}

/// What a stage is called with the varied values that reach it.
pub fn title(name: &str, variant: &str) -> String {
    match variant {
        "" => name.to_owned(),
        variant => format!("{name} {variant}"),
    }
}

/// The stages of a scene's runs, and which of them each run has.
#[derive(Default)]
pub struct Stages {
    /// Every stage once, run after run.
    pub list: Vec<Stage>,
    /// The places in the list of every run's stages.
    pub of_runs: Vec<Vec<usize>>,
}

/// The stages of all runs of a scene; everything wrong with them goes to `faults`. Runs share the stages that the same
/// values reach.
pub fn stages(runs: &[Scene], record: &Record, faults: &mut Faults) -> Stages {
    let mut stages = Stages::default();
    let mut checked = Checked {
        record,
        made: HashMap::new(),
        read: Vec::new(),
    };
    let mut seen: HashMap<(Vec<String>, Option<u64>), Option<usize>> = HashMap::new();
    for scene in runs {
        let mut of_run = Vec::new();
        for (place, draft) in scene.drafts(faults).into_iter().enumerate() {
            let words = draft.words(&[]);
            let at = *seen.entry((words.clone(), draft.seed)).or_insert_with(|| {
                let command = command_of(&draft, faults)?;
                let outputs = checked.take(scene, &draft, &command, faults);
                stages.list.push(Stage {
                    name: draft.name,
                    words,
                    command,
                    output: draft.output,
                    outputs,
                    seed: draft.seed,
                    variant: draft.variant,
                    place,
                });
                Some(stages.list.len() - 1)
            });
            of_run.extend(at);
        }
        stages.of_runs.push(of_run);
    }
    checked.check_inputs_are_kept(faults);
    stages
}

/// The command of a stage. Every option it cannot take is named; the rest are checked without it.
fn command_of(draft: &Draft, faults: &mut Faults) -> Option<Command> {
    let mut left_out = unknown_options(draft, faults);
    loop {
        let words = draft.words(&left_out);
        let objection = match parse(&words) {
            Ok(command) => return Some(command),
            Err(objection) => objection,
        };
        let key = draft.options().find(|key| {
            Some(&key.name) == objection.option.as_ref() && !left_out.contains(&key.name)
        });
        match key {
            Some(key) => {
                faults.option(&draft.section.place(key), objection.says);
                left_out.push(key.name.clone());
            }
            None => {
                faults.option(&draft.section.head(), objection.says);
                return None;
            }
        }
    }
}

/// What a command has against its options, and against which.
struct Objection {
    option: Option<String>,
    says: String,
}

impl Objection {
    fn of(error: &clap::Error, words: &[String]) -> Self {
        match Refusal::of(error, words) {
            Some(refusal) => Self {
                option: refusal.option,
                says: refusal.says,
            },
            None => Self {
                option: None,
                says: error.render().to_string(),
            },
        }
    }
}

fn parse(words: &[String]) -> Result<Command, Objection> {
    let words: Vec<String> = std::iter::once("mesotex".to_owned())
        .chain(words.iter().cloned())
        .collect();
    let (command, given) =
        CommandLine::read(&words).map_err(|error| Objection::of(&error, &words))?;
    let checked = command
        .check()
        .and_then(|()| unused_options::check(&command, &given));
    match checked {
        Ok(()) => Ok(command),
        Err(error) => Err(Objection {
            option: match &error {
                Error::Option { option, .. } => Some(option.clone()),
                _ => None,
            },
            says: error.to_string(),
        }),
    }
}

/// Keys of a section that are no options of its command, or are set to what such an option cannot be.
fn unknown_options(draft: &Draft, faults: &mut Faults) -> Vec<String> {
    let root = CommandLine::command();
    let Some(command) = root.find_subcommand(draft.command) else {
        return Vec::new();
    };
    let known: Vec<_> = command
        .get_arguments()
        .filter_map(|argument| Some((argument.get_long()?, argument)))
        .filter(|(name, _)| !NOT_OF_A_STAGE.contains(name) && !makes_a_part(draft, name))
        .collect();
    let mut wrong = Vec::new();
    for key in draft.options() {
        let argument = known.iter().find(|(name, _)| *name == key.name);
        let says = match argument {
            None => unknown(draft, key, known.iter().map(|(name, _)| *name)),
            Some((_, argument)) => {
                let is_flag = matches!(argument.get_action(), ArgAction::SetTrue);
                match wrong_value(key, is_flag) {
                    Some(says) => says,
                    None => continue,
                }
            }
        };
        faults.option(&draft.section.place(key), says);
        wrong.push(key.name.clone());
    }
    wrong
}

/// Whether an option would leave a part where later stages read the whole. Frames are whole in any shard.
fn makes_a_part(draft: &Draft, option: &str) -> bool {
    draft.command != "render" && OF_PARTS.contains(&option)
}

fn unknown<'a>(draft: &Draft, key: &Key, known: impl Iterator<Item = &'a str>) -> String {
    let command = draft.command;
    if key.name == "once" {
        return "not allowed in a stage; `mesotex run` skips finished stages by itself".to_owned();
    }
    if NOT_OF_A_STAGE.contains(&key.name.as_str()) {
        return format!(
            "not allowed in a stage; outputs are set at the top of the scene, everything else by `mesotex run --{}`",
            key.name
        );
    }
    if makes_a_part(draft, &key.name) {
        return "not allowed in a stage; `mesotex plan --shards` splits stages".to_owned();
    }
    let own = [
        draft.input_key,
        if command == "render" { "name" } else { "" },
        "seed",
    ];
    let known = known.chain(own.into_iter().filter(|name| !name.is_empty()));
    let meant = suggestion(&key.name, known);
    format!("no option --{} of `mesotex {command}`{meant}", key.name)
}

/// Why a value cannot be an option's: flags are true or false, and nothing else is.
fn wrong_value(key: &Key, is_flag: bool) -> Option<String> {
    let value = &key.value;
    let fits = match value {
        Value::Boolean(_) => is_flag,
        Value::String(_) | Value::Integer(_) | Value::Float(_) => !is_flag,
        Value::Array(values) => {
            let plain = |value: &Value| {
                matches!(
                    value,
                    Value::String(_) | Value::Integer(_) | Value::Float(_)
                )
            };
            !is_flag && values.iter().all(plain)
        }
        Value::Table(_) | Value::Datetime(_) => false,
    };
    let expected = if is_flag {
        "true or false"
    } else {
        "a number, a string or a list of them"
    };
    (!fits).then(|| format!("`{value}`; expected {expected}"))
}

/// What the stages seen so far read and write.
struct Checked<'a> {
    record: &'a Record,
    made: HashMap<PathBuf, Place>,
    read: Vec<PathBuf>,
}

impl Checked<'_> {
    /// Checks the files of the next stage; returns those it writes.
    fn take(
        &mut self,
        scene: &Scene,
        draft: &Draft,
        command: &Command,
        faults: &mut Faults,
    ) -> Vec<PathBuf> {
        let head = draft.section.head();
        let files = match command.files() {
            Ok(files) => files,
            Err(error) => {
                let place = match &error {
                    Error::Io { path, .. } => place_of(scene, draft, path),
                    _ => head,
                };
                faults.error(&place, &error);
                // Later stages are not at fault.
                self.made.insert(draft.output.clone(), place);
                return Vec::new();
            }
        };
        for input in &files.reads {
            if self.makes(input) {
                continue;
            }
            if !input.exists() {
                faults.data(
                    &place_of(scene, draft, input),
                    format!("{} does not exist", input.display()),
                );
            }
            self.read.push(input.clone());
        }
        if let Err(error) = self
            .beside_made(&files)
            .check(Some(&scene.output), |path| self.record.wrote(path))
        {
            faults.error(&head, &error);
        }
        let outputs: Vec<PathBuf> = files.writes.into_iter().map(|output| output.path).collect();
        for output in &outputs {
            if let Some(first) = self.made.get(output) {
                let says = format!(
                    "{} is written by line {} already; choose another name",
                    output.display(),
                    first.line
                );
                faults.data(&head, says);
            }
            self.made.insert(output.clone(), head.clone());
        }
        outputs
    }

    /// Whether an earlier stage writes `path`, or the folder it lies in.
    fn makes(&self, path: &Path) -> bool {
        path.ancestors().any(|part| self.made.contains_key(part))
    }

    /// The files of a stage without those that earlier stages make.
    fn beside_made(&self, files: &Files) -> Files {
        let mut files = files.clone();
        files.reads.retain(|input| !self.makes(input));
        files
    }

    /// Refuses a scene of which one stage would write over what another reads.
    fn check_inputs_are_kept(&self, faults: &mut Faults) {
        for input in &self.read {
            if let Some(place) = self.made.get(input) {
                faults.data(
                    place,
                    format!(
                        "{} would be written, but is an input of the scene",
                        input.display()
                    ),
                );
            }
        }
    }
}

/// The key of the scene that names an input, as far as it can be told.
fn place_of(scene: &Scene, draft: &Draft, input: &Path) -> Place {
    let names = |key: &&Key| match &key.value {
        Value::String(path) => input.starts_with(path),
        Value::Array(paths) => paths
            .iter()
            .any(|path| path.as_str().is_some_and(|path| input == Path::new(path))),
        _ => false,
    };
    if let Some(key) = draft.section.keys.iter().find(names) {
        return draft.section.place(key);
    }
    match scene
        .document
        .keys
        .iter()
        .filter(|key| key.name != "output")
        .find(names)
    {
        Some(key) => key.place(),
        None => draft.section.head(),
    }
}
