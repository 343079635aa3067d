//! What an image file states, for people who ask why it is read as it is.

use serde::Serialize;

/// A channel of an image.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Channel {
    /// Its full name, layer included.
    pub name: String,
    /// Its number type, as "half" or "8-bit integers".
    pub numbers: String,
    /// Pixels per sample across and down; 1, 1 except for subsampled OpenEXR.
    pub sampling: [usize; 2],
}

/// A part of an OpenEXR file; other formats have one.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Part {
    /// Its name; may be empty.
    pub name: String,
    /// Its view, as "left"; may be empty.
    pub view: String,
    /// Its layers that can be asked for by name.
    pub layers: Vec<String>,
    /// Its channels.
    pub channels: Vec<Channel>,
    /// First column, first row, last column, last row that hold data, where the format has windows.
    pub data_window: Option<[i64; 4]>,
    /// The same of the picture.
    pub display_window: Option<[i64; 4]>,
    /// How its numbers are packed.
    pub compression: String,
    /// Header attributes that have no field here: name and value.
    pub attributes: Vec<(String, String)>,
}

/// How much of an image is not opaque.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Transparency {
    /// Texels that are not opaque.
    pub transparent: u64,
    /// Texels whose colour cannot be seen at all.
    pub invisible: u64,
    /// Whether colours are multiplied by alpha in the file.
    pub premultiplied: bool,
}

/// What a file says.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Facts {
    /// The format, as "PNG".
    pub format: String,
    /// Columns and rows, before they are turned upright.
    pub size: [u64; 2],
    /// Width of a pixel over its height.
    pub pixel_aspect: f64,
    /// What the file says of its colours; empty where it says nothing.
    pub color: String,
    /// How its colours are read unless an option says otherwise.
    pub reading: String,
    /// Orientation as EXIF counts it, 1 to 8; 1 is upright.
    pub orientation: u8,
    /// The alpha channel, where there is one and it was read.
    pub alpha: Option<Transparency>,
    /// Pictures in the file: frames, pages. The first is read.
    pub pictures: u64,
    /// Parts, or the one part there is.
    pub parts: Vec<Part>,
}
