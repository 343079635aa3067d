//! `mesotex vary blend`: feature-based blending of two textures (Zhang 2003 §4.3), and what it is compared with.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use ndarray::Array2;

use crate::cli::mask::files_of;
use crate::cli::outcome::Outcome;
use crate::cli::outputs::Files;
use crate::cli::session::{Common, Session};
use crate::cli::vary::fields::{FieldOptions, Fields};
use crate::cli::vary::inputs::InputOptions;
use crate::cli::vary::product::{Made, OutputOptions};
use crate::error::{Error, Result};
use crate::progress::Progress;
use crate::vary::canvas::extended;
use crate::vary::filtering::options::FilterOptions;
use crate::vary::filtering::pyramid::Texture;
use crate::vary::filtering::{Filtering, filter};
use crate::vary::mask_blending::{BlendOptions, Joining, blended_mask};
use crate::vary::material::{Material, Picks};

/// How two textures become one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum By {
    /// Both are filtered with a common mask, a diagonal slice between theirs
    #[default]
    Slice,
    /// The common mask is the mean of theirs; for comparison
    Average,
    /// Wei's texture mixture, without masks: for comparison
    Mixture,
}

/// Blend two textures: the first where the transition is 0, the second where it is 1.
#[derive(Clone, Debug, Args)]
#[command(after_help = "\
Examples:
  mesotex vary blend red.png yellow.png --masks red-mask.png yellow-mask.png -o peppers
  mesotex vary blend a.png b.png --masks a-mask.png b-mask.png --tile --size 192x64 --ramp-begin 0.3 --ramp-end 0.7 -o ab
  mesotex vary blend weave.sample felt.sample --masks weave.png felt.png -o worn
  mesotex vary blend red.png yellow.png --by mixture -o mixed")]
pub struct Arguments {
    /// The texture where the transition is 0: an image, or a sample NAME.sample
    pub first: PathBuf,
    /// The texture where the transition is 1, of the same size; a sample must have the same directions
    pub second: PathBuf,
    /// The masks of the first and the second, from `mesotex mask`
    #[arg(long, num_args = 2, value_names = ["FIRST", "SECOND"])]
    pub masks: Vec<PathBuf>,
    /// How the two textures are blended
    #[arg(long, value_enum, default_value = "slice")]
    pub by: By,
    /// Standard deviation of the Gaussian that blurs the common mask, in pixels
    #[arg(long, value_name = "PIXELS", default_value_t = BlendOptions::default().blur)]
    pub blur: f64,
    /// Blurred value from which upwards a pixel gets the greater label, for masks of two labels
    #[arg(long, value_name = "X", default_value_t = BlendOptions::default().threshold)]
    pub threshold: f64,
    #[command(flatten)]
    pub inputs: InputOptions,
    #[command(flatten)]
    pub fields: FieldOptions,
    #[command(flatten)]
    pub filter: FilterOptions,
    #[command(flatten)]
    pub outputs: OutputOptions,
    #[command(flatten)]
    pub common: Common,
}

impl Arguments {
    /// What the command reads and writes.
    pub fn files(&self) -> Files {
        let files = Files::default()
            .read(&files_of(&self.first))
            .read(&files_of(&self.second))
            .read(&self.masks)
            .read(self.fields.files());
        self.outputs.add_to(files, !self.masks.is_empty())
    }

    /// Refuses options that no input could satisfy.
    pub fn check(&self) -> Result<()> {
        self.inputs.check()?;
        self.fields.check()?;
        self.filter.validate()?;
        self.blending().validate()?;
        match self.by {
            By::Slice | By::Average if self.masks.is_empty() => Err(Error::option(
                "masks",
                "not given",
                "the masks of both textures, or --by mixture",
            )),
            _ => self.outputs.check(),
        }
    }

    fn blending(&self) -> BlendOptions {
        BlendOptions {
            joining: match self.by {
                By::Average => Joining::Average,
                By::Slice | By::Mixture => Joining::Slice,
            },
            blur: self.blur,
            threshold: self.threshold,
        }
    }

    /// Runs the command; its outputs are claimed.
    pub fn run(&self, session: &Session) -> Result<Outcome> {
        // Read textures, masks and fields.
        let progress = session.progress();
        let wanted = (&self.fields, self.outputs.tolerance());
        let masks: Vec<&PathBuf> = self.masks.iter().collect();
        let textures = [&self.first, &self.second];
        let varied = self.inputs.read((&textures, &masks), wanted, progress)?;
        let (output, fields) = (varied.output, varied.fields);
        let materials = [&varied.materials[0], &varied.materials[1]];
        // Blend.
        let work = Blend {
            materials,
            masks: &varied.masks,
            fields: &fields,
            output,
        };
        let (texels, mask) = match self.by {
            By::Mixture => work.mixed(&self.filter, progress)?,
            By::Slice | By::Average => work.filtered(&self.blending(), &self.filter, progress)?,
        };
        // Write what was made.
        let made = Made {
            picks: Picks {
                output,
                texels,
                shares: fields.transition.iter().copied().collect(),
            },
            mask,
            fields,
            way: "blend",
        };
        self.outputs.write(&materials, made, progress)
    }
}

/// The texels of both textures at every pixel, and the mask.
type Blended = (Vec<Vec<u32>>, Option<Array2<u8>>);

/// Two textures on their way to one.
struct Blend<'a> {
    materials: [&'a Material; 2],
    masks: &'a [Array2<u8>],
    fields: &'a Fields,
    output: (usize, usize),
}

impl Blend<'_> {
    /// Both textures filtered with the mask between theirs.
    fn filtered(
        &self,
        blending: &BlendOptions,
        options: &FilterOptions,
        progress: Progress<'_>,
    ) -> Result<Blended> {
        // Blend the masks.
        let wide: Vec<Array2<u8>> = self
            .masks
            .iter()
            .zip(self.materials)
            .map(|(mask, material)| extended(mask, material.tileable, self.output))
            .collect();
        let mask = blended_mask([&wide[0], &wide[1]], &self.fields.transition, blending)?;
        // Filter each texture with the blended mask.
        let mut texels = Vec::new();
        for (material, source) in self.materials.iter().zip(self.masks) {
            let numbers = material.numbers();
            let texture = Texture {
                grid: material.grid(),
                numbers: &numbers,
                mask: source,
            };
            let work = Filtering {
                sources: &[texture],
                mask: Some(&mask),
                shares: None,
                output: self.output,
            };
            texels.extend(filter(work, options, progress)?);
        }
        Ok((texels, Some(mask)))
    }

    /// Wei's texture mixture; the mask is that of the texture with the greater share.
    fn mixed(&self, options: &FilterOptions, progress: Progress<'_>) -> Result<Blended> {
        let numbers = self.materials.map(Material::numbers);
        let none = self.materials.map(|material| {
            let grid = material.grid();
            Array2::zeros((grid.height as usize, grid.width as usize))
        });
        let sources = [0, 1].map(|of| Texture {
            grid: self.materials[of].grid(),
            numbers: &numbers[of],
            mask: &none[of],
        });
        let work = Filtering {
            sources: &sources,
            mask: None,
            shares: Some(&self.fields.transition),
            output: self.output,
        };
        let texels = filter(work, options, progress)?;
        let label = |(row, col): (usize, usize)| {
            let of = usize::from(self.fields.transition[[row, col]] > 0.5);
            let texel = texels[of][row * self.output.1 + col] as usize;
            let width = self.masks[of].ncols();
            self.masks[of][[texel / width, texel % width]]
        };
        let mask = (!self.masks.is_empty()).then(|| Array2::from_shape_fn(self.output, label));
        Ok((texels, mask))
    }
}
