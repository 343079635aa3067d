//! The textures and masks that are varied.

use std::path::{Path, PathBuf};

use clap::Args;
use ndarray::Array2;

use crate::btf::sample::Sample;
use crate::cli::exemplar::controls::read_mask;
use crate::cli::exemplar::option_values::AlphaOption;
use crate::cli::exemplar::reading::ImageReader;
use crate::cli::vary::fields::{FieldOptions, Fields};
use crate::error::{Error, Result};
use crate::format::image::{Orientation, SourceEncoding};
use crate::progress::Progress;
use crate::sites::grid::window::SiteGrid;
use crate::vary::material::{MOST_IMAGES, Material};

/// How textures are read.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Inputs")]
pub struct InputOptions {
    /// Opposite borders of the images continue each other; a sample states it itself
    #[arg(long)]
    pub tile: bool,
    /// Columns and rows of the result. If it is larger than the texture, a texture that tiles is repeated, and another
    /// is mirrored. [default: the texture's]
    #[arg(long, value_name = "WxH")]
    pub size: Option<SiteGrid>,
    /// Images of a sample that are compared in addition to the mean of all, with directions far from each other
    #[arg(long, value_name = "N", default_value_t = 2)]
    pub compare_images: usize,
}

/// What is varied.
pub struct Varied {
    /// The textures, all of one size.
    pub materials: Vec<Material>,
    /// The masks of the first textures.
    pub masks: Vec<Array2<u8>>,
    /// Rows and columns of the result.
    pub output: (usize, usize),
    /// How it varies.
    pub fields: Fields,
}

impl InputOptions {
    /// Refuses what no input could satisfy.
    pub fn check(&self) -> Result<()> {
        match self.compare_images <= MOST_IMAGES {
            true => Ok(()),
            false => Err(Error::option(
                "compare-images",
                self.compare_images.to_string(),
                format!("0 to {MOST_IMAGES}"),
            )),
        }
    }

    /// Reads textures, their masks, and the fields of the output.
    pub fn read(
        &self,
        (textures, masks): (&[&PathBuf], &[&PathBuf]),
        (fields, tolerance): (&FieldOptions, f64),
        progress: Progress<'_>,
    ) -> Result<Varied> {
        let mut reader = ImageReader::new(Orientation::Upright, AlphaOption::Refuse, None);
        let mut materials: Vec<Material> = Vec::new();
        for path in textures {
            let material = self.material(path, &mut reader, progress)?;
            if let Some(first) = materials.first() {
                let checked = first.check_partner(&material);
                checked.map_err(|error| error.in_file(path))?;
            }
            materials.push(material);
        }
        let masks = masks.iter().zip(&materials);
        let masks = masks
            .map(|(path, material)| mask_of(path, material, &mut reader))
            .collect::<Result<_>>()?;
        let output = self.output(&materials[0]);
        let fields = fields.read(output, tolerance, &mut reader)?;
        reader.finish(progress)?;
        Ok(Varied {
            materials,
            masks,
            output,
            fields,
        })
    }

    /// A texture: the folder of a sample, or an image.
    fn material(
        &self,
        path: &Path,
        reader: &mut ImageReader,
        progress: Progress<'_>,
    ) -> Result<Material> {
        if !path.is_dir() {
            let image = reader.color(path, SourceEncoding::Auto)?.image;
            return Ok(Material::of_image(image, self.tile));
        }
        if self.tile {
            let found = format!("given for the sample {}", path.display());
            return Err(Error::option(
                "tile",
                found,
                "none: a sample states whether it tiles",
            ));
        }
        Material::of_sample(Sample::open(path)?, self.compare_images, progress)
    }

    /// Rows and columns of what is made of a texture.
    fn output(&self, material: &Material) -> (usize, usize) {
        let grid = material.grid();
        let [width, height] = match self.size {
            None => [grid.width, grid.height],
            Some(size) => [size.width, size.height],
        };
        (height as usize, width as usize)
    }
}

/// The mask of a texture; refused where every pixel has one label.
fn mask_of(path: &Path, material: &Material, reader: &mut ImageReader) -> Result<Array2<u8>> {
    let grid = material.grid();
    let mask = read_mask(path, [grid.width, grid.height], reader)?;
    let first = mask.first().copied().unwrap_or(0);
    match mask.iter().all(|&label| label == first) {
        false => Ok(mask),
        true => Err(
            Error::data("mask", format!("every pixel has label {first}"))
                .expected("two labels or more: features and what is round them")
                .advice("mark features with `mesotex mask`")
                .in_file(path),
        ),
    }
}
