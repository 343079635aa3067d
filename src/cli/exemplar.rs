//! `mesotex exemplar`: plain images in; a sample of one view and one light, a space of features, and
//! a neighbour table out, so that `synth` and `render` decorate meshes with ordinary textures.

mod arguments;
pub(super) mod channels;
pub(super) mod controls;
mod describe;
pub(super) mod option_values;
pub(super) mod reading;
mod weights;

use std::f32::consts::PI;
use std::path::{Path, PathBuf};

use glam::DVec3;
use serde_json::{Value, json};

pub use crate::cli::exemplar::arguments::Arguments;
pub use crate::cli::exemplar::describe::describe_channels;

use crate::btf::direction::Direction;
use crate::btf::sample::Description;
use crate::btf::writer::{SAMPLE_FOLDER, SampleWriter};
use crate::cli::endings::check_stem;
use crate::cli::outcome::Outcome;
use crate::cli::outputs::{Files, Product};
use crate::cli::session::{Common, Session};
use crate::cli::subcommand::Subcommand;
use crate::error::{Error, Result};
use crate::exemplar::neighbor_table;
use crate::exemplar::plain_images::space_of_images;
use crate::format::id::ContentId;
use crate::format::image::FloatImage;
use crate::format::ours::Format;

/// What is written: NAME with each of these endings.
const PRODUCTS: [&str; 3] = ["sample", "space.npz", "knn.npz"];

impl Subcommand for Arguments {
    fn common(&self) -> &Common {
        &self.common
    }

    fn check(&self) -> Result<()> {
        check_stem("output", &self.output, &PRODUCTS)?;
        self.check_kinds()?;
        if let Some(side) = self
            .texel_mm
            .filter(|side| !(*side > 0.0 && side.is_finite()))
        {
            return Err(Error::option(
                "texel-mm",
                side.to_string(),
                "a length above 0",
            ));
        }
        weights::check(&self.weights, self.images.len())?;
        self.knn.validate()
    }

    fn files(&self) -> Result<Files> {
        let [sample, space, table] = self.outputs();
        Ok(Files::default()
            .read(&self.images)
            .read(self.control_files())
            .write("output", [&sample], Product::Folder(&SAMPLE_FOLDER))
            .write("output", [&space, &table], Product::File(Format::Archive)))
    }

    fn run(&self, session: &Session) -> Result<Outcome> {
        let _locks = self.files()?.claim()?;
        let outputs = self.outputs();
        let [sample_path, space_path, table_path] = &outputs;
        let mut reader = self.reading.reader();
        let images = channels::read(self, &mut reader)?;
        let colors = &images[0].image;
        let controls = controls::read(self, [colors.width, colors.height], &mut reader)?;
        reader.finish(session.progress())?;
        // Everything is checked and computed before the first file appears.
        let unknown = ContentId::of_bytes(&[]);
        let mut space = space_of_images(&images, controls, self.levels, self.tile, &unknown)?;
        let mut table = neighbor_table::build(&space, &self.knn, session.progress())?;
        space.texel_mm = self.texel_mm;
        let sample = PlainSample {
            colors,
            tileable: self.tile,
            texel_mm: self.texel_mm,
            source: json!({"kind": "plain images", "images": self.images.len()}),
        };
        let written = sample.write(sample_path, &self.output);
        space.sample = written.map_err(|error| error.in_file(&self.images[0]))?;
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
}

impl Arguments {
    fn outputs(&self) -> [PathBuf; 3] {
        PRODUCTS.map(|kind| with_kind(&self.output, kind))
    }
}

/// Colours as a sample of one view and one light: a white Lambertian plane under a light from above is 1/π.
pub(in crate::cli) struct PlainSample<'a> {
    /// The colours.
    pub colors: &'a FloatImage,
    /// Whether borders wrap.
    pub tileable: bool,
    /// Side of a texel in millimetres, where known.
    pub texel_mm: Option<f64>,
    /// Where the colours come from.
    pub source: Value,
}

impl PlainSample<'_> {
    /// Writes the sample; `name` is what the outputs are named after.
    pub(in crate::cli) fn write(self, path: &Path, name: &Path) -> Result<ContentId> {
        // Check that the colours can be radiance, and make it of them.
        let colors = self.colors;
        let mut radiance = colors.clone().into_linear().into_rgb().data;
        if let Some(below) = radiance.iter().find(|value| **value < 0.0) {
            return Err(Error::data("colour", below.to_string())
                .expected("0 or more: it is rendered as light"));
        }
        radiance.iter_mut().for_each(|value| *value /= PI);
        // Write a sample of one view and one light, both from above.
        let above = Direction(DVec3::Z);
        let name = name.file_name().unwrap_or_default().to_string_lossy();
        let mut writer = SampleWriter::create(
            path,
            Description {
                texel_mm: self.texel_mm,
                tileable: self.tileable,
                source: self.source,
                ..Description::product(
                    name.into_owned(),
                    [colors.width, colors.height],
                    vec![above],
                    vec![above],
                )
            },
        )?;
        writer.push(&radiance)?;
        Ok(writer.finish()?.id)
    }
}

/// `NAME.KIND`.
pub(in crate::cli) fn with_kind(name: &Path, kind: &str) -> PathBuf {
    let mut path = name.as_os_str().to_owned();
    path.push(format!(".{kind}"));
    PathBuf::from(path)
}
