//! `mesotex vary distort`: field distortion (Zhang 2003 §4.1).

use std::path::PathBuf;

use clap::Args;
use ndarray::Array2;

use crate::cli::mask::files_of;
use crate::cli::outcome::Outcome;
use crate::cli::outputs::Files;
use crate::cli::session::{Common, Session};
use crate::cli::vary::fields::FieldOptions;
use crate::cli::vary::inputs::InputOptions;
use crate::cli::vary::product::{Made, OutputOptions};
use crate::error::Result;
use crate::vary::distortion::{DistortionOptions, distorted};
use crate::vary::material::Picks;

/// Synthesize a texture whose elements change size and direction.
#[derive(Clone, Debug, Args)]
#[command(after_help = "\
Examples:
  mesotex vary distort blobs.png --tile --scale-to 0.4 -o blobs
  mesotex vary distort scales.png --size 256x64 --orientation-key 0,32,0 --orientation-key 255,32,90 -o turned
  mesotex vary distort weave.sample --transition-key 3,3,0 --transition-key 60,50,1 -o weave-fine")]
pub struct Arguments {
    /// The texture: an image, or a sample NAME.sample
    pub texture: PathBuf,
    /// The texture's mask, from `mesotex mask`, which the result keeps
    #[arg(long, value_name = "FILE")]
    pub mask: Option<PathBuf>,
    #[command(flatten)]
    pub inputs: InputOptions,
    #[command(flatten)]
    pub fields: FieldOptions,
    #[command(flatten)]
    pub distortion: DistortionOptions,
    #[command(flatten)]
    pub outputs: OutputOptions,
    #[command(flatten)]
    pub common: Common,
}

impl Arguments {
    /// What the command reads and writes.
    pub fn files(&self) -> Files {
        let files = Files::default()
            .read(&files_of(&self.texture))
            .read(&self.mask)
            .read(self.fields.files());
        self.outputs.add_to(files, self.mask.is_some())
    }

    /// Refuses options that no input could satisfy.
    pub fn check(&self) -> Result<()> {
        self.inputs.check()?;
        self.fields.check()?;
        self.distortion.validate()?;
        self.outputs.check()
    }

    /// Runs the command; its outputs are claimed.
    pub fn run(&self, session: &Session) -> Result<Outcome> {
        // Read texture, mask and fields.
        let progress = session.progress();
        let wanted = (&self.fields, self.outputs.tolerance());
        let masks: Vec<&PathBuf> = self.mask.iter().collect();
        let varied = self
            .inputs
            .read((&[&self.texture], &masks), wanted, progress)?;
        let (output, fields) = (varied.output, varied.fields);
        let (material, mask) = (&varied.materials[0], varied.masks.first());
        let read = (&fields.transition, &fields.orientation);
        // Distort, the mask with the texture.
        let texels = distorted(material, read, &self.distortion, session.seed(), progress)?;
        let label = |mask: &Array2<u8>, pixel: usize| {
            let texel = texels[pixel] as usize;
            mask[[texel / mask.ncols(), texel % mask.ncols()]]
        };
        let mask = mask.map(|mask| {
            Array2::from_shape_fn(output, |(row, col)| label(mask, row * output.1 + col))
        });
        // Write what was made.
        let made = Made {
            picks: Picks {
                output,
                texels: vec![texels],
                shares: Vec::new(),
            },
            mask,
            fields,
            way: "distort",
        };
        self.outputs.write(&[material], made, progress)
    }
}
