//! `mesotex exemplar`: plain images in; a sample of one view and one light, a space of features, and
//! a neighbour table out, so that `synth` and `render` decorate meshes with ordinary textures.

mod channels;
mod controls;
mod describe;
mod reading;
mod weights;

use std::f32::consts::PI;
use std::path::{Path, PathBuf};

use clap::Args;
use glam::DVec3;
use serde_json::json;

pub use crate::cli::exemplar::channels::{ImageEncoding, KindOption};
pub use crate::cli::exemplar::describe::describe_channels;
pub use crate::cli::exemplar::reading::AlphaOption;
pub use crate::cli::exemplar::weights::Weight;

use crate::btf::direction::Direction;
use crate::btf::sample::{DType, Description, Layout};
use crate::btf::writer::SampleWriter;
use crate::cli::exemplar::reading::ImageReader;
use crate::cli::outcome::Outcome;
use crate::cli::outputs::{Files, Product};
use crate::cli::session::{Common, Session};
use crate::error::{Error, Result};
use crate::exemplar::knn_options::KnnOptions;
use crate::exemplar::neighbor_table;
use crate::exemplar::plain_images::space_of_images;
use crate::format::id::ContentId;
use crate::format::image::{FloatImage, Orientation};
use crate::format::ours::Format;

/// Make an exemplar of plain images.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  mesotex exemplar bricks.png -o bricks --tile
  mesotex exemplar color.png height.png --weights 1,0.5 -o stone --levels 3
  mesotex exemplar color.exr bumps.exr n.exr --kinds color,height,normal -o wood
  mesotex exemplar leaf.png --alpha keep --weights alpha=4 -o leaf
  mesotex exemplar hide.png --mask parts.png --transition age.png -o hide
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
    /// What each image is, in order [default: auto for each]
    #[arg(long, value_enum, value_delimiter = ',', value_name = "K,K…")]
    pub kinds: Vec<KindOption>,
    /// What each image weighs in the squared distance, or channels by name as height=0.5; 0 leaves a
    /// channel out [default: 1 each]
    #[arg(long, value_delimiter = ',', value_name = "W,W…")]
    pub weights: Vec<Weight>,
    /// How each image's numbers stand for light; one for all colours, or one for each image
    #[arg(
        long,
        value_enum,
        value_delimiter = ',',
        default_value = "auto",
        value_name = "E,E…"
    )]
    pub encoding: Vec<ImageEncoding>,
    /// Grey image of the labels 0 to 3 of each texel: as they stand, or as grey 0, 85, 170, 255
    #[arg(long, value_name = "FILE")]
    pub mask: Option<PathBuf>,
    /// Grey image of each texel's place in a transition, 0 to 1
    #[arg(long, value_name = "FILE")]
    pub transition: Option<PathBuf>,
    /// Image of the pattern's direction at each texel: red is s (right), green is t (up); integers 0 to
    /// their greatest stand for −1 to 1, floats as they stand
    #[arg(long, value_name = "FILE")]
    pub orientation_map: Option<PathBuf>,
    /// Which way up the images are read
    #[arg(long, value_enum, default_value = "upright")]
    pub orientation: Orientation,
    /// What becomes of texels that are not opaque
    #[arg(long, value_enum, default_value = "refuse")]
    pub alpha: AlphaOption,
    /// The layer, part or channel of OpenEXR images that have several; `mesotex info IMAGE` lists them
    #[arg(long, value_name = "NAME")]
    pub layer: Option<String>,
    #[command(flatten)]
    pub knn: KnnOptions,
    #[command(flatten)]
    pub common: Common,
}

impl Arguments {
    /// What the command reads and writes.
    pub fn files(&self) -> Files {
        let [sample, space, table] = self.outputs();
        Files::default()
            .read(&self.images)
            .read(self.control_files())
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
        let mut reader = ImageReader::new(self);
        let images = channels::read(self, &mut reader)?;
        let colors = &images[0].image;
        let controls = controls::read(self, [colors.width, colors.height], &mut reader)?;
        reader.finish(&session.progress())?;
        // Everything is checked and computed before the first file appears.
        let unknown = ContentId::of_bytes(&[]);
        let mut space = space_of_images(&images, controls, self.levels, self.tile, &unknown)?;
        let mut table = neighbor_table::build(&space, &self.knn, session.progress())?;
        space.sample = self.write_sample(sample_path, colors)?;
        space.write(space_path, None)?;
        table.space = space.id.clone();
        table.write(table_path, &self.knn)?;
        let (width, height) = (colors.width, colors.height);
        let numbers: u32 = images.iter().map(|of| of.image.channels).sum();
        let outcome = Outcome::default()
            .line(format!(
                "{width}×{height} texels of {numbers} numbers, {} levels",
                self.levels
            ))
            .figure("width", width)
            .figure("height", height)
            .figure("numbers", numbers)
            .figure("levels", self.levels)
            .next(format!(
                "mesotex synth {} {} MESH -o NAME.map.ply",
                space_path.display(),
                table_path.display()
            ));
        let outcome = describe_channels(outcome, &space);
        Ok(outputs
            .iter()
            .fold(outcome, |outcome, path| outcome.wrote(path)))
    }

    /// Refuses options that no input could satisfy.
    pub fn check(&self) -> Result<()> {
        self.check_kinds()?;
        weights::check(&self.weights, self.images.len())?;
        self.knn.validate()
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

/// `NAME.KIND`.
fn with_kind(name: &Path, kind: &str) -> PathBuf {
    let mut path = name.as_os_str().to_owned();
    path.push(format!(".{kind}"));
    PathBuf::from(path)
}
