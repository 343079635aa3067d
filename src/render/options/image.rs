//! The pixels of a frame: how many there are, and how their colour is found.

use serde::Serialize;

use crate::error::{Error, Result};
use crate::render::btf_lookup::Texels;
use crate::render::nearest::Weighting;
use crate::render::option_values::{ImageSize, Mip};
use crate::render::parallax::Parallax;
use crate::render::raster::Samples;
use crate::render::renderer::{Shading, Shadows};

/// How the colour of pixels is found.
#[derive(Clone, Debug, PartialEq, Serialize, clap::Args)]
#[serde(rename_all = "kebab-case")]
#[command(next_help_heading = "Picture")]
pub struct ImageOptions {
    /// Columns × rows of a frame.
    #[arg(long, value_name = "WxH", default_value_t = ImageOptions::default().size)]
    pub size: ImageSize,
    /// Samples per pixel for antialiasing.
    #[arg(long, value_enum, default_value_t)]
    pub samples: Samples,
    /// Where colours are evaluated.
    #[arg(long, value_enum, default_value_t)]
    pub shading: Shading,
    /// Where cast shadows are computed.
    #[arg(long, value_enum, default_value_t)]
    pub shadows: Shadows,
    /// How images of nearby directions are weighted.
    #[arg(long, value_enum, default_value_t)]
    pub weights: Weighting,
    /// How the sample is interpolated between texels. [default: bilinear with pixel shading, nearest with vertex
    /// shading]
    #[arg(long, value_enum)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub texels: Option<Texels>,
    /// Correct parallax before views are blended: read each view at the texel that shows the visible point, by the
    /// sample's heights.
    #[arg(long, value_enum, default_value_t)]
    pub parallax: Parallax,
    /// Coarser levels of the sample for distant surfaces.
    #[arg(long, value_enum, default_value_t)]
    pub mip: Mip,
}

impl Default for ImageOptions {
    fn default() -> Self {
        Self {
            size: ImageSize([960, 720]),
            samples: Samples::default(),
            shading: Shading::default(),
            shadows: Shadows::default(),
            weights: Weighting::default(),
            texels: None,
            parallax: Parallax::default(),
            mip: Mip::default(),
        }
    }
}

impl ImageOptions {
    /// How values between texels are found: as asked, or as the shading needs it. Pixels show single texels.
    pub fn texels(&self) -> Texels {
        self.texels.unwrap_or(match self.shading {
            Shading::Vertex => Texels::Nearest,
            Shading::Pixel => Texels::Bilinear,
        })
    }

    /// Refuses sizes that no frame has.
    pub(super) fn validate(&self) -> Result<()> {
        match self.size.is_possible() {
            true => Ok(()),
            false => Err(Error::option(
                "size",
                self.size.to_string(),
                ImageSize::expected(),
            )),
        }
    }

    /// Whether coarser levels of the sample are used.
    pub fn uses_mip(&self) -> bool {
        match self.mip {
            Mip::Auto => self.shading == Shading::Pixel,
            Mip::On => true,
            Mip::Off => false,
        }
    }
}
