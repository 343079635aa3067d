//! What a caller wants of an image: colour or plain numbers, and what to do where a file leaves a choice.

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};

/// What the numbers of an image are read for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Purpose {
    /// Light: brought to linear Rec. 709, or left in sRGB where the file is sRGB.
    #[default]
    Color,
    /// Heights, roughness, normals: the numbers as the file stores them, whatever it says of colour.
    Data,
}

/// How the numbers of an image encode light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum SourceEncoding {
    /// As the file states (ICC profile, gamma, chromaticities); without such data integers are sRGB and floats linear.
    #[default]
    Auto,
    /// sRGB, whatever the file states.
    Srgb,
    /// Linear, with the primaries of Rec. 709, whatever the file states.
    Linear,
    /// Gamma 2.2, with the primaries of Rec. 709, whatever the file states.
    #[serde(rename = "gamma-2.2")]
    #[value(name = "gamma-2.2")]
    Gamma22,
    /// Linear CIE XYZ tristimulus values under D65, whatever the file states.
    Xyz,
}

/// Which way up an image is read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Orientation {
    /// Rotated as the file's orientation tag states.
    #[default]
    Upright,
    /// As the rows are stored, whatever the tag states.
    Stored,
}

/// What to do with texels that are not opaque.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Alpha {
    /// Refuse the image, because the colour of such texels is not known.
    #[default]
    Refuse,
    /// Use their colours as stored.
    Ignore,
    /// Composite them over black; for images of light, which are dark where nothing shines.
    #[serde(skip)]
    #[value(skip)]
    OverBlack,
    /// Keep their alpha beside the colours, which stay as stored.
    #[serde(skip)]
    #[value(skip)]
    Keep,
}

/// What becomes of pixels of an OpenEXR display window that the data window does not cover.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Missing {
    /// They are an error: texels without a value.
    #[default]
    Refuse,
    /// They are black.
    Black,
}

/// What becomes of colours that Rec. 709 shows only with negative numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Gamut {
    /// The negative numbers are set to 0, with a note.
    #[default]
    Clip,
    /// They are kept.
    Keep,
}

/// The flags of a command that decide how an image is read, for the advice in errors; empty: no such flag.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Flags {
    /// Names a layer.
    pub layer: &'static str,
    /// Says how numbers stand for light.
    pub encoding: &'static str,
    /// Says what becomes of transparent texels.
    pub alpha: &'static str,
    /// Says which way up.
    pub orientation: &'static str,
}

impl Flags {
    /// Those of commands that read images the usual way.
    pub const USUAL: Self = Self {
        layer: "--layer",
        encoding: "--encoding",
        alpha: "--alpha",
        orientation: "--orientation",
    };
}

/// How an image is to be read.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ReadOptions {
    /// What the numbers are read for.
    pub purpose: Purpose,
    /// How colours stand for light; of no effect on data.
    pub encoding: SourceEncoding,
    /// Which way up.
    pub orientation: Orientation,
    /// What becomes of transparent texels; in data they are used, with a note.
    pub alpha: Alpha,
    /// What becomes of pixels without a value.
    pub missing: Missing,
    /// What becomes of colours outside Rec. 709.
    pub gamut: Gamut,
    /// The layer, part, view or channel of an OpenEXR file; files without layers are read as they are.
    pub layer: Option<String>,
    /// The flags that stand for all this.
    pub flags: Flags,
}

impl ReadOptions {
    /// Refuses a layer's name that no file had layers for.
    pub fn check_layer_taken(&self, taken: bool) -> Result<()> {
        match &self.layer {
            Some(name) if !taken => Err(Error::option(
                self.flags.layer.trim_start_matches('-'),
                format!("`{name}`, but no file has layers"),
                "OpenEXR files with layers, or no --layer",
            )),
            _ => Ok(()),
        }
    }

    /// Plain numbers, not light.
    pub fn data() -> Self {
        Self {
            purpose: Purpose::Data,
            ..Self::default()
        }
    }
}
