//! The values of options: what an image is, how its numbers stand for light, what becomes of its alpha.

use clap::ValueEnum;

use crate::exemplar::channels::ChannelKind;
use crate::format::image::SourceEncoding;

/// What an image is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum KindOption {
    /// The first image is colour; others by the words of their file names, and grey ones are heights
    Auto,
    /// Colour
    Color,
    /// Heights, in any unit
    Height,
    /// Any other value from 0 to 1: roughness, metal, parts of a pattern
    Mask,
    /// Opacity of each texel
    Alpha,
    /// Normals: red, green and blue are x, y and z
    Normal,
}

impl KindOption {
    pub(super) fn stated(self) -> Option<ChannelKind> {
        match self {
            Self::Auto => None,
            Self::Color => Some(ChannelKind::Color),
            Self::Height => Some(ChannelKind::Height),
            Self::Mask => Some(ChannelKind::Mask),
            Self::Alpha => Some(ChannelKind::Alpha),
            Self::Normal => Some(ChannelKind::Normal),
        }
    }
}

/// How an image's numbers encode light, if they do.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ImageEncoding {
    /// Colours as their files state (without such data integers are sRGB, floats linear); everything else unchanged
    Auto,
    /// sRGB, whatever the file states
    Srgb,
    /// Linear, whatever the file states
    Linear,
    /// None: the numbers are used as stored
    Data,
}

impl ImageEncoding {
    /// The encoding of light it stands for; for `data` none.
    pub(super) fn of_light(self) -> Option<SourceEncoding> {
        match self {
            Self::Auto => Some(SourceEncoding::Auto),
            Self::Srgb => Some(SourceEncoding::Srgb),
            Self::Linear => Some(SourceEncoding::Linear),
            Self::Data => None,
        }
    }
}

/// What to do with texels that are not opaque.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum AlphaOption {
    /// Refuse them in colours; in other images alpha is not used
    Refuse,
    /// Use their numbers as stored
    Ignore,
    /// As `ignore`, and alpha becomes a channel of its own after its image's
    Keep,
}
