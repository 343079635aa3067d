//! The values of options: what an image is, how its numbers stand for light, what becomes of its alpha.

use clap::ValueEnum;

use crate::exemplar::channels::ChannelKind;
use crate::format::image::SourceEncoding;

/// What an image is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum KindOption {
    /// The first image is colour; of others the words of file names decide, then grey ones are heights
    Auto,
    /// Colour
    Color,
    /// Heights, in any unit
    Height,
    /// Any other number from 0 to 1: roughness, metal, parts of a pattern
    Mask,
    /// How opaque each texel is
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

/// How an image's numbers stand for light, if they do.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ImageEncoding {
    /// Colours as their files say (where they say nothing: integers by the sRGB curve, floats in
    /// proportion); all else as it stands
    Auto,
    /// By the sRGB curve, whatever the file says
    Srgb,
    /// In proportion, whatever the file says
    Linear,
    /// Not at all: the numbers are used as they stand
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

/// What becomes of texels that are not opaque.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum AlphaOption {
    /// In colours they are an error, in other images alpha is not used
    Refuse,
    /// Their numbers are taken as the file stores them
    Ignore,
    /// So, and alpha becomes a channel of its own after its image's
    Keep,
}
