//! A stage as tasks: one, or the parts it is split into.

use std::path::{Path, PathBuf};

use crate::cli::Command;
use crate::cli::outputs::Product;
use crate::cli::plan::graph::joined;
use crate::cli::render;
use crate::cli::run::check::Stage;
use crate::cli::run::cost::Cost;
use crate::cli::run::sizes::Sizes;
use crate::error::Result;
use crate::render::frame_range::Shard;
use crate::render::plan::frame_range;

/// A task before it has its place among others; paths are relative to the scene.
pub(super) struct Piece {
    /// Which part of the stage it is; empty for the whole.
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
    /// Frames in a folder that several tasks may fill.
    Frames(Frames),
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
            Self::File(path) | Self::Folder(path) => Some(path),
            Self::Frames(_) => None,
        }
    }

    /// The file or folder, that of frames too.
    pub(super) fn place(&self) -> &Path {
        match self {
            Self::File(path) | Self::Folder(path) => path,
            Self::Frames(frames) => &frames.folder,
        }
    }

    /// The same, in a scene's folder.
    pub(super) fn inside(&self, folder: &Path) -> Self {
        match self {
            Self::File(path) => Self::File(joined(folder, path)),
            Self::Folder(path) => Self::Folder(joined(folder, path)),
            Self::Frames(frames) => Self::Frames(Frames {
                folder: joined(folder, &frames.folder),
                ..frames.clone()
            }),
        }
    }
}

/// The tasks of a stage, split into so many parts at most.
pub(super) fn pieces(stage: &Stage, sizes: &mut Sizes<'_>, shards: u32) -> Result<Vec<Piece>> {
    match &stage.command {
        Command::Render(arguments) => renderings(stage, arguments, sizes, shards),
        _ => Ok(vec![whole(stage, sizes)?]),
    }
}

/// A stage in one task.
fn whole(stage: &Stage, sizes: &mut Sizes<'_>) -> Result<Piece> {
    let files = stage.command.files()?;
    let makes = files.writes.iter().map(|output| {
        let path = output.path.clone();
        match output.product {
            Product::File(_) => Made::File(path),
            Product::Folder(_) | Product::NewFolder | Product::Frames => Made::Folder(path),
        }
    });
    Ok(Piece {
        part: String::new(),
        words: stage.words.clone(),
        makes: makes.collect(),
        cost: sizes.cost_of(stage, false),
        reads: files.reads,
    })
}

/// Frames dealt out among tasks that fill one folder; frames that are there are kept.
fn renderings(
    stage: &Stage,
    arguments: &render::Arguments,
    sizes: &mut Sizes<'_>,
    shards: u32,
) -> Result<Vec<Piece>> {
    let numbers: Vec<u32> = frame_range(&arguments.options)?.numbers().collect();
    let count = match arguments.options.shard {
        Some(_) => 1,
        None => shards.min(numbers.len() as u32),
    };
    let parts = (0..count).map(|index| {
        let shard = Shard { index, count };
        let split = arguments.options.shard.or((count > 1).then_some(shard));
        let places = numbers.iter().enumerate();
        let own = places.filter(|(place, _)| split.is_none_or(|shard| shard.takes(*place)));
        let own: Vec<u32> = own.map(|(_, number)| *number).collect();
        let mut piece = whole(stage, sizes)?;
        piece
            .makes
            .retain(|made| made.path() != Some(&arguments.output));
        if index > 0 {
            // The mesh with the colours of the first frame is the same in every part.
            piece.makes.clear();
        }
        piece
            .makes
            .extend(frames(arguments, &own).map(Made::Frames));
        if !arguments.options.skip_existing {
            piece.words.push("--skip-existing".into());
        }
        if count > 1 {
            piece.words.push(format!("--shard={shard}"));
            piece.part = format!("{index}-of-{count}");
            piece.cost = sizes.cost_of_frames(arguments, own.len());
        }
        Ok(piece)
    });
    parts.collect()
}

fn frames(arguments: &render::Arguments, numbers: &[u32]) -> Option<Frames> {
    let (first, last) = (*numbers.first()?, *numbers.last()?);
    Some(Frames {
        folder: arguments.output.clone(),
        pattern: arguments.options.pattern.0.clone(),
        ends: [first, last],
        step: numbers.get(1).map_or(1, |second| second - first),
    })
}
