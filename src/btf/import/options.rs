//! How an image set becomes a sample.

use std::f32::consts::FRAC_1_PI;

use serde::Serialize;

use crate::btf::direction::Direction;
use crate::btf::import::family::Family;
use crate::btf::import::photographs::PhotographOptions;
use crate::btf::import::prepare::Preparation;
use crate::btf::import::size_line::SizeLine;
use crate::btf::import::spectrum::Illuminant;
use crate::btf::sample::DType;
use crate::format::image::{Alpha, Flags, Orientation, ReadOptions, SourceEncoding};

/// How an image set becomes a sample.
#[derive(Clone, Debug, PartialEq, Serialize, clap::Args)]
#[serde(rename_all = "kebab-case")]
pub struct ImportOptions {
    /// What the images' numbers mean.
    #[arg(long, value_enum, default_value_t = ImportOptions::default().values)]
    pub values: Values,
    /// How the images' numbers encode light.
    #[arg(long, value_enum, default_value_t = ImportOptions::default().encoding)]
    pub encoding: SourceEncoding,
    /// The illuminant of spectral images. [default: D65]
    #[arg(long, value_enum)]
    pub illuminant: Option<Illuminant>,
    /// How the size line of Radiance files in sets of Bonn is read.
    #[arg(long, value_enum, default_value_t = ImportOptions::default().size_line)]
    pub size_line: SizeLine,
    /// Whether the orientation tag of images is applied. By default it is not: a camera's tag may differ from shot to
    /// shot of one capture, and lights are stated in the frame of the stored image.
    #[arg(long, value_enum, default_value_t = ImportOptions::default().orientation)]
    pub orientation: Orientation,
    /// What to do with texels that are not opaque.
    #[arg(long, value_enum, default_value_t = ImportOptions::default().alpha)]
    pub alpha: Alpha,
    /// The layer, part, view or channel to read from an OpenEXR file that has several; `mesotex info IMAGE` lists them.
    #[arg(long, value_name = "NAME")]
    pub layer: Option<String>,
    /// Opposite borders of the images continue each other.
    #[arg(long)]
    pub tileable: bool,
    /// Side of a pixel of the images in millimetres, if known. With --downsample N a texel is N times as wide.
    #[arg(long)]
    pub texel_mm: Option<f64>,
    /// Name of the material. [default: the source's own name]
    #[arg(long)]
    pub name: Option<String>,
    /// Number type of the sample.
    #[arg(long, value_enum, default_value_t = ImportOptions::default().dtype)]
    pub dtype: DType,
    /// What happens to the pictures, and which are used.
    #[command(flatten)]
    pub preparation: Preparation,
    /// Where the patch lies in the pictures, where these are photographs.
    #[command(flatten)]
    #[serde(skip)]
    pub photographs: PhotographOptions,
}

impl Default for ImportOptions {
    fn default() -> Self {
        Self {
            values: Values::default(),
            encoding: SourceEncoding::default(),
            illuminant: None,
            size_line: SizeLine::default(),
            orientation: Orientation::Stored,
            alpha: Alpha::default(),
            layer: None,
            tileable: false,
            texel_mm: None,
            name: None,
            dtype: DType::default(),
            preparation: Preparation::default(),
            photographs: PhotographOptions::default(),
        }
    }
}

impl ImportOptions {
    /// The flag of an option for image files that was given, if any was.
    pub fn given_for_images(&self) -> Option<&'static str> {
        let flags = [
            (self.alpha != Alpha::default(), "alpha"),
            (self.orientation != Orientation::Stored, "orientation"),
            (self.layer.is_some(), "layer"),
            (self.illuminant.is_some(), "illuminant"),
            (self.size_line != SizeLine::default(), "size-line"),
            (self.photographs != PhotographOptions::default(), "corners"),
        ];
        let given = flags.into_iter().find(|(is_given, _)| *is_given);
        given.map(|(_, flag)| flag)
    }

    /// How each image is read.
    pub(super) fn reading(&self) -> ReadOptions {
        ReadOptions {
            encoding: self.encoding,
            orientation: self.orientation,
            alpha: self.alpha,
            layer: self.layer.clone(),
            flags: Flags::USUAL,
            ..ReadOptions::default()
        }
    }
}

/// What the images' numbers mean.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Values {
    /// As the format defines them: without the light's cosine in Bonn's SPECTRAL, else reflectance.
    #[default]
    Auto,
    /// Reflectance times the light's cosine: a white plane facing the light has 1 (divided by π).
    Reflectance,
    /// Reflectance without the light's cosine: a white plane has 1 from every light.
    NoCosine,
    /// Radiance for unit irradiance: a white plane facing the light has 1/π (taken as it is).
    Radiance,
}

impl Values {
    /// What numbers of a family mean, where the user did not say.
    pub(in crate::btf) fn of_family(self, family: Family) -> Self {
        match (self, family) {
            (Self::Auto, Family::Spectral) => Self::NoCosine,
            (Self::Auto, _) => Self::Reflectance,
            (stated, _) => stated,
        }
    }

    /// Radiance for unit irradiance per number of an image that is lit from `light`.
    pub(in crate::btf) fn radiance_per_number(self, family: Family, light: Direction) -> f32 {
        match self.of_family(family) {
            Self::Radiance => 1.0,
            Self::NoCosine => light.cos_theta().max(0.0) as f32 * FRAC_1_PI,
            Self::Auto | Self::Reflectance => FRAC_1_PI,
        }
    }
}
