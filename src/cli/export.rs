//! `mesotex export`: sample → a format that other programs read.

mod image_set;

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use crate::btf::image_sets::ImageSet;
use crate::btf::sample::files_of;
use crate::cli::outcome::Outcome;
use crate::cli::outputs::{Files, Product};
use crate::cli::session::{Common, Session};
use crate::error::Result;

/// Write a sample in a format that other programs read.
///
/// OUT is exactly the folder written; only an empty folder is replaced. Values become reflectance with the light's
/// cosine in it: a white plane facing the light has 1.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  mesotex export weave.sample --to folder -o weave-images
  mesotex export impalla.sample --to ubo2003 -o impalla-images")]
pub struct Arguments {
    /// The sample.
    pub sample: PathBuf,
    /// The format.
    #[arg(long, value_enum)]
    pub to: Target,
    /// The folder to write.
    #[arg(short, long)]
    pub output: PathBuf,
    #[command(flatten)]
    pub common: Common,
}

/// What is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Target {
    /// A folder as UBO2003: 8-bit JPEG in sRGB, directions at whole degrees.
    Ubo2003,
    /// A folder as UTIA: 8-bit PNG in sRGB, directions at whole degrees.
    Utia,
    /// A folder as UTIA: OpenEXR in XYZ (D65), half floats, directions at whole degrees.
    UtiaExr,
    /// A folder of OpenEXR images with a table of angles, any directions; nothing is lost.
    Folder,
}

impl Target {
    fn image_set(self) -> ImageSet {
        match self {
            Self::Ubo2003 => ImageSet::Ubo2003,
            Self::Utia => ImageSet::Utia,
            Self::UtiaExr => ImageSet::UtiaExr,
            Self::Folder => ImageSet::Folder,
        }
    }
}

impl Arguments {
    /// What the command reads and writes.
    pub fn files(&self) -> Files {
        Files::default().read(&files_of(&self.sample)).write(
            "output",
            [&self.output],
            Product::NewFolder,
        )
    }

    /// Runs the command.
    pub fn run(&self, session: &Session) -> Result<Outcome> {
        let _locks = self.files().claim()?;
        image_set::run(&self.sample, self.to.image_set(), &self.output, session)
    }
}
