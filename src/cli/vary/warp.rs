//! `mesotex vary warp`: feature-based warping (Zhang 2003 §4.3).

use std::path::PathBuf;

use clap::Args;

use crate::cli::mask::files_of;
use crate::cli::outcome::Outcome;
use crate::cli::outputs::Files;
use crate::cli::session::{Common, Session};
use crate::cli::vary::fields::FieldOptions;
use crate::cli::vary::inputs::InputOptions;
use crate::cli::vary::product::{Made, OutputOptions};
use crate::error::{Error, Result};
use crate::vary::canvas::extended;
use crate::vary::filtering::options::FilterOptions;
use crate::vary::filtering::pyramid::Texture;
use crate::vary::filtering::{Filtering, filter};
use crate::vary::material::Picks;
use crate::vary::warp::Warp;

/// Warp the features of a texture, and synthesize the texture that belongs to the warped mask.
#[derive(Clone, Debug, Args)]
#[command(after_help = "\
Warps, each in full where the transition is 1, in the order given:
  scale:by=0.5,along=horizontal       features half as wide (along: horizontal, vertical, both)
  erode:by=3  dilate:by=3             features that lose or gain 3 pixels
  radial:scale=0.5,turn=30            features scaled, turned (degrees) and moved (right, up: pixels) about their
  mesh:…  field:…                     centres; pixels follow by radial basis functions, a mesh, or contour lines
With labels=1+2 the named labels are features together [default: all but 0].
Examples:
  mesotex vary warp tiger.png --mask stripes.png --warp scale:by=0.3,along=horizontal -o tiger
  mesotex vary warp leopard.png --mask spots.png --warp scale:by=0.5 --warp dilate:by=2,labels=2 -o leopard
  mesotex vary warp stones.sample --mask joints.png --size 256x64 --ramp-begin 0.2 --warp erode:by=2 -o stones")]
pub struct Arguments {
    /// The texture: an image, or a sample NAME.sample
    pub texture: PathBuf,
    /// The texture's mask, from `mesotex mask`
    #[arg(long, value_name = "FILE")]
    pub mask: PathBuf,
    /// A warp of the mask; may be given several times
    #[arg(long, required = true, value_name = "WARP")]
    pub warp: Vec<Warp>,
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
            .read(&files_of(&self.texture))
            .read([&self.mask])
            .read(self.fields.files());
        self.outputs.add_to(files, true)
    }

    /// Refuses options that no input could satisfy.
    pub fn check(&self) -> Result<()> {
        self.inputs.check()?;
        self.fields.check()?;
        self.filter.validate()?;
        self.outputs.check()
    }

    /// Runs the command; its outputs are claimed.
    pub fn run(&self, session: &Session) -> Result<Outcome> {
        // Read texture, mask and fields.
        let progress = session.progress();
        let wanted = (&self.fields, self.outputs.tolerance());
        let varied = self
            .inputs
            .read((&[&self.texture], &[&self.mask]), wanted, progress)?;
        let (output, fields) = (varied.output, varied.fields);
        let (material, source) = (&varied.materials[0], &varied.masks[0]);
        // Warp the mask.
        let mut mask = extended(source, material.tileable, output);
        for warp in &self.warp {
            progress.check()?;
            mask = warp.apply(&mask, &fields.transition)?;
        }
        // Refuse a warp that leaves nothing to filter with.
        let first = mask.first().copied().unwrap_or(0);
        if mask.iter().all(|&label| label == first) {
            let found = format!("leaves label {first} alone");
            return Err(Error::option(
                "warp",
                found,
                "a warp that leaves features somewhere",
            ));
        }
        // Filter the texture with the warped mask.
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
            output,
        };
        let picks = Picks {
            output,
            texels: filter(work, &self.filter, progress)?,
            shares: Vec::new(),
        };
        // Write what was made.
        let made = Made {
            picks,
            mask: Some(mask),
            fields,
            way: "warp",
        };
        self.outputs.write(&[material], made, progress)
    }
}
