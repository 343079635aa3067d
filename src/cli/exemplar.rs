//! `mesotex exemplar`: plain images in; a sample of one view and one light, a space of features, and
//! a neighbour table out, so that `synth` and `render` decorate meshes with ordinary textures.

use std::f32::consts::PI;
use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use glam::DVec3;
use serde_json::json;

use crate::btf::direction::Direction;
use crate::btf::sample::{DType, Description, Layout};
use crate::btf::writer::SampleWriter;
use crate::cli::outcome::Outcome;
use crate::cli::outputs::{Files, Product};
use crate::cli::session::{Common, Session};
use crate::error::{Error, Result};
use crate::exemplar::knn_options::KnnOptions;
use crate::exemplar::neighbor_table;
use crate::exemplar::plain_images::space_of_images;
use crate::format::id::ContentId;
use crate::format::image::{
    self, Alpha, Flags, FloatImage, Notes, Orientation, Purpose, ReadImage, ReadOptions,
    SourceEncoding,
};
use crate::format::ours::Format;

/// Make an exemplar of plain images.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  mesotex exemplar bricks.png -o bricks --tile
  mesotex exemplar color.png height.png --weights 1,0.5 -o stone --levels 3
  mesotex exemplar color.exr normal.exr --encoding auto,data -o wood
Then:
  mesotex synth bricks.space.npz bricks.knn.npz bunny.ply -o bricks.map.ply
  mesotex render bricks.sample bricks.map.ply -o frames")]
pub struct Arguments {
    /// Aligned images: the first is the colour that is rendered, all guide synthesis
    #[arg(required = true)]
    pub images: Vec<PathBuf>,
    /// NAME: writes NAME.sample, NAME.space.npz and NAME.knn.npz
    #[arg(long, short, value_name = "NAME")]
    pub output: PathBuf,
    /// Opposite borders of the images continue each other
    #[arg(long)]
    pub tile: bool,
    /// Levels of the pyramid, the finest included
    #[arg(long, default_value_t = 4)]
    pub levels: u32,
    /// What each image weighs in the squared distance [default: 1 each]
    #[arg(long, value_delimiter = ',', value_name = "W,W…")]
    pub weights: Vec<f32>,
    /// How each image's numbers stand for light; one for all, or one for each image
    #[arg(
        long,
        value_enum,
        value_delimiter = ',',
        default_value = "auto",
        value_name = "E,E…"
    )]
    pub encoding: Vec<ImageEncoding>,
    /// Which way up the images are read
    #[arg(long, value_enum, default_value = "upright")]
    pub orientation: Orientation,
    /// What becomes of texels that are not opaque
    #[arg(long, value_enum, default_value = "refuse")]
    pub alpha: Alpha,
    /// The layer, part or channel of OpenEXR images that have several; `mesotex info IMAGE` lists them
    #[arg(long, value_name = "NAME")]
    pub layer: Option<String>,
    #[command(flatten)]
    pub knn: KnnOptions,
    #[command(flatten)]
    pub common: Common,
}

/// How an image's numbers stand for light, if they do.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ImageEncoding {
    /// The first image and images in colour as their files say (where they say nothing: integers by the
    /// sRGB curve, floats in proportion); grey images after the first are data
    Auto,
    /// By the sRGB curve, whatever the file says
    Srgb,
    /// In proportion, whatever the file says
    Linear,
    /// Not at all: heights, masks, normals; the numbers are used as they stand
    Data,
}

impl Arguments {
    /// What the command reads and writes.
    pub fn files(&self) -> Files {
        let [sample, space, table] = self.outputs();
        Files::default()
            .read(&self.images)
            .write("output", [&sample], Product::Sample)
            .write("output", [&space, &table], Product::File(Format::Archive))
    }

    fn outputs(&self) -> [PathBuf; 3] {
        ["sample", "space.npz", "knn.npz"].map(|kind| with_kind(&self.output, kind))
    }

    /// Runs the command.
    pub fn run(&self, session: &Session) -> Result<Outcome> {
        self.check()?;
        let _locks = self.files().claim()?;
        let outputs = self.outputs();
        let [sample_path, space_path, table_path] = &outputs;
        let images = self.read_images(session)?;
        let weights = match self.weights.is_empty() {
            true => vec![1.0; images.len()],
            false => self.weights.clone(),
        };
        // Everything is checked and computed before the first file appears.
        let unknown = ContentId::of_bytes(&[]);
        let mut space = space_of_images(&images, &weights, self.levels, self.tile, &unknown)?;
        let mut table = neighbor_table::build(&space, &self.knn, session.progress())?;
        space.sample = self.write_sample(sample_path, &images[0])?;
        space.write(space_path, None)?;
        table.space = space.id.clone();
        table.write(table_path, &self.knn)?;
        let (width, height) = (images[0].width, images[0].height);
        let numbers: u32 = images.iter().map(|image| image.channels).sum();
        let outcome = Outcome::default()
            .line(format!(
                "{width}×{height} texels of {numbers} numbers, {} levels",
                self.levels
            ))
            .figure("width", width)
            .figure("height", height)
            .figure("channels", numbers)
            .figure("levels", self.levels)
            .next(format!(
                "mesotex synth {} {} MESH -o NAME.map.ply",
                space_path.display(),
                table_path.display()
            ));
        Ok(outputs
            .iter()
            .fold(outcome, |outcome, path| outcome.wrote(path)))
    }

    /// Refuses options that no input could satisfy.
    pub fn check(&self) -> Result<()> {
        let (given, images) = (self.encoding.len(), self.images.len());
        if given != 1 && given != images {
            return Err(Error::option(
                "encoding",
                format!("{given} for {images} images"),
                "one for all, or one for each image",
            ));
        }
        if self.encoding[0] == ImageEncoding::Data {
            return Err(Error::option(
                "encoding",
                "data for the first image",
                "auto, srgb or linear: the first image is the colour that is rendered",
            ));
        }
        self.knn.validate()
    }

    fn read_images(&self, session: &Session) -> Result<Vec<FloatImage>> {
        let options = ReadOptions {
            orientation: self.orientation,
            alpha: self.alpha,
            layer: self.layer.clone(),
            flags: Flags {
                layer: "--layer",
                encoding: "--encoding",
                alpha: "--alpha",
                orientation: "--orientation",
            },
            ..ReadOptions::default()
        };
        let (mut images, mut notes, mut layer_taken) = (Vec::new(), Notes::default(), false);
        for (index, path) in self.images.iter().enumerate() {
            let encoding = self.encoding[index % self.encoding.len()];
            let read = read_image(path, encoding, index == 0, &options)?;
            let finite = read.image.check_finite();
            finite.map_err(|error| error.in_file(path))?;
            notes.add(path, read.notes);
            layer_taken |= read.layer_taken;
            images.push(read.image);
        }
        notes.warn(&session.progress());
        options.check_layer_taken(layer_taken)?;
        Ok(images)
    }

    /// The first image as a sample: a white Lambertian plane under a light from above is 1/π.
    fn write_sample(&self, path: &Path, colors: &FloatImage) -> Result<ContentId> {
        let mut radiance = colors.clone().into_linear().into_rgb().data;
        if let Some(below) = radiance.iter().find(|value| **value < 0.0) {
            return Err(Error::data("colour", below.to_string())
                .expected("0 or more in the first image")
                .in_file(&self.images[0]));
        }
        radiance.iter_mut().for_each(|value| *value /= PI);
        let above = Direction(DVec3::Z);
        let name = self
            .output
            .file_name()
            .unwrap_or_default()
            .to_string_lossy();
        let mut writer = SampleWriter::create(
            path,
            Description {
                format: crate::btf::sample::FORMAT.into(),
                version: crate::btf::sample::VERSION,
                name: name.into_owned(),
                width: colors.width,
                height: colors.height,
                channels: 3,
                dtype: DType::F4,
                texel_mm: None,
                layout: Layout::Product,
                views: vec![above],
                lights: vec![above],
                pairs: None,
                tileable: self.tile,
                id: ContentId::of_bytes(&[]),
                source: json!({"kind": "plain images", "images": self.images.len()}),
            },
        )?;
        writer.push(&radiance)?;
        Ok(writer.finish()?.id)
    }
}

fn read_image(
    path: &Path,
    encoding: ImageEncoding,
    is_first: bool,
    options: &ReadOptions,
) -> Result<ReadImage> {
    let as_color = |encoding| ReadOptions {
        encoding,
        ..options.clone()
    };
    let as_data = ReadOptions {
        purpose: Purpose::Data,
        ..options.clone()
    };
    match encoding {
        ImageEncoding::Srgb => image::read_with(path, &as_color(SourceEncoding::Srgb)),
        ImageEncoding::Linear => image::read_with(path, &as_color(SourceEncoding::Linear)),
        ImageEncoding::Data => image::read_with(path, &as_data),
        ImageEncoding::Auto if is_first => image::read_with(path, options),
        ImageEncoding::Auto => match image::read_with(path, &as_data)? {
            grey if grey.image.channels == 1 => Ok(grey),
            _ => image::read_with(path, options),
        },
    }
}

/// `NAME.KIND`.
fn with_kind(name: &Path, kind: &str) -> PathBuf {
    let mut path = name.as_os_str().to_owned();
    path.push(format!(".{kind}"));
    PathBuf::from(path)
}
