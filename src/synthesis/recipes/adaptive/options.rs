//! What the adaptive method can be asked beside what every method can.

use serde::Serialize;

use crate::error::{Error, Result};
use crate::synthesis::own_options::OwnOptions;

/// Rings at most: a neighbourhood of this many texels each way.
const MOST_RINGS: u32 = 8;
/// The widest range of pixel links, in texels.
const WIDEST_LINKS: u32 = 8;

/// How candidates are compared at the lowest resolution.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Similarity {
    /// At growing sizes, until one candidate is left (Chen 2008 §5.2)
    #[default]
    Adaptive,
    /// By the sum of squared differences over the whole neighbourhood
    Plain,
}

/// The options of the adaptive method.
#[derive(Clone, Debug, PartialEq, Serialize, clap::Args)]
#[serde(rename_all = "kebab-case")]
#[command(next_help_heading = "Method adaptive")]
pub struct AdaptiveOptions {
    /// Rings of the round neighbourhood, one texel apart: the largest size that is compared
    #[arg(long, default_value_t = Self::default().rings)]
    pub rings: u32,
    /// How candidates are compared at the lowest resolution
    #[arg(long, value_enum, default_value_t = Self::default().similarity)]
    pub similarity: Similarity,
    /// Greatest distance of a finer level's texel from its pixel links, in texels
    #[arg(long, default_value_t = Self::default().link_range)]
    pub link_range: u32,
}

impl Default for AdaptiveOptions {
    fn default() -> Self {
        Self {
            rings: 3,
            similarity: Similarity::default(),
            link_range: 2,
        }
    }
}

impl OwnOptions for AdaptiveOptions {
    fn validate(&self) -> Result<()> {
        let within = |option: &str, value: u32, least: u32, most: u32| {
            if (least..=most).contains(&value) {
                return Ok(());
            }
            let expected = format!("{least} to {most}");
            Err(Error::option(option, value.to_string(), expected))
        };
        within("rings", self.rings, 1, MOST_RINGS)?;
        within("link-range", self.link_range, 0, WIDEST_LINKS)
    }

    fn changed(&self) -> Vec<(&'static str, bool)> {
        let default = Self::default();
        vec![
            ("rings", self.rings != default.rings),
            ("similarity", self.similarity != default.similarity),
            ("link-range", self.link_range != default.link_range),
        ]
    }
}
