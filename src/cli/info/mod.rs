//! `mesotex info`: what a file holds, and whether it is sound.

mod archive;
mod atlas;
mod bonn;
mod capture;
mod face_map;
mod fit;
mod image;
mod json;
pub(in crate::cli) mod kind;
mod leave_out;
mod map;
mod material;
mod mesh;
mod sample;

use std::path::{Path, PathBuf};

use clap::Args;

use crate::btf::fits::{hsh, ptm};
use crate::cli::info::kind::{Kind, frames_in, unknown};
use crate::cli::outcome::Outcome;
use crate::cli::run;
use crate::cli::session::{Common, Session};
use crate::cli::subcommand::Subcommand;
use crate::error::{Error, Result};
use crate::format::atomic::folder::{is_set_aside, repair};
use crate::format::lock::OutputLock;
use crate::format::npy;
use crate::render::held_out::LeaveOut;
use crate::textures::folder::TEXTURES_FOLDER;

/// Describe a file and check every number in it.
///
/// Takes a sample, a texton vocabulary, a surface texton space, a neighbour table, a surface texton
/// map, a face map, an atlas or other folder of textures, a mesh, an .npy array, an OpenEXR frame or any other image;
/// a folder of maps or a material file (which file plays which role, and why others play none); a capture,
/// by its folder or list; a .btf file of Bonn; a fit over lights (.ptm, .rti); a scene (its stages and products); a
/// table of directions, a camera path, and the JSON files of this program.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  mesotex info weave.sample
  mesotex info Bricks075_2K-PNG/
  mesotex info capture/dirs.lp
  mesotex info bunny.map.ply --against weave.space.npz
  mesotex info weave.sample --leave-out tenth
  mesotex info frames/frame.0001.exr --json")]
pub struct Arguments {
    /// The file or sample folder.
    pub path: PathBuf,
    /// A second file to compare ids with: a map's space or sample.
    #[arg(long)]
    pub against: Option<PathBuf>,
    /// Measure the error of a sample between its directions: leave each of its lights, views or scattered pairs out
    /// in turn (`each`), or a tenth of them at once, drawn by the seed (`tenth`), predict them from the others with
    /// each weighting, and report the errors by angle. At most 256 texels are compared and 256 directions left out.
    #[arg(long, value_enum, num_args = 0..=1, default_missing_value = "each")]
    pub leave_out: Option<LeaveOut>,
    #[command(flatten)]
    pub common: Common,
}

impl Subcommand for Arguments {
    fn common(&self) -> &Common {
        &self.common
    }

    fn run(&self, session: &Session) -> Result<Outcome> {
        self.repair(session)?;
        let kind = Kind::of(&self.path)?;
        // Refuse options that this kind of file has no use for.
        if self.against.is_some() && !matches!(kind, Kind::Map | Kind::FaceMap) {
            return Err(Error::option(
                "against",
                format!(
                    "{} is not a surface texton map or face map",
                    self.path.display()
                ),
                "a map as the first file",
            ));
        }
        if self.leave_out.is_some() && kind != Kind::Sample {
            let found = format!("{} is not a sample", self.path.display());
            return Err(Error::option("leave-out", found, "a sample"));
        }
        // Describe the file as what it is.
        match kind {
            Kind::Sample => self.sample(session),
            Kind::Atlas => atlas::describe(&self.path),
            Kind::Textures => atlas::describe_textures(&self.path, &TEXTURES_FOLDER),
            Kind::FaceMap => face_map::describe(&self.path, self.against.as_deref()),
            Kind::Map => map::describe(&self.path, self.against.as_deref()),
            Kind::Mesh => mesh::describe(&self.path, session.progress()),
            Kind::Archive => archive::describe(&self.path),
            Kind::Array => array(&self.path),
            Kind::Image => image::describe(&self.path),
            Kind::Material => material::describe(&self.path),
            Kind::Scene => run::describe(&self.path, session),
            Kind::Bonn => bonn::describe(&self.path),
            Kind::Capture => capture::describe(&self.path),
            Kind::Directions => capture::describe_directions(&self.path),
            Kind::CameraPath => json::camera_path(&self.path),
            Kind::Json => json::describe(&self.path, session.progress()),
            Kind::Ptm => fit::describe(&self.path, "PTM", ptm::read),
            Kind::Hsh => fit::describe(&self.path, "HSH", hsh::read),
            Kind::Frames => frames(&self.path),
        }
    }
}

impl Arguments {
    fn sample(&self, session: &Session) -> Result<Outcome> {
        let outcome = sample::describe(&self.path, session.progress())?;
        match self.leave_out {
            None => Ok(outcome),
            Some(leave_out) => leave_out::add(
                outcome,
                &self.path,
                leave_out,
                session.seed(),
                session.progress(),
            ),
        }
    }

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

/// A folder of frames: the first and the last, and what the first holds.
fn frames(folder: &Path) -> Result<Outcome> {
    let frames = frames_in(folder)?;
    let (Some(first), Some(last)) = (frames.first(), frames.last()) else {
        return Err(unknown(folder));
    };
    let outcome = image::describe(first)?.figure("kind", "frames");
    Ok(outcome
        .line(format!(
            "the first of {} frames, {} to {}",
            frames.len(),
            first.display(),
            last.display()
        ))
        .figure("frames", frames.len()))
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
