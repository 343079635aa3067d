//! A `.btf` file becomes a sample.
//!
//! DFMF and FMF files whose colours are linear in their factors become factored samples, number for number. Those
//! with logarithms are expanded and factored again in linear RGB, with the error stated. PVF and BDI files, and all
//! with `--expand`, become samples of whole images.

use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};

use serde::Serialize;
use serde_json::{Value, json};

use crate::btf::bonn::expand::{expand, expand_turned};
use crate::btf::bonn::file::{BonnFile, Content};
use crate::btf::bonn::header::Header;
use crate::btf::bonn::images::BonnImages;
use crate::btf::bonn::local_frames::{LocalFrames, TexelFrames};
use crate::btf::bonn::to_factored::FactorCopy;
use crate::btf::description::{Description, FORMAT, Layout, VERSION};
use crate::btf::direction::Direction;
use crate::btf::factored::factorize::{Accuracy, FactorOptions, factorize};
use crate::btf::height_map::HeightMap;
use crate::btf::import::destination::{Destination, InputIds};
use crate::btf::import::{Handedness, ImportOptions, Preparation, SizeLine, Values};
use crate::btf::parts::{NewPart, WrittenSample};
use crate::error::{Error, Result};
use crate::format::atomic::parent;
use crate::format::id::ContentId;
use crate::format::image::{Alpha, Orientation, SourceEncoding};
use crate::progress::Progress;

/// How a `.btf` file becomes a sample.
#[derive(Clone, Debug, Default, PartialEq, Serialize, clap::Args)]
#[serde(rename_all = "kebab-case")]
#[command(next_help_heading = "Options of Bonn's .btf files")]
pub struct BonnOptions {
    /// Write every image of a DFMF or FMF file, not its factors. PVF and BDI files are always expanded.
    #[arg(long)]
    pub expand: bool,
    /// Components per channel of a file with a logarithmic colour model, which is factored again. [default: as many as
    /// the file has]
    #[arg(long, value_name = "K", conflicts_with = "expand")]
    pub rank: Option<u32>,
}

impl BonnOptions {
    /// The flag of an option that was given, if any was.
    pub fn given(&self) -> Option<&'static str> {
        let expand = self.expand.then_some("expand");
        expand.or(self.rank.map(|_| "rank"))
    }
}

/// What an import reports besides the sample's description.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Told {
    /// For a person, one per line.
    pub lines: Vec<String>,
    /// The relative error of a new factorization.
    pub error: Option<f64>,
}

/// One import.
pub struct BonnImport<'a> {
    /// The file.
    pub path: &'a Path,
    /// What is said of any source; what concerns image files alone is refused.
    pub options: &'a ImportOptions,
    /// What is said of a `.btf` file.
    pub bonn: &'a BonnOptions,
    /// Which way y of its directions points.
    pub handedness: Handedness,
    /// Seed of a new factorization.
    pub seed: u64,
    /// The sample to write, or the part of a shard.
    pub destination: Destination<'a>,
    /// Who is told how far it is.
    pub progress: Progress<'a>,
}

impl BonnImport<'_> {
    /// Writes the sample, or the part of a shard.
    pub fn run(&self) -> Result<(WrittenSample, Told)> {
        check(self.options)?;
        let mut file = BonnFile::open(self.path, parent(self.destination.path))?;
        LocalFrames::of(file.header()).map_err(|error| error.in_file(self.path))?;
        if let Some(region) = self.options.preparation.crop {
            file = file.cropped(region)?;
        }
        self.import(file).map_err(|error| error.in_file(self.path))
    }

    fn import(&self, file: BonnFile) -> Result<(WrittenSample, Told)> {
        file.notes()
            .iter()
            .for_each(|note| self.progress.warn(note.as_str()));
        // Describe the sample.
        let frames = LocalFrames::of(file.header())?;
        let description = self.describe(&file, &frames);
        description.check()?;
        let is_turned = matches!(frames, LocalFrames::PerTexel(_));
        // Choose the way: copy the factors, factor anew, or expand to images.
        let way = Way::of(&file, self.bonn.expand || is_turned);
        self.check_rank(way)?;
        self.check_shard(way, is_turned)?;
        let heights = self.heights(&file, &description)?;
        if let (Way::Copied, Content::Factors(factors)) = (way, &file.content) {
            let cosines = missing_cosines(file.header(), self.options.values);
            let copy = FactorCopy {
                factors,
                white: self.white(),
                cosines: cosines.as_deref(),
                heights,
                progress: self.progress,
            };
            let sample = copy.write(description, self.destination.path)?;
            return Ok((WrittenSample::anew(sample), Told::default()));
        }
        // Write the sample from images, turned where every texel has a frame of its own.
        let components = file.factors().map_or(1, |(_, rank)| rank as u32);
        let sampling = file.header().sampling.clone();
        let images = self.images(file, description, heights)?;
        match (way, &frames) {
            (Way::Refactored, _) => self.refactor(&images, self.bonn.rank.unwrap_or(components)),
            (_, LocalFrames::PerTexel(rotations)) => {
                let frames = TexelFrames {
                    rotations,
                    sampling: &sampling,
                };
                let target = self.destination.path;
                let sample = expand_turned(&images, &frames, target, self.progress)?;
                Ok((WrittenSample::anew(sample), told_of(&images)))
            }
            _ => {
                let part = self.part(&images.description)?;
                let target = self.destination.path;
                let sample = expand(&images, target, part.as_ref(), self.progress)?;
                Ok((sample, told_of(&images)))
            }
        }
    }

    /// Refuses a rank where nothing is factored.
    fn check_rank(&self, way: Way) -> Result<()> {
        match (self.bonn.rank, way) {
            (Some(rank), Way::Copied | Way::Expanded) => Err(Error::option(
                "rank",
                format!("{rank} for a file that is not factored again"),
                "a DFMF or FMF file with logarithms; `mesotex factor` changes the rank of any sample",
            )),
            _ => Ok(()),
        }
    }

    /// Refuses to share what one run has to make as a whole.
    fn check_shard(&self, way: Way, is_turned: bool) -> Result<()> {
        let Some(shard) = self.destination.shard else {
            return Ok(());
        };
        let (found, expected) = match (way, is_turned) {
            (_, true) => (
                "a file with a local frame per texel, in which every image depends on all others",
                "no --shard: one run imports it as a whole",
            ),
            (Way::Copied, _) => (
                "a file of factors, which become those of the sample",
                "no --shard: one run copies them in seconds; or --expand, whose images can be shared",
            ),
            (Way::Refactored, _) => (
                "a file of logarithmic factors, which are factored again as a whole",
                "no --shard: one run imports it as a whole; or --expand, whose images can be shared",
            ),
            (Way::Expanded, false) => return Ok(()),
        };
        Err(Error::option(
            "shard",
            format!("{shard} of {found}"),
            expected,
        ))
    }

    /// The part that the run makes; `None` where it makes the whole sample.
    fn part(&self, whole: &Description) -> Result<Option<NewPart>> {
        let count = whole.image_count();
        self.destination.part(count, self.options, |_| {
            Ok(InputIds {
                source: ContentId::of_file(self.path)?,
                own: None,
            })
        })
    }

    /// The sample's value of a white plane facing the light, over the file's.
    fn white(&self) -> f64 {
        match self.options.values {
            Values::Auto | Values::Reflectance | Values::NoCosine => std::f64::consts::FRAC_1_PI,
            Values::Radiance => 1.0,
        }
    }

    /// The file's heights in texels, their mean at z = 0. A part of the texels keeps its place below or above
    /// the mean of all.
    fn heights(&self, file: &BonnFile, description: &Description) -> Result<Option<HeightMap>> {
        let Some(heights) = file.heights() else {
            return Ok(None);
        };
        let Some(mm) = description.texel_mm else {
            self.progress.warn(
                "its height map is in millimetres and the file does not state the size of a texel: it is left out \
                 (--texel-mm states it)",
            );
            return Ok(None);
        };
        let in_texels = |&height: &f32| (f64::from(height) / mm) as f32;
        let heights = heights.iter().map(in_texels).collect();
        HeightMap::new(description.grid(), heights).map(Some)
    }

    fn images(
        &self,
        file: BonnFile,
        description: Description,
        heights: Option<HeightMap>,
    ) -> Result<BonnImages> {
        let white = self.white() as f32;
        let scales = match missing_cosines(file.header(), self.options.values) {
            Some(cosines) => cosines.iter().map(|cosine| cosine * white).collect(),
            None => vec![white; description.lights.len()],
        };
        Ok(BonnImages {
            description,
            body: file.into_body()?,
            heights,
            scales,
            negative: AtomicU64::new(0),
        })
    }

    fn refactor(&self, images: &BonnImages, rank: u32) -> Result<(WrittenSample, Told)> {
        let description = &images.description;
        let most = description.image_count().min(description.grid().len());
        let rank = rank.min(most as u32);
        let options = FactorOptions {
            accuracy: Accuracy::Rank(rank),
            dtype: description.dtype,
            seed: self.seed,
        };
        let origin = description.source.clone();
        let target = self.destination.path;
        let (sample, left) = factorize(images, &options, origin, target, self.progress)?;
        let line = format!(
            "its logarithms were converted and its images factored again: {rank} components per channel have a \
             relative error of {:.2e}",
            left.relative
        );
        let told = Told {
            lines: vec![line],
            error: Some(left.relative),
        };
        Ok((WrittenSample::anew(sample), told))
    }

    fn describe(&self, file: &BonnFile, frames: &LocalFrames) -> Description {
        let (header, options) = (file.header(), self.options);
        let turned = |set: &[Direction]| -> Vec<Direction> {
            let directions = set.iter().map(|&direction| frames.to_patch(direction));
            directions
                .map(|direction| self.handedness.applied_to(direction))
                .collect()
        };
        let millimetres = 1.0 / f64::from(header.meta.pixels_per_mm);
        let stated = (millimetres > 0.0 && millimetres.is_finite()).then_some(millimetres);
        let stem = self.path.file_stem().unwrap_or_default();
        let own_name = || stem.to_string_lossy().into_owned();
        Description {
            format: FORMAT.into(),
            version: VERSION,
            name: options.name.clone().unwrap_or_else(own_name),
            width: header.width,
            height: header.height,
            channels: 3,
            dtype: options.dtype,
            texel_mm: options.texel_mm.or(stated),
            layout: Layout::Product,
            views: turned(&header.sampling.views),
            lights: turned(&header.sampling.lights),
            pairs: None,
            tileable: options.tileable,
            id: ContentId::of_bytes(b""),
            source: self.source(file),
        }
    }

    fn source(&self, file: &BonnFile) -> Value {
        let mut facts = file.facts();
        if let Some(object) = facts.as_object_mut() {
            object.insert("values".into(), json!(self.options.values));
            object.insert("handedness".into(), json!(self.handedness));
        }
        facts
    }
}

/// What becomes of the numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Way {
    /// Factors stay factors.
    Copied,
    /// Logarithms are undone, and the images factored again.
    Refactored,
    /// All images are written.
    Expanded,
}

impl Way {
    fn of(file: &BonnFile, expand: bool) -> Self {
        match &file.content {
            Content::Factors(_) if expand => Self::Expanded,
            Content::Factors(factors) if factors.is_linear() => Self::Copied,
            Content::Factors(_) => Self::Refactored,
            Content::Pvf(_) | Content::PartOfPvf(_) | Content::Bdi(_) => Self::Expanded,
        }
    }
}

fn told_of(images: &BonnImages) -> Told {
    let mut told = Told::default();
    match images.negative.load(Ordering::Relaxed) {
        0 => {}
        negative => told.lines.push(format!(
            "{negative} negative values, which factors produce in dark parts, were set to 0"
        )),
    }
    told
}

/// Refuses options that say how image files are read.
fn check(options: &ImportOptions) -> Result<()> {
    let given = [
        ("encoding", options.encoding != SourceEncoding::default()),
        ("orientation", options.orientation != Orientation::Stored),
        ("alpha", options.alpha != Alpha::default()),
        ("layer", options.layer.is_some()),
        ("illuminant", options.illuminant.is_some()),
        ("size-line", options.size_line != SizeLine::default()),
    ];
    let given = given.iter().find(|(_, given)| *given);
    let rest = Preparation {
        crop: None,
        ..options.preparation.clone()
    };
    match given.map(|(option, _)| *option).or(rest.given()) {
        None => Ok(()),
        Some(option) => Err(Error::option(
            option,
            "given for a .btf file",
            "a set of images: the numbers of a .btf file are linear RGB, opaque, and taken as they are but for \
             --crop",
        )),
    }
}

/// The cosine of each light, where the values do not have it.
fn missing_cosines(header: &Header, values: Values) -> Option<Vec<f32>> {
    let has_cosine = match values {
        Values::Auto => header.meta.has_cosine,
        Values::NoCosine => false,
        Values::Reflectance | Values::Radiance => true,
    };
    let lights = header.sampling.lights.iter();
    let cosine = |light: &Direction| light.cos_theta().max(0.0) as f32;
    (!has_cosine).then(|| lights.map(cosine).collect())
}
