//! Arguments of `mesotex exemplar`.

use std::path::PathBuf;

use clap::Args;

use crate::cli::exemplar::option_values::{ImageEncoding, KindOption};
use crate::cli::exemplar::reading::ReadingOptions;
use crate::cli::exemplar::weights::Weight;
use crate::cli::session::Common;
use crate::exemplar::knn_options::KnnOptions;

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
    /// Side of a texel in millimetres, if known, for `synth --mesh-unit`
    #[arg(long, value_name = "X")]
    pub texel_mm: Option<f64>,
    /// Levels of the pyramid, the finest included
    #[arg(long, default_value_t = 4)]
    pub levels: u32,
    /// What each image is, in order [default: auto for each]
    #[arg(long, value_enum, value_delimiter = ',', value_name = "K,K…")]
    pub kinds: Vec<KindOption>,
    /// Weight of each image in the squared distance, or of channels by name as height=0.5; 0 leaves a channel out
    /// [default: 1 each]
    #[arg(long, value_delimiter = ',', value_name = "W,W…")]
    pub weights: Vec<Weight>,
    /// How each image's numbers encode light; one for all colours, or one for each image
    #[arg(
        long,
        value_enum,
        value_delimiter = ',',
        default_value = "auto",
        value_name = "E,E…"
    )]
    pub encoding: Vec<ImageEncoding>,
    #[command(flatten)]
    pub controls: ControlImages,
    #[command(flatten)]
    pub reading: ReadingOptions,
    #[command(flatten)]
    pub knn: KnnOptions,
    #[command(flatten)]
    pub common: Common,
}

/// Images that describe how the pattern varies.
#[derive(Debug, Args)]
pub struct ControlImages {
    /// Grey image of the label of each texel, 0 to 3: stored as the label itself, or as grey 0, 85, 170, 255
    #[arg(long, value_name = "FILE")]
    pub mask: Option<PathBuf>,
    /// Grey image of each texel's place in a transition, 0 to 1
    #[arg(long, value_name = "FILE")]
    pub transition: Option<PathBuf>,
    /// Image of the pattern's direction at each texel: red is s (right), green is t (up). Integers from 0 to their
    /// largest are mapped to −1 to 1; floats are used as stored
    #[arg(long, value_name = "FILE")]
    pub orientation_map: Option<PathBuf>,
}
