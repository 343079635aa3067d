//! Which frames are made, and what changes from one to the next.

use serde::Serialize;

use crate::error::Result;
use crate::render::frame_range::{FrameRange, LAST_FRAME};
use crate::render::option_values::Sweep;
use crate::render::options::ranges::{ANGLES, check_counts, check_numbers};

/// What changes from frame to frame, and which frames are made.
#[derive(Clone, Debug, PartialEq, Serialize, clap::Args)]
#[serde(rename_all = "kebab-case")]
#[command(next_help_heading = "Sweep")]
pub struct SweepOptions {
    /// What changes from frame to frame: none, light-azimuth, light-elevation, light-spiral,
    /// view-orbit, or a .csv file with a row for each frame (columns: see docs/rendering.md).
    #[arg(id = "sweep", long = "sweep", value_name = "SWEEP", default_value_t = Sweep::None)]
    #[serde(rename = "sweep")]
    pub kind: Sweep,
    /// Frames to make: a count, or a range of the sweep as 10-20 or 1-240x2. [default: 1 without a sweep, 24 with one,
    /// all rows of a file]
    #[arg(long, value_name = "N|RANGE")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frames: Option<FrameRange>,
    /// Frames of the whole sweep. [default: the end of --frames]
    #[arg(long, value_name = "N")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sweep_length: Option<u32>,
    /// Start of the sweep in degrees. [default: the light's azimuth for light-azimuth, 0 for light-elevation, elevation
    /// 90 for light-spiral, 0 for view-orbit]
    #[arg(long, value_name = "DEGREES", allow_negative_numbers = true)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sweep_from: Option<f64>,
    /// End of the sweep in degrees. A full turn ends one step before its start. [default: 360 beyond the start;
    /// elevation 180 for light-elevation, 10 for light-spiral]
    #[arg(long, value_name = "DEGREES", allow_negative_numbers = true)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sweep_to: Option<f64>,
    /// Turns of the light in a light-spiral.
    #[arg(long, default_value_t = SweepOptions::default().turns)]
    pub turns: f64,
}

impl Default for SweepOptions {
    fn default() -> Self {
        Self {
            kind: Sweep::None,
            frames: None,
            sweep_length: None,
            sweep_from: None,
            sweep_to: None,
            turns: 3.0,
        }
    }
}

impl SweepOptions {
    /// Refuses values that no sweep can have.
    pub(super) fn validate(&self) -> Result<()> {
        check_numbers(&[
            ("sweep-from", self.sweep_from, ANGLES),
            ("sweep-to", self.sweep_to, ANGLES),
            ("turns", Some(self.turns), [-10_000.0, 10_000.0]),
        ])?;
        let length = self.sweep_length.unwrap_or(1);
        check_counts(&[(
            "sweep-length",
            length,
            LAST_FRAME,
            "frames have no larger numbers",
        )])
    }
}
