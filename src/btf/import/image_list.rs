//! Everything a source says of its images.

use std::path::PathBuf;

use serde_json::{Map, Value};

use crate::btf::direction::Direction;
use crate::btf::import::family::Family;
use crate::btf::import::list_options::Handedness;
use crate::btf::import::near_field::NearPositions;
use crate::btf::import::place::Place;

/// One measured image.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasuredImage {
    /// The image file; in an archive its path, then the member's name.
    pub path: PathBuf,
    /// Where it was seen from.
    pub view: Direction,
    /// Where the light stood.
    pub light: Direction,
}

/// Everything a source says of its images.
#[derive(Clone, Debug)]
pub struct ImageList {
    /// The source's own name.
    pub name: String,
    /// The file that lists the images, or the folder or archive that holds them.
    pub path: PathBuf,
    /// The kind of source, for `btf.json`.
    pub kind: &'static str,
    /// Whose images they are.
    pub family: Family,
    /// Which way the list's y axis was taken to point, for `btf.json`.
    pub handedness: Handedness,
    /// The images, in the source's order.
    pub images: Vec<MeasuredImage>,
    /// Where the images are read from.
    pub place: Place,
    /// Whether the images should be every view with every light: directions come in the order of rings then,
    /// and repeated and missing ones are faults, not notes.
    pub is_set: bool,
    /// Where cameras and lamps stood, where the images are to be resampled for that.
    pub positions: Option<NearPositions>,
    /// What the user should know of the list.
    pub notes: Vec<String>,
    /// More of the source, for `btf.json`.
    pub facts: Map<String, Value>,
}
