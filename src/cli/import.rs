//! `mesotex import`: measured image sets → sample.

use std::path::{Path, PathBuf};

use clap::Args;

use crate::btf::import::recognize::{Source, recognize};
use crate::btf::import::{ImportOptions, ListOptions, assemble, read_list_with};
use crate::btf::sample::Description;
use crate::btf::writer::SAMPLE_FOLDER;
use crate::cli::outcome::Outcome;
use crate::cli::outputs::{Files, Product};
use crate::cli::session::{Common, Session};
use crate::error::{Error, Result};

/// Import a measured image set as a BTF sample.
///
/// PATH is an RTI capture (a .lp file: one view, many lights), or a CSV of angles beside rectified
/// images (columns file, view_theta_deg, view_phi_deg, light_theta_deg, light_phi_deg), or a folder
/// that holds just one of either.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  mesotex import capture/dirs.lp -o coin.sample
  mesotex import felt/angles.csv -o felt.sample --tileable --texel-mm 0.2
  mesotex import dome.lp --images \"coin/*.jpg\" -o coin.sample")]
pub struct Arguments {
    /// The .lp or .csv file, or its folder.
    pub path: PathBuf,
    /// The sample to write, NAME.sample.
    #[arg(short, long)]
    pub output: PathBuf,
    #[command(flatten)]
    pub list: ListOptions,
    #[command(flatten)]
    pub options: ImportOptions,
    #[command(flatten)]
    pub common: Common,
}

impl Arguments {
    /// What the command reads and writes.
    pub fn files(&self) -> Result<Files> {
        let files = Files::default().read([&self.path]).write(
            "output",
            [&self.output],
            Product::Folder(&SAMPLE_FOLDER),
        );
        Ok(match recognize(&self.path)? {
            Source::List(list) => {
                let list = read_list_with(&list, &self.list)?;
                let images: Vec<PathBuf> =
                    list.images.into_iter().map(|image| image.path).collect();
                files.read([&list.path]).read(&images)
            }
            _ => files,
        })
    }

    /// Runs the command.
    pub fn run(&self, session: &Session) -> Result<Outcome> {
        let _locks = self.files()?.claim()?;
        let sample = match recognize(&self.path)? {
            Source::List(list) => self.import_list(&list, session)?,
            Source::ImageSet(path) | Source::Bonn(path) | Source::Ptm(path) | Source::Hsh(path) => {
                return Err(unread(&path));
            }
        };
        Ok(self.outcome(&sample))
    }

    fn import_list(&self, list: &Path, session: &Session) -> Result<Description> {
        let list = read_list_with(list, &self.list)?;
        for note in &list.notes {
            session.progress().warn(note.as_str());
        }
        assemble::assemble(&list, &self.options, &self.output, session.progress())
    }

    fn outcome(&self, sample: &Description) -> Outcome {
        Outcome::default()
            .line(format!(
                "{}: {} views, {} lights, {} images of {} × {} texels",
                sample.name,
                sample.views.len(),
                sample.lights.len(),
                sample.image_count(),
                sample.width,
                sample.height
            ))
            .figure("id", sample.id.to_string())
            .figure("views", sample.views.len())
            .figure("lights", sample.lights.len())
            .figure("images", sample.image_count())
            .wrote(&self.output)
            .next(format!(
                "mesotex textons {0} -o {1}",
                self.output.display(),
                self.output.with_extension("textons.npz").display()
            ))
    }
}

/// Refuses a source that is known but not read yet.
fn unread(path: &Path) -> Error {
    Error::data("source", "a known format that this version does not read").in_file(path)
}
