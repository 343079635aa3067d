//! `mesotex import`: measured image sets → sample.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use clap::Args;

use crate::btf::bonn::{BonnImport, BonnOptions};
use crate::btf::fits::evaluation::evaluate;
use crate::btf::fits::{Fit, hsh, ptm};
use crate::btf::import::recognize::Source;
use crate::btf::import::stated_directions::StatedDirections;
use crate::btf::import::{
    Destination, ImportOptions, ListOptions, SetOptions, array, assemble, check_unused, foresee,
    join, read_source, source_of,
};
use crate::btf::parts::WrittenSample;
use crate::btf::sample::{self, Description};
use crate::btf::writer::SAMPLE_FOLDER;
use crate::cli::outcome::{Outcome, next_textons};
use crate::cli::outputs::{Files, Product};
use crate::cli::parts::{InShards, outcome_of_kept};
use crate::cli::session::{Common, Session};
use crate::cli::subcommand::{STAGE_IF_INTERRUPTED, Subcommand};
use crate::error::{Error, Result};
use crate::shard::Shard;

/// How to continue with a shard after an interruption.
const SHARD_IF_INTERRUPTED: &str = "type the same command to continue after the last whole image";

/// Import a measured image set as a BTF sample.
///
/// PATH is recognised by its content: a folder or a zip archive of rectified images whose names state their
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
  mesotex import felt.npy --views bonn151 --lights bonn151 -o felt.sample
  mesotex import felt1.zip felt2.zip -o felt.sample        (archives that hold one set together)
  mesotex import felt.zip --shard 0/2 -o felt.0of2         (and --shard 1/2 -o felt.1of2, elsewhere)
  mesotex import --reduce felt.0of2 felt.1of2 -o felt.sample")]
pub struct Arguments {
    /// The archive, the folder, the .lp or .csv file, the fit or the array; or several archives and folders that hold
    /// one set together.
    #[arg(value_name = "PATH", required_unless_present = "reduce")]
    pub paths: Vec<PathBuf>,
    /// The sample to write, NAME.sample; with --shard, the folder of a part, as felt.0of3.
    #[arg(short, long)]
    pub output: PathBuf,
    /// Import only shard i of n (counted from 0) of the images and write it as a part; --reduce joins the parts. An
    /// existing part of the same source and options is kept.
    #[arg(long, value_name = "I/N", conflicts_with = "reduce")]
    pub shard: Option<Shard>,
    /// Join the parts of all shards to the sample that one run without --shard imports, byte for byte. The options are
    /// those of the parts.
    #[arg(long, value_name = "PART", num_args = 1..)]
    pub reduce: Vec<PathBuf>,
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

impl Subcommand for Arguments {
    fn common(&self) -> &Common {
        &self.common
    }

    fn check(&self) -> Result<()> {
        let (Some(path), Some(part)) = (self.paths.first(), self.reduce.first()) else {
            return Ok(());
        };
        let (path, part) = (path.display(), part.display());
        Err(Error::option(
            "reduce",
            format!("{part}, given with {path}"),
            "the parts of a sample, without a source (to average blocks of pixels: --downsample N)",
        ))
    }

    fn files(&self) -> Result<Files> {
        let files = Files::default().read(&self.paths).write(
            "output",
            [&self.output],
            Product::Folder(&SAMPLE_FOLDER),
        );
        if !self.reduce.is_empty() {
            let parts = self.reduce.iter().flat_map(|part| sample::files_of(part));
            return Ok(files.read(&parts.collect::<Vec<_>>()));
        }
        Ok(match self.source()? {
            Source::List(_) | Source::ImageSet(_) => {
                let list = read_source(&self.paths, &self.list, &self.set)?;
                let paths = list.images.iter().map(|image| image.path.as_path());
                let listed = paths.chain([list.path.as_path()]);
                let held: BTreeSet<&Path> = listed.map(|path| list.place.file_of(path)).collect();
                let held: Vec<PathBuf> = held.into_iter().map(Path::to_path_buf).collect();
                files.read(&self.options.photographs.corners).read(&held)
            }
            Source::Ptm(_) | Source::Hsh(_) | Source::Array(_) => {
                files.read(self.directions.files())
            }
            Source::Bonn(_) => files,
        })
    }

    fn if_interrupted(&self) -> &'static str {
        match self.shard {
            Some(_) => SHARD_IF_INTERRUPTED,
            None => STAGE_IF_INTERRUPTED,
        }
    }

    fn run(&self, session: &Session) -> Result<Outcome> {
        let _locks = self.files()?.claim()?;
        if !self.reduce.is_empty() {
            return self.join(session);
        }
        let source = self.source()?;
        self.check_bonn(&source)?;
        self.check_source(&source)?;
        let written = match source {
            Source::List(_) | Source::ImageSet(_) => self.import_images(session)?,
            Source::Ptm(path) => self.import_fit("ptm", &path, ptm::read, session)?,
            Source::Hsh(path) => self.import_fit("hsh", &path, hsh::read, session)?,
            Source::Array(path) => self.import_array(&path, session)?,
            Source::Bonn(path) => return self.import_bonn(&path, session),
        };
        Ok(self.outcome(&written))
    }
}

impl InShards for Arguments {
    fn parts(&self) -> &[PathBuf] {
        &self.reduce
    }
}

impl Arguments {
    /// What the paths are.
    fn source(&self) -> Result<Source> {
        source_of(&self.paths, &self.set)
    }

    /// Refuses options that say nothing of a source.
    fn check_source(&self, source: &Source) -> Result<()> {
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

    /// Where the run writes to.
    fn destination(&self) -> Destination<'_> {
        Destination {
            path: &self.output,
            shard: self.shard,
        }
    }

    /// Joins parts.
    fn join(&self, session: &Session) -> Result<Outcome> {
        let description = join(&self.reduce, &self.output, session.progress())?;
        let (parts, outcome) = (self.reduce.len(), Outcome::default());
        Ok(described(outcome, &description)
            .line(format!("joined from {parts} parts"))
            .figure("parts", parts)
            .wrote(&self.output)
            .next(next_textons(&self.output)))
    }

    /// What the sample of images will be, as far as one of them tells it, and the pixels of that image; `None` for
    /// other sources, and for the part of a shard.
    pub fn foresee(&self) -> Result<Option<(Description, u64)>> {
        if self.shard.is_some() || !self.reduce.is_empty() {
            return Ok(None);
        }
        match self.source()? {
            Source::List(_) | Source::ImageSet(_) => {
                let list = read_source(&self.paths, &self.list, &self.set)?;
                foresee(&list, &self.options).map(Some)
            }
            Source::Ptm(_) | Source::Hsh(_) | Source::Array(_) | Source::Bonn(_) => Ok(None),
        }
    }

    /// Refuses options of .btf files for other sources, and of lists and image sets for .btf files.
    fn check_bonn(&self, source: &Source) -> Result<()> {
        let (found, given) = match source {
            Source::Bonn(_) => (
                "given for a .btf file",
                self.list.given().or(self.set.given()),
            ),
            _ => (
                "given for a source that is not a .btf file",
                self.bonn.given(),
            ),
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
            destination: self.destination(),
            progress: session.progress(),
        };
        let (written, told) = import.run()?;
        let outcome = self.outcome(&written);
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

    fn import_images(&self, session: &Session) -> Result<WrittenSample> {
        let list = read_source(&self.paths, &self.list, &self.set)?;
        for note in &list.notes {
            session.progress().warn(note.as_str());
        }
        let progress = session.progress();
        assemble(&list, &self.options, self.destination(), progress)
    }

    fn import_fit(
        &self,
        kind: &str,
        path: &Path,
        read: fn(&Path) -> Result<Fit>,
        session: &Session,
    ) -> Result<WrittenSample> {
        let lights = self.directions.lights(self.list.handedness)?;
        let (options, progress) = (&self.options, session.progress());
        let destination = self.destination();
        evaluate(
            &read(path)?,
            (path, kind),
            &lights,
            options,
            destination,
            progress,
        )
    }

    fn import_array(&self, path: &Path, session: &Session) -> Result<WrittenSample> {
        let views = self.directions.views(self.list.handedness)?;
        let lights = self.directions.lights(self.list.handedness)?;
        let (options, progress) = (&self.options, session.progress());
        let destination = self.destination();
        array::import(path, (&views, &lights), options, destination, progress)
    }

    fn outcome(&self, written: &WrittenSample) -> Outcome {
        let outcome = match (self.shard, written.is_kept, written.resumed) {
            (Some(shard), true, _) => {
                let kept = outcome_of_kept(&self.output, shard, "source");
                return kept.figure("resumed", written.resumed);
            }
            (_, _, 0) => Outcome::default(),
            (_, _, images) => Outcome::default().line(format!("resumed after {images} images")),
        };
        let outcome = described(outcome, &written.description).wrote(&self.output);
        match self.shard {
            None => outcome.next(next_textons(&self.output)),
            Some(shard) => outcome
                .figure("shard", shard.to_string())
                .figure("kept", false)
                .figure("resumed", written.resumed)
                .next("mesotex import --reduce PART... -o NAME.sample"),
        }
    }
}

/// Says what a sample holds.
fn described(outcome: Outcome, sample: &Description) -> Outcome {
    outcome
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
}
