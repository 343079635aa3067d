//! `mesotex mask`: a texton mask of an image (Zhang 2003 §4.2), as a grey picture.

mod overlay;
mod picks;

use std::path::{Path, PathBuf};

use clap::Args;
use ndarray::Array2;
use serde_json::{Value, json};

use crate::btf::sample::{self, Sample};
use crate::cli::exemplar::controls::read_mask;
use crate::cli::exemplar::option_values::AlphaOption;
use crate::cli::exemplar::reading::ImageReader;
use crate::cli::mask::picks::PickOption;
use crate::cli::outcome::Outcome;
use crate::cli::outputs::{Files, Product};
use crate::cli::session::{Common, Session};
use crate::cli::subcommand::Subcommand;
use crate::error::{Error, Result};
use crate::exemplar::controls::MASK_LABELS;
use crate::format::image::{FloatImage, Orientation, SourceEncoding, write_png};
use crate::format::ours::Format;
use crate::vary::color_mask::{Pick, mask_of_colors};
use crate::vary::contours::{Feature, MaskFeatures};
use crate::vary::label_set::LabelSet;
use crate::vary::material::Material;
use crate::vary::morphology::Edit;

/// The grey of label 1; label n is n times as bright.
const GREY: u8 = 255 / (MASK_LABELS - 1);

/// Make a mask of a texture's features, labels 0 to 3, by picked colours or from a painted image.
///
/// The mask is a grey PNG: black, 85, 170 and 255 are the labels 0, 1, 2 and 3. `exemplar --mask` and `vary` read
/// it.
#[derive(Clone, Debug, Args)]
#[command(after_help = "\
Examples:
  mesotex mask tiger.png --pick 40,12 -o stripes.png
  mesotex mask leopard.png --pick '#2a2018:0.25' --pick 31,77:0.2 --edit erode:1 --edit dilate:1.5 -o spots.png
  mesotex mask flowers.png --painted dots.png --overlay check.png -o dots-mask.png")]
pub struct Arguments {
    /// The texture: an image, or a sample NAME.sample, whose mean image is used
    pub image: PathBuf,
    /// The mask to write, a PNG
    #[arg(long, short)]
    pub output: PathBuf,
    /// A colour that marks features, with a tolerance: the colour of a pixel (counted from the upper left) or a value.
    /// The first pick gives label 1, the second 2, the third 3. Differences are Euclidean distances of red, green and
    /// blue, each 0 to 1. [default tolerance: 0.2]
    #[arg(long, value_name = "COL,ROW|#RRGGBB[:TOLERANCE]")]
    pub pick: Vec<PickOption>,
    /// A painted mask: a grey image of the labels 0 to 3, or grey 0, 85, 170, 255
    #[arg(long, value_name = "FILE", conflicts_with = "pick")]
    pub painted: Option<PathBuf>,
    /// Edits of the mask, in this order: dilate:RADIUS or erode:RADIUS in pixels, for all labels but 0, or for named
    /// ones, as erode:2:1+3
    #[arg(long, value_name = "EDIT")]
    pub edit: Vec<Edit>,
    /// Also write an image of the mask over the texture, with contours and centres
    #[arg(long, value_name = "FILE")]
    pub overlay: Option<PathBuf>,
    /// Whether the orientation tag of images is applied
    #[arg(long, value_enum, default_value = "upright")]
    pub orientation: Orientation,
    /// The layer, part, view or channel to read from an OpenEXR file that has several; `mesotex info IMAGE` lists them
    #[arg(long, value_name = "NAME")]
    pub layer: Option<String>,
    #[command(flatten)]
    pub common: Common,
}

impl Subcommand for Arguments {
    fn common(&self) -> &Common {
        &self.common
    }

    fn check(&self) -> Result<()> {
        if self.pick.is_empty() && self.painted.is_none() {
            let expected = "a colour that marks features, or --painted FILE";
            return Err(Error::option("pick", "not given", expected));
        }
        Ok(())
    }

    fn files(&self) -> Result<Files> {
        let picture = Product::File(Format::Picture);
        Ok(Files::default()
            .read(&files_of(&self.image))
            .read(&self.painted)
            .write("output", [&self.output], picture)
            .write("overlay", &self.overlay, picture))
    }

    fn run(&self, session: &Session) -> Result<Outcome> {
        let _locks = self.files()?.claim()?;
        let mut reader =
            ImageReader::new(self.orientation, AlphaOption::Ignore, self.layer.clone());
        let image = self.texture(&mut reader, session)?;
        let size = [image.width, image.height];
        let mut mask = match &self.painted {
            Some(path) => read_mask(path, size, &mut reader)?,
            None => {
                let picks: Vec<Pick> = self.pick.iter().map(|pick| pick.0).collect();
                mask_of_colors(&image, &picks)?
            }
        };
        reader.finish(session.progress())?;
        for edit in &self.edit {
            session.progress().check()?;
            mask = edit.apply(&mask);
        }
        self.warn_of_one_label(&mask, session);
        let features = MaskFeatures::of(&mask, LabelSet::FEATURES);
        if let Some(path) = &self.overlay {
            overlay::draw(&image, &mask, &features).write(path)?;
        }
        write_mask(&self.output, &mask)?;
        Ok(self.outcome(&mask, &features))
    }
}

impl Arguments {
    /// The image; of a sample the mean of its images.
    fn texture(&self, reader: &mut ImageReader, session: &Session) -> Result<FloatImage> {
        if !self.image.is_dir() {
            return Ok(reader.color(&self.image, SourceEncoding::Auto)?.image);
        }
        let sample = Sample::open(&self.image)?;
        Ok(Material::of_sample(sample, 0, session.progress())?
            .images
            .swap_remove(0)
            .image)
    }

    fn warn_of_one_label(&self, mask: &Array2<u8>, session: &Session) {
        let first = mask.first().copied().unwrap_or(0);
        if mask.iter().all(|&label| label == first) {
            let text = format!(
                "{}: every pixel has label {first}; another --pick or --edit marks features",
                self.output.display()
            );
            session.progress().warn(text);
        }
    }

    fn outcome(&self, mask: &Array2<u8>, features: &MaskFeatures) -> Outcome {
        let mut counts = [0_u64; MASK_LABELS as usize];
        mask.iter()
            .for_each(|&label| counts[usize::from(label)] += 1);
        let shares = counts.map(|count| count as f64 / mask.len() as f64);
        let mut outcome = Outcome::default();
        for (label, share) in shares.iter().enumerate().filter(|(_, share)| **share > 0.0) {
            outcome = outcome.line(format!(
                "label {label}: {:.1} % of the image",
                100.0 * share
            ));
        }
        let holes: usize = features
            .list
            .iter()
            .map(|feature| feature.holes.len())
            .sum();
        let outcome = outcome
            .line(format!("{} features, {holes} holes", features.list.len()))
            .figure("shares", json!(shares))
            .figure(
                "features",
                features.list.iter().map(described).collect::<Vec<_>>(),
            )
            .wrote(&self.output);
        self.overlay
            .iter()
            .fold(outcome, |outcome, path| outcome.wrote(path))
    }
}

/// Writes a mask as a grey picture.
pub(super) fn write_mask(path: &Path, mask: &Array2<u8>) -> Result<()> {
    let (rows, cols) = mask.dim();
    let greys: Vec<u8> = mask.iter().map(|label| label * GREY).collect();
    write_png(path, cols as u32, rows as u32, &greys)
}

/// The files of a texture: of an image itself, of a sample those in its folder too.
pub(super) fn files_of(path: &Path) -> Vec<PathBuf> {
    let inside = path.is_dir().then(|| sample::files_of(path));
    std::iter::once(path.to_path_buf())
        .chain(inside.into_iter().flatten())
        .collect()
}

/// A feature for a program: centre and contour as (column, row) of pixels from the upper left.
fn described(feature: &Feature) -> Value {
    let turned = |points: &[[u32; 2]]| -> Vec<[u32; 2]> {
        points.iter().map(|&[row, col]| [col, row]).collect()
    };
    let holes: Vec<_> = feature.holes.iter().map(|hole| turned(hole)).collect();
    json!({
        "label": feature.label,
        "area": feature.area,
        "centre": [feature.centre[1], feature.centre[0]],
        "contour": turned(&feature.contour),
        "holes": holes,
    })
}
