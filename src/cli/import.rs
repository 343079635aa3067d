//! `mesotex import`: measured image sets → sample.

use std::path::{Path, PathBuf};

use clap::Args;

use crate::btf::bonn::{BonnImport, BonnOptions};
use crate::btf::fits::evaluation::evaluate;
use crate::btf::fits::{Fit, hsh, ptm};
use crate::btf::import::recognize::Source;
use crate::btf::import::stated_directions::StatedDirections;
use crate::btf::import::{
    ImportOptions, ListOptions, Place, SetOptions, array, assemble, check_unused, read_source,
    source_of,
};
use crate::btf::sample::Description;
use crate::btf::writer::SAMPLE_FOLDER;
use crate::cli::outcome::Outcome;
use crate::cli::outputs::{Files, Product};
use crate::cli::session::{Common, Session};
use crate::error::{Error, Result};

/// Import a measured image set as a BTF sample.
///
/// PATH is recognised by its content: a folder or a zip archive of rectified images whose names say their
/// angles (UBO2003 and ATRIUM, UTIA, SPECTRAL, CUReT, or others by --pattern); an RTI capture (a .lp file:
/// one view, many lights); a table (.csv) of angles or of positions in mm beside rectified images, or
/// beside photographs of a patch (--corners); a folder that holds just one list; a fit of a capture (PTM, or HSH
/// in a .rti file), evaluated at --lights; or an array (.npy) of shape [views, lights, 3] or [views, lights, rows,
/// columns, 3] with --views and --lights; or a .btf file of Bonn (DFMF, FMF, PVF, BDI).
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  mesotex import UBO_IMPALLA256.zip -o impalla.sample
  mesotex import felt -o felt.sample --pattern \"l{tl}-{pl}_v{tv}-{pv}\" --crop 256x256+40+60
  mesotex import capture/dirs.lp -o coin.sample
  mesotex import felt/angles.csv -o felt.sample --tileable --texel-mm 0.2
  mesotex import dome.lp --images \"coin/*.jpg\" -o coin.sample
  mesotex import carpet01_resampled_W400xH400_L151xV151.btf -o carpet01.sample
  mesotex import pictures/angles.csv --corners pictures/corners.csv -o patch.sample
  mesotex import coin.ptm --lights bonn81 -o coin.sample
  mesotex import felt.npy --views bonn151 --lights bonn151 -o felt.sample")]
pub struct Arguments {
    /// The archive, the folder, the .lp or .csv file, the fit or the array.
    pub path: PathBuf,
    /// The sample to write, NAME.sample.
    #[arg(short, long)]
    pub output: PathBuf,
    #[command(flatten)]
    pub list: ListOptions,
    #[command(flatten)]
    pub set: SetOptions,
    #[command(flatten)]
    pub directions: StatedDirections,
    #[command(flatten)]
    pub options: ImportOptions,
    #[command(flatten)]
    pub bonn: BonnOptions,
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
        Ok(match source_of(&self.path, &self.set)? {
            Source::List(_) | Source::ImageSet(_) => {
                let list = read_source(&self.path, &self.list, &self.set)?;
                let files = files.read(&self.options.photographs.corners);
                let images = list.images.into_iter().map(|image| image.path);
                match list.place {
                    Place::Files => files
                        .read([&list.path])
                        .read(&images.collect::<Vec<PathBuf>>()),
                    Place::Archive(_) => files,
                }
            }
            Source::Ptm(_) | Source::Hsh(_) | Source::Array(_) => {
                files.read(self.directions.files())
            }
            Source::Bonn(_) => files,
        })
    }

    /// Refuses options that say nothing of a source.
    fn check(&self, source: &Source) -> Result<()> {
        match source {
            Source::List(_) | Source::ImageSet(_) | Source::Bonn(_) => check_unused(
                self.directions.given(),
                "an array (.npy) or a fit (.ptm, .rti)",
            ),
            Source::Ptm(_) | Source::Hsh(_) => {
                check_unused(self.directions.given_views(), "an array (.npy)")?;
                self.refuse_options_of_images()
            }
            Source::Array(_) => self.refuse_options_of_images(),
        }
    }

    /// Runs the command.
    pub fn run(&self, session: &Session) -> Result<Outcome> {
        let _locks = self.files()?.claim()?;
        let source = source_of(&self.path, &self.set)?;
        self.check_bonn(&source)?;
        self.check(&source)?;
        let sample = match source {
            Source::List(_) | Source::ImageSet(_) => self.import_images(session)?,
            Source::Ptm(path) => self.import_fit("ptm", &path, ptm::read, session)?,
            Source::Hsh(path) => self.import_fit("hsh", &path, hsh::read, session)?,
            Source::Array(path) => self.import_array(&path, session)?,
            Source::Bonn(path) => return self.import_bonn(&path, session),
        };
        Ok(self.outcome(&sample))
    }

    /// Refuses options of .btf files for other sources, and of lists and image sets for .btf files.
    fn check_bonn(&self, source: &Source) -> Result<()> {
        let (found, given) = match source {
            Source::Bonn(_) => (
                "given for a .btf file",
                self.list.given().or(self.set.given()),
            ),
            _ => ("given for a source that is no .btf file", self.bonn.given()),
        };
        match given {
            None => Ok(()),
            Some(option) => Err(Error::option(option, found, "a source that it concerns")),
        }
    }

    fn import_bonn(&self, path: &Path, session: &Session) -> Result<Outcome> {
        let import = BonnImport {
            path,
            options: &self.options,
            bonn: &self.bonn,
            handedness: self.list.handedness,
            seed: session.seed(),
            target: &self.output,
            progress: session.progress(),
        };
        let (sample, told) = import.run()?;
        let outcome = self.outcome(&sample);
        let outcome = told.lines.into_iter().fold(outcome, Outcome::line);
        Ok(outcome.figure("error", told.error))
    }

    /// Refuses options that are for images of their own files.
    fn refuse_options_of_images(&self) -> Result<()> {
        let wanted = "a list, a folder or an archive of images";
        check_unused(self.set.given(), wanted)?;
        check_unused(self.list.given(), wanted)?;
        check_unused(self.options.preparation.given(), wanted)?;
        check_unused(self.options.given_for_images(), wanted)
    }

    fn import_images(&self, session: &Session) -> Result<Description> {
        let list = read_source(&self.path, &self.list, &self.set)?;
        for note in &list.notes {
            session.progress().warn(note.as_str());
        }
        assemble(&list, &self.options, &self.output, session.progress())
    }

    fn import_fit(
        &self,
        kind: &str,
        path: &Path,
        read: fn(&Path) -> Result<Fit>,
        session: &Session,
    ) -> Result<Description> {
        let lights = self.directions.lights(self.list.handedness)?;
        let name = path.file_stem().unwrap_or_default().to_string_lossy();
        let (options, progress) = (&self.options, session.progress());
        evaluate(
            &read(path)?,
            (&name, kind),
            &lights,
            options,
            &self.output,
            progress,
        )
    }

    fn import_array(&self, path: &Path, session: &Session) -> Result<Description> {
        let views = self.directions.views(self.list.handedness)?;
        let lights = self.directions.lights(self.list.handedness)?;
        let (options, progress) = (&self.options, session.progress());
        array::import(path, (&views, &lights), options, &self.output, progress)
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
