//! `mesotex exemplar`: plain images in; a sample of one view and one light, a space of features, and
//! a neighbour table out, so that `synth` and `render` decorate meshes with ordinary textures.

use std::f32::consts::PI;
use std::path::{Path, PathBuf};

use clap::Args;
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
use crate::format::image::{self, FloatImage};
use crate::format::ours::Format;

/// Make an exemplar of plain images.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  mesotex exemplar bricks.png -o bricks --tile
  mesotex exemplar color.png height.png --weights 1,0.5 -o stone --levels 3
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
            .write("output", [&sample], Product::Sample)
            .write("output", [&space, &table], Product::File(Format::Archive))
    }

    fn outputs(&self) -> [PathBuf; 3] {
        ["sample", "space.npz", "knn.npz"].map(|kind| with_kind(&self.output, kind))
    }

    /// Runs the command.
    pub fn run(&self, session: &Session) -> Result<Outcome> {
        let _locks = self.files().claim()?;
        let outputs = self.outputs();
        let [sample_path, space_path, table_path] = &outputs;
        let images = self.read_images()?;
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

    fn read_images(&self) -> Result<Vec<FloatImage>> {
        let read = |path: &PathBuf| {
            let image = image::read(path)?;
            image.check_finite().map_err(|error| error.in_file(path))?;
            Ok(image)
        };
        self.images.iter().map(read).collect()
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
