//! How an atlas is prepared: the options, checked.

use clap::{Args, ValueEnum};
use serde::Serialize;

use crate::error::{Error, Result};
use crate::mesh::field::guides::{Alignment, GuideOptions};
use crate::neighborhood::{Neighborhood, check_level_widths, level_widths};

/// How the neighbourhoods of texels are sampled.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Sampling {
    /// In a planar chart round each vertex (Ying 2001 §4.2)
    #[default]
    Charts,
    /// Along a straight path to each sample (Ying 2001 §4.1)
    Marching,
}

/// What the charts of an atlas are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum ChartSource {
    /// The parts of the mesh's texture coordinates, or of new ones
    #[default]
    Uv,
    /// A square for each face of a mesh of quadrilaterals, whose Catmull-Clark surface is textured (Ying 2001 §4.2)
    Faces,
}

/// How an atlas is prepared.
#[derive(Clone, Debug, PartialEq, Serialize, Args)]
#[serde(rename_all = "kebab-case")]
pub struct AtlasOptions {
    /// Levels of the pyramid, each with half the resolution (Ying 2001 §4). Set by synthesis.
    #[arg(skip = AtlasOptions::default().levels)]
    pub levels: u32,
    /// Width of the neighbourhood in texels of the texture, odd. Set by the neighbour table in synthesis.
    #[arg(skip = AtlasOptions::default().neighborhood)]
    pub neighborhood: u32,
    /// Width of the parent level's neighbourhood, odd. Set by the neighbour table.
    #[arg(skip = AtlasOptions::default().coarse_neighborhood)]
    pub coarse_neighborhood: u32,
    /// Texels along each side of the atlas.
    #[arg(long, value_name = "N", default_value_t = AtlasOptions::default().resolution)]
    pub resolution: u32,
    /// Factor on the size of the texture on the surface. At 1, texels of the texture and of the atlas cover the same
    /// area on average.
    #[arg(long, value_name = "X", default_value_t = AtlasOptions::default().texture_scale)]
    pub texture_scale: f64,
    /// Make new texture coordinates instead of taking the mesh's own.
    #[arg(long)]
    pub unwrap: bool,
    /// What the charts of the atlas are.
    #[arg(long, value_enum, default_value_t = ChartSource::Uv)]
    pub charts: ChartSource,
    /// How the neighbourhoods of texels are sampled.
    #[arg(long, value_enum, default_value_t = Sampling::Charts)]
    pub sampling: Sampling,
    /// What guides the orientation field. Set by the options of the surface.
    #[arg(skip)]
    #[serde(skip)]
    pub guides: GuideOptions,
    /// Seed of everything drawn at random.
    #[arg(skip)]
    pub seed: u64,
}

impl Default for AtlasOptions {
    fn default() -> Self {
        Self {
            levels: 4,
            neighborhood: 7,
            coarse_neighborhood: 3,
            resolution: 1024,
            texture_scale: 1.0,
            unwrap: false,
            charts: ChartSource::Uv,
            sampling: Sampling::Charts,
            guides: GuideOptions::default(),
            seed: 0,
        }
    }
}

/// The most texels along a side: their number fits [`MOST_TEXELS`](crate::mesh::atlas::MOST_TEXELS).
const MOST_RESOLUTION: u32 = 8192;
/// The smallest and the largest factor on the size of the texture.
const TEXTURE_SCALES: std::ops::RangeInclusive<f64> = 1.0 / 64.0..=64.0;

impl AtlasOptions {
    /// The same options for the square windows of as many levels, finest first.
    #[must_use]
    pub fn with_neighborhoods(self, neighborhoods: &[Neighborhood]) -> Self {
        let (levels, [neighborhood, coarse_neighborhood]) = level_widths(neighborhoods);
        Self {
            levels,
            neighborhood,
            coarse_neighborhood,
            ..self
        }
    }

    /// Checks every field.
    pub fn validate(&self) -> Result<()> {
        check_level_widths(self.levels, [self.neighborhood, self.coarse_neighborhood])?;
        if !(1..=MOST_RESOLUTION).contains(&self.resolution) {
            return Err(Error::option(
                "resolution",
                self.resolution.to_string(),
                format!("1 to {MOST_RESOLUTION} texels"),
            ));
        }
        if !TEXTURE_SCALES.contains(&self.texture_scale) {
            let (least, most) = (TEXTURE_SCALES.start(), TEXTURE_SCALES.end());
            return Err(Error::option(
                "texture-scale",
                self.texture_scale.to_string(),
                format!("{least} to {most}"),
            ));
        }
        self.check_charts()?;
        self.guides.validate()
    }

    /// Refuses faces as charts together with what needs texture coordinates.
    fn check_charts(&self) -> Result<()> {
        if self.charts == ChartSource::Uv {
            return Ok(());
        }
        if self.unwrap {
            return Err(Error::option(
                "charts",
                "faces together with --unwrap",
                "one of the two",
            ));
        }
        if self.guides.align == Alignment::Uv {
            return Err(Error::option(
                "align",
                "uv together with --charts faces, which has no texture coordinates of the mesh's own",
                "smooth or curvature",
            ));
        }
        Ok(())
    }
}
