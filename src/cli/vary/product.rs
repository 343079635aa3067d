//! What `mesotex vary` writes: a sample, a space with controls, a neighbour table, and pictures.

use std::path::{Path, PathBuf};

use clap::Args;
use ndarray::Array2;
use serde_json::{Value, json};

use crate::btf::sample::{Description, Sample};
use crate::btf::writer::{SAMPLE_FOLDER, SampleWriter};
use crate::cli::endings::check_stem;
use crate::cli::exemplar::{PlainSample, describe_channels, with_kind};
use crate::cli::mask::write_mask;
use crate::cli::outcome::Outcome;
use crate::cli::outputs::{Files, Product};
use crate::cli::vary::fields::Fields;
use crate::error::{Error, Result};
use crate::exemplar::controls::Controls;
use crate::exemplar::knn_options::KnnOptions;
use crate::exemplar::neighbor_table;
use crate::exemplar::plain_images::space_of_images;
use crate::format::id::ContentId;
use crate::format::image::{Encoding, FloatImage, PngImage, PngNumbers, encode_srgb};
use crate::format::ours::Format;
use crate::progress::Progress;
use crate::vary::material::{Material, Picks};

/// How far transitions of neighbours may be apart where nothing is said (Zhang 2003 §5.2).
const TOLERANCE: f64 = 0.1;

/// The options of what is written.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Outputs")]
pub struct OutputOptions {
    /// NAME: writes NAME.sample, NAME.space.npz, NAME.knn.npz and pictures
    #[arg(long, short, value_name = "NAME")]
    pub output: PathBuf,
    /// Levels of the space, the finest included
    #[arg(long, default_value_t = 4)]
    pub levels: u32,
    #[command(flatten)]
    pub knn: KnnOptions,
}

/// What was made.
pub struct Made {
    /// What every pixel is made of.
    pub picks: Picks,
    /// The mask, where there is one.
    pub mask: Option<Array2<u8>>,
    /// The transition and the orientation.
    pub fields: Fields,
    /// How, for the sample's description.
    pub way: &'static str,
}

impl OutputOptions {
    /// The tolerance of the neighbour table, and of the transition.
    pub fn tolerance(&self) -> f64 {
        self.knn.transition_tolerance.unwrap_or(TOLERANCE)
    }

    /// Refuses what no input could satisfy.
    pub fn check(&self) -> Result<()> {
        match self.levels {
            1..=16 => {
                check_stem("output", &self.output, &["sample", "space.npz", "knn.npz"])?;
                self.knn.validate()
            }
            levels => Err(Error::option("levels", levels.to_string(), "1 to 16")),
        }
    }

    fn path(&self, kind: &str) -> PathBuf {
        with_kind(&self.output, kind)
    }

    /// Adds the outputs to what a command reads.
    pub fn add_to(&self, files: Files, has_mask: bool) -> Files {
        let archives = ["space.npz", "knn.npz"].map(|kind| self.path(kind));
        let mask = has_mask.then(|| self.path("mask.png"));
        let pictures = ["color.png", "transition.png"].map(|kind| self.path(kind));
        let sample = Product::Folder(&SAMPLE_FOLDER);
        files
            .write("output", [&self.path("sample")], sample)
            .write("output", &archives, Product::File(Format::Archive))
            .write(
                "output",
                pictures.iter().chain(&mask),
                Product::File(Format::Picture),
            )
    }

    /// Writes everything. All is computed before the first file appears.
    pub fn write(
        &self,
        materials: &[&Material],
        made: Made,
        progress: Progress<'_>,
    ) -> Result<Outcome> {
        // Compute the exemplar and its table.
        let knn = KnnOptions {
            transition_tolerance: Some(self.tolerance()),
            ..self.knn.clone()
        };
        let images = made.picks.images(materials);
        let controls = Controls {
            mask: made.mask.clone(),
            transition: Some(made.fields.transition.clone()),
            orientation: Some(made.fields.orientation),
        };
        let unknown = ContentId::of_bytes(&[]);
        let mut space = space_of_images(&images, controls, self.levels, false, &unknown)?;
        let mut table = neighbor_table::build(&space, &knn, progress)?;
        // Write the sample.
        let paths = ["sample", "space.npz", "knn.npz"].map(|kind| self.path(kind));
        let source = json!({"kind": "progressively variant", "way": made.way});
        let samples: Vec<&Sample> = materials
            .iter()
            .filter_map(|of| of.sample.as_ref())
            .collect();
        space.texel_mm = samples.first().and_then(|of| of.description().texel_mm);
        space.sample = match samples.is_empty() {
            true => {
                let sample = PlainSample {
                    colors: &images[0].image,
                    tileable: false,
                    texel_mm: None,
                    source,
                };
                sample.write(&paths[0], &self.output)?
            }
            false => self.write_sample(&paths[0], &samples, &made.picks, source, progress)?,
        };
        // Write the exemplar, its table and the pictures.
        space.write(&paths[1], None)?;
        table.space = space.id.clone();
        table.write(&paths[2], &knn)?;
        let (rows, cols) = made.picks.output;
        let mut pictures = vec![self.path("color.png"), self.path("transition.png")];
        write_colors(&pictures[0], &images[0].image)?;
        write_transition(&pictures[1], &made.fields.transition)?;
        if let Some(mask) = &made.mask {
            pictures.push(self.path("mask.png"));
            write_mask(&pictures[2], mask)?;
        }
        // Tell what was made.
        let outcome = Outcome::default()
            .line(format!("{cols}×{rows} texels, {} levels", self.levels))
            .figure("width", cols)
            .figure("height", rows)
            .figure("levels", self.levels)
            .figure("transition_tolerance", self.tolerance());
        let outcome = describe_channels(outcome, &space);
        let written = paths.iter().chain(&pictures);
        Ok(written.fold(outcome, |outcome, path| outcome.wrote(path)))
    }

    /// The sample, image by image.
    fn write_sample(
        &self,
        path: &Path,
        samples: &[&Sample],
        picks: &Picks,
        source: Value,
        progress: Progress<'_>,
    ) -> Result<ContentId> {
        // Describe the sample after the first of the sources.
        let first = samples[0].description();
        let name = self
            .output
            .file_name()
            .unwrap_or_default()
            .to_string_lossy();
        let description = Description {
            name: name.into_owned(),
            width: picks.output.1 as u32,
            height: picks.output.0 as u32,
            tileable: false,
            id: ContentId::of_bytes(&[]),
            source,
            ..first.clone().with_whole_images()
        };
        // Carry the heights along where all sources have them.
        let heights = picks.sample_heights(samples)?;
        if heights.is_none() && has_heights(samples)? {
            progress.warn("one of the samples has no heights, so what is made has none");
        }
        let mut writer = SampleWriter::create(path, description)?;
        writer.set_heights(heights);
        // Write it image by image.
        progress.begin("writing the sample", samples[0].image_count() as u64);
        for image in 0..samples[0].image_count() {
            let pixels = samples.iter().map(|sample| sample.image(image));
            writer.push(&picks.sample_image(&pixels.collect::<Result<Vec<_>>>()?))?;
            progress.advance(1)?;
        }
        progress.end();
        Ok(writer.finish()?.id)
    }
}

/// Whether a sample among several has heights.
fn has_heights(samples: &[&Sample]) -> Result<bool> {
    for sample in samples {
        if sample.heights()?.is_some() {
            return Ok(true);
        }
    }
    Ok(false)
}

/// Colours as an 8-bit picture by the sRGB curve.
fn write_colors(path: &Path, image: &FloatImage) -> Result<()> {
    let byte = |&value: &f32| {
        let stored = match image.encoding {
            Encoding::Linear => encode_srgb(value),
            Encoding::Srgb | Encoding::Data => value,
        };
        (255.0 * stored.clamp(0.0, 1.0)).round() as u8
    };
    let numbers: Vec<u8> = image.data.iter().map(byte).collect();
    let picture = PngImage {
        width: image.width,
        height: image.height,
        numbers: PngNumbers::Bits8(&numbers),
        is_srgb: true,
    };
    picture.write(path)
}

/// The transition as a 16-bit picture: black is 0, white is 1.
fn write_transition(path: &Path, transition: &Array2<f32>) -> Result<()> {
    let number = |&value: &f32| (65535.0 * value).round() as u16;
    let numbers: Vec<u16> = transition.iter().map(number).collect();
    let (rows, cols) = transition.dim();
    let picture = PngImage {
        width: cols as u32,
        height: rows as u32,
        numbers: PngNumbers::Bits16(&numbers),
        is_srgb: false,
    };
    picture.write(path)
}
