//! What a user can say of a list of images: where the images are, and which way its axes point.

use std::path::PathBuf;

use clap::ValueEnum;
use glam::DVec3;
use serde::{Deserialize, Serialize};

use crate::btf::direction::Direction;

/// How a list of images is read.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, clap::Args)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct ListOptions {
    /// Where the images are: a folder, or a pattern in quotes as "photos/*.jpg". Files that have the names
    /// of the list go with these. Where none has, as with the list of a calibrated dome, they are sorted
    /// (2 before 10) and taken in the order of the list; there must be as many.
    #[arg(long, value_name = "FOLDER|GLOB")]
    pub images: Option<PathBuf>,
    /// Which way the list's y axis points where x is image right and z points to the camera: `right`, up
    /// the image; `left`, down the image. With `left` y changes its sign (φ runs clockwise); x and z stay.
    #[arg(long, value_enum, default_value_t = ListOptions::default().handedness)]
    pub handedness: Handedness,
}

/// Which way the y axis of a list points.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Handedness {
    /// Up the image: x, y and z are right-handed.
    #[default]
    Right,
    /// Down the image: x, y and z are left-handed.
    Left,
}

impl Handedness {
    /// A direction of the list in the sample's frame.
    pub(super) fn applied_to(self, direction: Direction) -> Direction {
        let DVec3 { x, y, z } = direction.0;
        match self {
            Self::Right => direction,
            Self::Left => Direction(DVec3::new(x, -y, z)),
        }
    }
}
