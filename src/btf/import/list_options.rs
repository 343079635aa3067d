//! What a user can say of a list of images: where the images are, and which way its axes point.

use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;

use clap::ValueEnum;
use glam::DVec3;
use serde::Serialize;

use crate::btf::direction::Direction;

/// How a list of images is read.
#[derive(Clone, Debug, Default, PartialEq, Serialize, clap::Args)]
#[serde(rename_all = "kebab-case")]
pub struct ListOptions {
    /// Where the images are: a folder, or a quoted pattern such as "photos/*.jpg". Images are matched with the list
    /// by name. If no name matches, as with the list of a calibrated dome, they are sorted (2 before 10) and assigned
    /// in the order of the list; their number must be the same.
    #[arg(long, value_name = "FOLDER|GLOB")]
    pub images: Option<PathBuf>,
    /// Direction of the list's y axis, with x to image right and z to the camera: `right`, up the image; `left`, down
    /// the image. With `left` y changes its sign (φ runs clockwise); x and z do not.
    #[arg(long, value_enum, default_value_t = ListOptions::default().handedness)]
    pub handedness: Handedness,
    /// Size of the patch in millimetres, for tables of positions. The report then states how much directions differ
    /// over the patch.
    #[arg(long, value_name = "WxH")]
    pub patch_mm: Option<PatchSize>,
    /// Resample images of near cameras and lamps if directions on the patch differ by more than DEGREES from those at
    /// its centre. Needs --patch-mm. [default without DEGREES: 2]
    #[arg(long, value_name = "DEGREES", num_args = 0..=1, default_missing_value = "2")]
    pub near_field: Option<f64>,
    /// The light is at the camera, like a flash beside the lens: each view is also the light. Tables then have no
    /// columns of lights, and positions of a .lp file are those of camera and flash.
    #[arg(long)]
    pub collocated: bool,
}

impl ListOptions {
    /// The flag of an option for lists alone that was given, if any was.
    pub fn given(&self) -> Option<&'static str> {
        let flags = [
            (self.images.is_some(), "images"),
            (self.patch_mm.is_some(), "patch-mm"),
            (self.near_field.is_some(), "near-field"),
            (self.collocated, "collocated"),
        ];
        let given = flags.into_iter().find(|(is_given, _)| *is_given);
        given.map(|(_, flag)| flag)
    }
}

/// The size of a patch in millimetres.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(into = "String")]
pub struct PatchSize {
    /// Along x.
    pub width: f64,
    /// Along y.
    pub height: f64,
}

impl FromStr for PatchSize {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let fault = || format!("`{text}`: expected WIDTHxHEIGHT in mm, as 50x40");
        let (width, height) = text.split_once('x').ok_or_else(fault)?;
        let side = |text: &str| text.parse().ok().filter(|side| (1e-3..=1e6).contains(side));
        match (side(width), side(height)) {
            (Some(width), Some(height)) => Ok(Self { width, height }),
            _ => Err(fault()),
        }
    }
}

impl fmt::Display for PatchSize {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}x{}", self.width, self.height)
    }
}

impl From<PatchSize> for String {
    fn from(size: PatchSize) -> Self {
        size.to_string()
    }
}

/// Which way the y axis of a list points.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, ValueEnum)]
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
    pub(crate) fn applied_to(self, direction: Direction) -> Direction {
        let DVec3 { x, y, z } = direction.0;
        match self {
            Self::Right => direction,
            Self::Left => Direction(DVec3::new(x, -y, z)),
        }
    }
}
