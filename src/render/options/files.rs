//! Files of frames and their previews.

use serde::Serialize;

use crate::error::{Error, Result};
use crate::format::exr::Compression;
use crate::render::frame_range::FramePattern;
use crate::render::option_values::{Animation, Layer, STANDARD_LAYERS};
use crate::render::options::ranges::check_numbers;
use crate::render::tone::{Background, ToneCurve};
use crate::shard::Shard;

/// What is written, and how.
#[derive(Clone, Debug, PartialEq, Serialize, clap::Args)]
#[serde(rename_all = "kebab-case")]
#[command(next_help_heading = "Files")]
pub struct FileOptions {
    /// Layers of a frame's file.
    #[arg(long, value_enum, value_delimiter = ',', default_values_t = STANDARD_LAYERS)]
    pub layers: Vec<Layer>,
    /// Colour in 16-bit floats (the default).
    #[arg(long, conflicts_with = "float")]
    #[serde(skip_serializing)]
    pub half: bool,
    /// Colour in 32-bit floats.
    #[arg(long)]
    pub float: bool,
    /// Compression of a frame's file; all but pxr24 keep every bit.
    #[arg(long, value_enum, default_value_t)]
    pub compression: Compression,
    /// Names of the frames' files; #### becomes the number.
    #[arg(long, default_value_t)]
    pub pattern: FramePattern,
    /// Keep existing frames that were made with the same options and inputs.
    #[arg(long)]
    pub skip_existing: bool,
    /// Make only every n-th frame, starting with the i-th (from 0), so that n runs share a sweep.
    #[arg(long, value_name = "I/N")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shard: Option<Shard>,
    /// How previews show bright values; frames are not affected.
    #[arg(long, value_enum, default_value_t)]
    pub tone: ToneCurve,
    /// Stops by which previews are brightened.
    #[arg(long, value_name = "STOPS", default_value_t = FileOptions::default().exposure, allow_negative_numbers = true)]
    pub exposure: f32,
    /// Background of previews: a linear grey from 0 to 1, or an sRGB colour, as R,G,B with numbers from 0 to 255 or
    /// as #RRGGBB.
    #[arg(long, value_name = "GREY|COLOR", default_value_t = FileOptions::default().background)]
    pub background: Background,
    /// A moving preview of all frames, beside the contact sheet.
    #[arg(long, value_enum, default_value_t)]
    pub animation: Animation,
    /// Memory in MiB for the copy of the sample that shading reads, coarser levels included; the rest is kept in
    /// temporary files in the output folder, the finest levels first.
    #[arg(long, value_name = "MIB", default_value_t = FileOptions::default().table_memory)]
    pub table_memory: u64,
}

impl Default for FileOptions {
    fn default() -> Self {
        Self {
            layers: STANDARD_LAYERS.to_vec(),
            half: false,
            float: false,
            compression: Compression::default(),
            pattern: FramePattern::default(),
            skip_existing: false,
            shard: None,
            tone: ToneCurve::default(),
            exposure: 0.0,
            background: Background::default(),
            animation: Animation::default(),
            table_memory: 4096,
        }
    }
}

impl FileOptions {
    /// Refuses files without layers, and previews too bright or too dark to show anything.
    pub(super) fn validate(&self) -> Result<()> {
        let exposure = f64::from(self.exposure);
        check_numbers(&[("exposure", Some(exposure), [-100.0, 100.0])])?;
        match self.layers.is_empty() {
            true => Err(Error::option("layers", "none", "at least one")),
            false => Ok(()),
        }
    }
}
