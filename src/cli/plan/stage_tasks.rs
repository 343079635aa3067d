//! A stage as tasks: one, or the parts it is split into.

use std::path::{Path, PathBuf};

use crate::cli::outputs::Product;
use crate::cli::run::check::Stage;
use crate::cli::run::cost::Cost;
use crate::cli::run::draft::path_word;
use crate::cli::run::sizes::Sizes;
use crate::cli::subcommand::Subcommand;
use crate::cli::{Command, bake, import, machine, render, textons};
use crate::error::Result;
use crate::render::plan::frame_range;
use crate::shard::Shard;

/// A task before it has its place among others; paths are relative to the scene.
pub(super) struct StageTask {
    /// Which shard of the stage it is, or the joining of the parts; empty for the whole.
    pub(super) part: String,
    /// The command line, without the program.
    pub(super) words: Vec<String>,
    /// What it reads.
    pub(super) reads: Vec<PathBuf>,
    /// What it makes.
    pub(super) makes: Vec<Made>,
    /// What it takes.
    pub(super) cost: Option<Cost>,
}

/// Something that a task makes.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Made {
    /// A file.
    File(PathBuf),
    /// A folder, as a whole.
    Folder(PathBuf),
    /// What another task of the stage takes up.
    Part(PathBuf, PartKind),
    /// Frames in a folder that several tasks may fill.
    Frames(Frames),
}

/// What a part is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PartKind {
    /// A file.
    File,
    /// A folder.
    Folder,
}

/// Frames of one task.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Frames {
    /// Their folder.
    pub(super) folder: PathBuf,
    /// Their names, a run of `#` for the number.
    pub(super) pattern: String,
    /// The first and the last number.
    pub(super) ends: [u32; 2],
    /// From one number to the next.
    pub(super) step: u32,
}

impl Made {
    /// The file or folder that no other task makes.
    pub(super) fn path(&self) -> Option<&Path> {
        match self {
            Self::File(path) | Self::Folder(path) | Self::Part(path, _) => Some(path),
            Self::Frames(_) => None,
        }
    }

    /// The file or folder, that of frames too.
    pub(super) fn place(&self) -> &Path {
        match self {
            Self::File(path) | Self::Folder(path) | Self::Part(path, _) => path,
            Self::Frames(frames) => &frames.folder,
        }
    }

    /// The same, in a scene's folder.
    pub(super) fn inside(&self, folder: &Path) -> Self {
        match self {
            Self::File(path) => Self::File(joined(folder, path)),
            Self::Folder(path) => Self::Folder(joined(folder, path)),
            Self::Part(path, kind) => Self::Part(joined(folder, path), *kind),
            Self::Frames(frames) => Self::Frames(Frames {
                folder: joined(folder, &frames.folder),
                ..frames.clone()
            }),
        }
    }
}

/// The tasks of a stage, split into this many shards at most.
pub(super) fn stage_tasks(
    stage: &Stage,
    sizes: &mut Sizes<'_>,
    shards: u32,
) -> Result<Vec<StageTask>> {
    match &stage.command {
        Command::Bake(arguments) => bakes(stage, arguments, sizes, shards),
        Command::Import(arguments) => imports(stage, arguments, sizes, shards),
        Command::Textons(arguments) => analyses(stage, arguments, sizes, shards),
        Command::Render(arguments) => renderings(stage, arguments, sizes, shards),
        _ => Ok(vec![whole(stage, sizes)?]),
    }
}

/// A stage in one task.
fn whole(stage: &Stage, sizes: &mut Sizes<'_>) -> Result<StageTask> {
    let files = stage.command.files()?;
    let makes = files.writes.iter().map(|output| {
        let path = output.path.clone();
        match output.product {
            Product::File(_) => Made::File(path),
            Product::Folder(_) | Product::NewFolder | Product::Frames => Made::Folder(path),
        }
    });
    Ok(StageTask {
        part: String::new(),
        words: stage.words.clone(),
        makes: makes.collect(),
        cost: sizes.cost_of(stage, false),
        reads: files.reads,
    })
}

/// A bake in shards, and the run that joins their parts.
fn bakes(
    stage: &Stage,
    arguments: &bake::Arguments,
    sizes: &mut Sizes<'_>,
    shards: u32,
) -> Result<Vec<StageTask>> {
    let whole = whole(stage, sizes)?;
    let views = arguments.options.views.directions()?.len() as u32;
    let count = views.min(shards);
    // What is drawn beside the sample needs the whole bake in one run.
    let is_alone = arguments.preview.is_some() || arguments.surface.is_some();
    let is_one_already = arguments.shard.is_some() || !arguments.reduce.is_empty();
    if count < 2 || is_alone || is_one_already {
        return Ok(vec![whole]);
    }
    let costs = sizes.costs_of_bake_shards(arguments, count);
    let split = Split::of_sample(stage, &arguments.material, &arguments.output, costs);
    Ok(split.tasks(whole, count))
}

/// An import in shards, and the run that joins their parts.
fn imports(
    stage: &Stage,
    arguments: &import::Arguments,
    sizes: &mut Sizes<'_>,
    shards: u32,
) -> Result<Vec<StageTask>> {
    let whole = whole(stage, sizes)?;
    let count = sizes.most_shards_of_import(arguments).min(shards);
    if count < 2 {
        return Ok(vec![whole]);
    }
    let costs = sizes.costs_of_import_shards(arguments, whole.cost, count);
    let split = Split::of_sample(stage, &arguments.paths, &arguments.output, costs);
    Ok(split.tasks(whole, count))
}

/// An analysis in shards, and the run that joins their parts.
fn analyses(
    stage: &Stage,
    arguments: &textons::Arguments,
    sizes: &mut Sizes<'_>,
    shards: u32,
) -> Result<Vec<StageTask>> {
    let mut whole = whole(stage, sizes)?;
    let memory = stated_memory(arguments);
    whole.words.extend(memory.clone());
    let count = sizes.most_shards_of_textons(arguments).min(shards);
    let is_one_already = arguments.shard.is_some() || !arguments.reduce.is_empty();
    if count < 2 || is_one_already {
        return Ok(vec![whole]);
    }
    // The options are those of the parts; what is written beside the vocabulary is for the reduction.
    let (beside, options): (Vec<String>, Vec<String>) = options_of(stage)
        .chain(memory)
        .partition(|word| is_one_of(word, &["report", "montage", "label-map"]));
    let head = stage.words[..2].to_vec();
    let split = Split {
        part: [&head[..], &options].concat(),
        joined: [&head[..], &beside].concat(),
        output: &arguments.output,
        ending: ".npz",
        kind: PartKind::File,
        costs: sizes.costs_of_textons_shards(arguments, count),
    };
    Ok(split.tasks(whole, count))
}

/// The memory of an analysis that does not say its own: that of a run on this machine. Left to the machine of each
/// task, it would decide how the analysis is done, differently on machines of other sizes.
fn stated_memory(arguments: &textons::Arguments) -> Option<String> {
    let memory = match arguments.options.memory {
        None => machine::quarter_of_memory()?,
        Some(_) => return None,
    };
    Some(format!("--memory={}MiB", memory.0 >> 20))
}

/// The options of a stage, each a word, but for its output.
fn options_of(stage: &Stage) -> impl Iterator<Item = String> {
    let options = stage.words.iter().filter(|word| word.starts_with("--"));
    options.cloned()
}

/// Whether a word is one of these options with its value.
fn is_one_of(word: &str, options: &[&str]) -> bool {
    let name = word.trim_start_matches("--").split('=').next();
    options.iter().any(|option| name == Some(option))
}

/// A stage that writes parts, which a last run joins.
struct Split<'a> {
    /// The command line of parts, without output and shard.
    part: Vec<String>,
    /// That of the last run, without output and parts.
    joined: Vec<String>,
    output: &'a Path,
    /// What the output ends in.
    ending: &'static str,
    /// What a part is.
    kind: PartKind,
    /// What a part takes, and the last run.
    costs: Option<[Cost; 2]>,
}

impl<'a> Split<'a> {
    /// A stage that makes a sample of some files, with parts that are samples themselves.
    fn of_sample(
        stage: &Stage,
        sources: impl IntoIterator<Item = &'a PathBuf>,
        output: &'a Path,
        costs: Option<[Cost; 2]>,
    ) -> Self {
        let command = stage.words[0].clone();
        let sources = sources.into_iter().map(|path| path_word(path));
        let head = std::iter::once(command.clone()).chain(sources);
        Self {
            part: head.chain(options_of(stage)).collect(),
            joined: vec![command],
            output,
            ending: ".sample",
            kind: PartKind::Folder,
            costs,
        }
    }

    fn tasks(self, whole: StageTask, count: u32) -> Vec<StageTask> {
        let paths: Vec<PathBuf> = (0..count).map(|index| self.path(index, count)).collect();
        let output = |path: &Path| ["-o".to_owned(), path_word(path)];
        let parts = (0..count).zip(&paths).map(|(index, path)| {
            let mut words = self.part.clone();
            words.extend(output(path));
            words.push(format!("--shard={}", Shard { index, count }));
            StageTask {
                part: format!("{index}of{count}"),
                words,
                reads: whole.reads.clone(),
                makes: vec![Made::Part(path.clone(), self.kind)],
                cost: self.costs.map(|costs| costs[0]),
            }
        });
        let mut tasks: Vec<StageTask> = parts.collect();
        let mut words = self.joined.clone();
        words.extend(output(self.output));
        let parts = paths.iter().map(|path| path.to_string_lossy());
        words.extend(parts.map(|path| format!("--reduce={path}")));
        // An analysis looks at the chosen images of its sample; parts of a sample are all that it is.
        let also = match self.kind {
            PartKind::File => whole.reads,
            PartKind::Folder => Vec::new(),
        };
        tasks.push(StageTask {
            part: "reduce".into(),
            words,
            reads: also.into_iter().chain(paths).collect(),
            makes: whole.makes,
            cost: self.costs.map(|costs| costs[1]),
        });
        tasks
    }

    /// `out/a.textons.0of3.npz` for `out/a.textons.npz`, and `out/a.0of3` for the folder `out/a.sample`.
    fn path(&self, index: u32, count: u32) -> PathBuf {
        let name = self.output.to_string_lossy();
        let stem = name.strip_suffix(self.ending).unwrap_or(&name);
        let ending = match self.kind {
            PartKind::File => self.ending,
            PartKind::Folder => "",
        };
        format!("{stem}.{index}of{count}{ending}").into()
    }
}

/// Frames dealt out among tasks that fill one folder; frames that are there are kept.
fn renderings(
    stage: &Stage,
    arguments: &render::Arguments,
    sizes: &mut Sizes<'_>,
    shards: u32,
) -> Result<Vec<StageTask>> {
    let numbers: Vec<u32> = frame_range(&arguments.options)?.numbers().collect();
    let count = match arguments.options.files.shard {
        Some(_) => 1,
        None => shards.min(numbers.len() as u32),
    };
    let parts = (0..count).map(|index| {
        let shard = Shard { index, count };
        let split = arguments
            .options
            .files
            .shard
            .or((count > 1).then_some(shard));
        let places = numbers.iter().enumerate();
        let own = places.filter(|(place, _)| split.is_none_or(|shard| shard.takes(*place)));
        let own: Vec<u32> = own.map(|(_, number)| *number).collect();
        let mut task = whole(stage, sizes)?;
        task.makes
            .retain(|made| made.path() != Some(&arguments.output));
        if index > 0 {
            // The mesh with the colours of the first frame is the same in every part.
            task.makes.clear();
        }
        task.makes.extend(frames(arguments, &own).map(Made::Frames));
        if !arguments.options.files.skip_existing {
            task.words.push("--skip-existing".into());
        }
        if count > 1 {
            task.words.push(format!("--shard={shard}"));
            task.part = format!("{index}of{count}");
            task.cost = sizes.cost_of_frames(arguments, own.len());
        }
        Ok(task)
    });
    parts.collect()
}

fn frames(arguments: &render::Arguments, numbers: &[u32]) -> Option<Frames> {
    let (first, last) = (*numbers.first()?, *numbers.last()?);
    Some(Frames {
        folder: arguments.output.clone(),
        pattern: arguments.options.files.pattern.0.clone(),
        ends: [first, last],
        step: numbers.get(1).map_or(1, |second| second - first),
    })
}

/// A path of a folder; `.` and nothing are the folder of the plan.
pub(super) fn joined(folder: &Path, path: &Path) -> PathBuf {
    match folder == Path::new("") || folder == Path::new(".") {
        true => path.to_path_buf(),
        false => folder.join(path),
    }
}
