//! The transition and the orientation of what is made, as options say them.

use std::path::PathBuf;
use std::str::FromStr;

use clap::Args;
use glam::DVec2;
use ndarray::{Array2, Array3};

use crate::cli::exemplar::controls::{read_orientation, read_transition};
use crate::cli::exemplar::reading::ImageReader;
use crate::error::{Error, Result};
use crate::grid::TexelGrid;
use crate::vary::filtering::MOST_OUTPUT;
use crate::vary::key_values::{
    Key, check_covers, orientation_of_keys, ramp, straight_orientation, transition_of_keys,
};

/// The options of the transition and the orientation.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Transition and orientation")]
pub struct FieldOptions {
    /// Direction in which the transition grows linearly, in degrees counter-clockwise from right
    #[arg(
        long,
        value_name = "DEGREES",
        default_value_t = 0.0,
        allow_negative_numbers = true
    )]
    pub ramp: f64,
    /// Share of the width up to which the ramp is 0
    #[arg(long, value_name = "X", default_value_t = 0.0)]
    pub ramp_begin: f64,
    /// Share of the width from which on the ramp is 1
    #[arg(long, value_name = "X", default_value_t = 1.0)]
    pub ramp_end: f64,
    /// A grey image of the transition, 0 to 1, in place of a ramp
    #[arg(long, value_name = "FILE")]
    pub transition: Option<PathBuf>,
    /// The transition at a pixel, in place of a ramp; two or more are needed, and other pixels are interpolated
    #[arg(long, value_name = "COL,ROW,VALUE", conflicts_with = "transition")]
    pub transition_key: Vec<KeyOption>,
    /// The radius of the Gaussians that interpolate the transition, in pixels [default: the mean distance from a key
    /// to the nearest other]
    #[arg(long, value_name = "PIXELS", requires = "transition_key")]
    pub transition_radius: Option<f64>,
    /// An image of the orientation: red is s (right), green is t (up) [default: right]
    #[arg(long, value_name = "FILE")]
    pub orientation_map: Option<PathBuf>,
    /// The orientation at a pixel, in degrees counter-clockwise from right; other pixels are interpolated
    #[arg(
        long,
        value_name = "COL,ROW,DEGREES",
        conflicts_with = "orientation_map",
        allow_hyphen_values = true
    )]
    pub orientation_key: Vec<KeyOption>,
    /// The radius of the Gaussians that interpolate the orientation, in pixels
    #[arg(long, value_name = "PIXELS", requires = "orientation_key")]
    pub orientation_radius: Option<f64>,
}

/// A key value at a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KeyOption(Key);

impl FromStr for KeyOption {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let numbers: Vec<f64> = text
            .split(',')
            .filter_map(|part| part.trim().parse().ok())
            .collect();
        match numbers[..] {
            [x, y, value] if text.split(',').count() == 3 => Ok(Self(Key {
                place: DVec2::new(x, y),
                value,
            })),
            _ => Err("expected COL,ROW,VALUE, as 40,12,0.5".into()),
        }
    }
}

/// The fields of what is made.
pub struct Fields {
    /// 0 to 1, [H, W].
    pub transition: Array2<f32>,
    /// Unit vectors (s, t), [H, W, 2].
    pub orientation: Array3<f32>,
}

impl FieldOptions {
    /// The images that are read.
    pub fn files(&self) -> impl Iterator<Item = &PathBuf> {
        [&self.transition, &self.orientation_map]
            .into_iter()
            .flatten()
    }

    /// Refuses what no input could satisfy.
    pub fn check(&self) -> Result<()> {
        let (begin, end) = (self.ramp_begin, self.ramp_end);
        if !(begin < end && begin >= 0.0 && end <= 1.0) {
            let found = format!("{begin} to --ramp-end {end}");
            return Err(Error::option(
                "ramp-begin",
                found,
                "0 or more and below --ramp-end, which is at most 1",
            ));
        }
        if !self.ramp.is_finite() {
            return Err(Error::option("ramp", self.ramp.to_string(), "degrees"));
        }
        for (name, radius) in [
            ("transition-radius", self.transition_radius),
            ("orientation-radius", self.orientation_radius),
        ] {
            if let Some(radius) = radius.filter(|radius| !(*radius > 0.0 && radius.is_finite())) {
                return Err(Error::option(name, radius.to_string(), "pixels above 0"));
            }
        }
        Ok(())
    }

    /// The fields of (rows, columns) pixels. Errors: an output too large, and a transition that covers less than
    /// the tolerance of a match.
    pub fn read(
        &self,
        (rows, cols): (usize, usize),
        tolerance: f64,
        reader: &mut ImageReader,
    ) -> Result<Fields> {
        // Refuse an output that is too large.
        if rows.saturating_mul(cols) > MOST_OUTPUT {
            let expected = format!("at most {MOST_OUTPUT} pixels");
            return Err(Error::option("size", format!("{cols}x{rows}"), expected));
        }
        let (size, keys) = ((rows, cols), |keys: &[KeyOption]| -> Vec<Key> {
            keys.iter().map(|key| key.0).collect()
        });
        let grid = TexelGrid {
            width: cols as u32,
            height: rows as u32,
            tileable: false,
        };
        // Take the transition from a file, from keys, or as a ramp.
        let transition = match &self.transition {
            Some(path) => read_transition(path, grid, reader)?,
            None if self.transition_key.is_empty() => {
                ramp(size, self.ramp, (self.ramp_begin, self.ramp_end))
            }
            None => transition_of_keys(size, &keys(&self.transition_key), self.transition_radius)?,
        };
        check_covers(&transition, tolerance).map_err(|error| match &self.transition {
            Some(path) => error.in_file(path),
            None => error,
        })?;
        // Take the orientation from a file or from keys, else straight up.
        let orientation = match &self.orientation_map {
            Some(path) => read_orientation(path, [grid.width, grid.height], reader)?,
            None if self.orientation_key.is_empty() => straight_orientation(size),
            None => {
                orientation_of_keys(size, &keys(&self.orientation_key), self.orientation_radius)?
            }
        };
        Ok(Fields {
            transition,
            orientation,
        })
    }
}
