//! What an OpenEXR file holds that is no picture: the names of its channels, and each for itself.

/// Channels of OpenEXR, each for itself.
#[derive(Clone, Debug, PartialEq)]
pub struct Planes {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// The name of each channel and its numbers, row-major from the top, as stored.
    pub channels: Vec<(String, Vec<f32>)>,
}

/// What the first part of an OpenEXR file holds.
#[derive(Clone, Debug, PartialEq)]
pub struct ExrContent {
    /// The names of its channels.
    pub channels: Vec<String>,
    /// Whether the file says which colours its numbers are.
    pub states_color: bool,
}
