//! `mesotex info`: what a file holds, and whether it is sound.

mod archive;
mod image;
mod map;
mod mesh;
mod sample;

use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};

use clap::Args;

use crate::btf::sample::DESCRIPTION;
use crate::cli::outcome::Outcome;
use crate::cli::session::{Common, Session};
use crate::error::{Error, Result};
use crate::format::atomic::folder::{is_set_aside, repair};
use crate::format::lock::OutputLock;
use crate::format::npy;

/// What a file holds, and whether it is sound: every number is read and checked.
///
/// Takes a sample, a texton vocabulary, a surface texton space, a neighbour table, a surface texton
/// map, a mesh, an .npy array, an OpenEXR frame or any other image.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  mesotex info weave.sample
  mesotex info bunny.map.ply --against weave.space.npz
  mesotex info frames/frame.0001.exr --json")]
pub struct Arguments {
    /// The file or sample folder.
    pub path: PathBuf,
    /// A second file that the first should belong to: a map's space or sample.
    #[arg(long)]
    pub against: Option<PathBuf>,
    #[command(flatten)]
    pub common: Common,
}

impl Arguments {
    /// Runs the command.
    pub fn run(&self, session: &Session) -> Result<Outcome> {
        self.repair(session)?;
        let kind = Kind::of(&self.path)?;
        if let (Some(_), false) = (&self.against, kind == Kind::Map) {
            return Err(Error::option(
                "against",
                format!("{} is no surface texton map", self.path.display()),
                "a map as the first file",
            ));
        }
        match kind {
            Kind::Sample => sample::describe(&self.path, session.progress()),
            Kind::Map => map::describe(&self.path, self.against.as_deref()),
            Kind::Mesh => mesh::describe(&self.path, session.progress()),
            Kind::Archive => archive::describe(&self.path),
            Kind::Array => array(&self.path),
            Kind::Image => image::describe(&self.path),
        }
    }
}

impl Arguments {
    /// Puts a sample back that an interrupted replacement left aside.
    fn repair(&self, session: &Session) -> Result<()> {
        if self.path.exists() || !is_set_aside(&self.path) {
            return Ok(());
        }
        let _lock = OutputLock::acquire(&self.path)?;
        if repair(&self.path)? {
            session.progress().warn(format!(
                "{}: a run was killed while it replaced this folder; the earlier one was put back",
                self.path.display()
            ));
        }
        Ok(())
    }
}

/// What a path holds, by its first bytes and, where they do not tell, its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Sample,
    Map,
    Mesh,
    Archive,
    Array,
    Image,
}

impl Kind {
    fn of(path: &Path) -> Result<Self> {
        if path.join(DESCRIPTION).is_file() {
            return Ok(Self::Sample);
        }
        fs::metadata(path).map_err(Error::io(path, "read"))?;
        let extension = path
            .extension()
            .unwrap_or_default()
            .to_string_lossy()
            .to_lowercase();
        match extension.as_str() {
            "npy" => Ok(Self::Array),
            "npz" => Ok(Self::Archive),
            "ply" if is_map(path)? => Ok(Self::Map),
            "ply" | "obj" | "stl" | "off" | "glb" | "gltf" | "gz" => Ok(Self::Mesh),
            _ => Ok(Self::Image),
        }
    }
}

/// Whether a PLY says in its header that it is a surface texton map.
fn is_map(path: &Path) -> Result<bool> {
    let mut start = Vec::new();
    let file = fs::File::open(path).map_err(Error::io(path, "read"))?;
    file.take(4096)
        .read_to_end(&mut start)
        .map_err(Error::io(path, "read"))?;
    let mark = b"\ncomment exemplar ";
    Ok(start.windows(mark.len()).any(|window| window == mark))
}

fn array(path: &Path) -> Result<Outcome> {
    let header = npy::read_header(path)?;
    Ok(Outcome::default()
        .line(format!(
            "array of `{}`, shape {:?}",
            header.dtype, header.shape
        ))
        .figure("kind", "array")
        .figure("dtype", header.dtype)
        .figure("shape", header.shape))
}
