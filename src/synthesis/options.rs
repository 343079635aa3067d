//! The options of synthesis, as read from the command line and from a scene file.

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};
use crate::sites::order::Order;

/// Which texels are tried at a site.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Search {
    /// The forward-shifted texels of the neighbours, and the nearest texels of each (Tong 2002 §5.2).
    #[default]
    KCoherence,
    /// Every whole texel.
    Full,
}

/// How the neighbourhoods of a site and a texel are compared.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum MetricKind {
    /// Through the Gram matrix Φ, in double precision (Tong 2002 §5.1): the reference.
    Gram,
    /// Through a factor of the centred Φ: the same distances as short dense vectors.
    #[default]
    Embedded,
}

/// Passes, sweeps or rounds at most: the orders of all sweeps are held together, and a few do.
const MOST_ROUNDS: u32 = 1000;
/// Distances are multiplied by no larger number: they are 32-bit floats.
const LARGEST_FACTOR: f64 = 1e12;

/// What synthesis can be asked. Each option says what the paper has where `Default` differs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, clap::Args)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
#[command(next_help_heading = "Synthesis")]
pub struct SynthesisOptions {
    /// Texels each coherent texel brings along, itself included; 1 suits natural textures
    /// [default: the table's]
    #[arg(long)]
    pub k: Option<usize>,
    /// Levels of the pyramid, the finest included; 1 grows the finest level from one random
    /// site [default: the table's]
    #[arg(long)]
    pub levels: Option<u32>,
    /// Width of the neighbourhood; it is the table's, and stating another is an error
    #[arg(long)]
    pub neighborhood: Option<u32>,
    /// Which texels are tried at a site
    #[arg(long, value_enum, default_value_t = Self::default().search)]
    pub search: Search,
    /// How neighbourhoods are compared
    #[arg(long, value_enum, default_value_t = Self::default().metric)]
    pub metric: MetricKind,
    /// Share of the centred Gram matrix's spectrum that the embedded metric keeps (above 0, to 1);
    /// plain images are always kept whole
    #[arg(long, default_value_t = Self::default().spectrum)]
    pub spectrum: f64,
    /// Prefer the coherent texels: the distances of others are multiplied by this (1 is the paper)
    #[arg(long, default_value_t = Self::default().coherence)]
    pub coherence: f64,
    /// Add this share of the distance of random texels to all distances, four times as much on each coarser
    /// level, so that differences between tiny distances do not outweigh coherence; 0 is the paper
    #[arg(long, default_value_t = Self::default().distance_floor)]
    pub distance_floor: f64,
    /// Passes per level: 1 only copies from the coarser level, 2 also compares two-level
    /// neighbourhoods (Tong 2002), each more repeats the second
    #[arg(long, default_value_t = Self::default().passes)]
    pub passes: u32,
    /// Rounds at the end in which the sites that fit far worse than the mean are searched in full, before all
    /// that fit worse choose once more; 0 is the paper. Of k-coherence only
    #[arg(long, default_value_t = Self::default().repair_rounds)]
    pub repair_rounds: u32,
    /// Sweeps over the coarsest level after its random start
    #[arg(long, default_value_t = Self::default().start_passes)]
    pub start_passes: u32,
    /// Penalty on texels that the coarsest level uses often: the distance of a texel used n times as often as
    /// the mean is multiplied by 1 + PENALTY·(n − 1); 0 is the paper. Of k-coherence only
    #[arg(long, default_value_t = Self::default().reuse_penalty)]
    pub reuse_penalty: f64,
    /// The order in which the coarsest level, or the only one, grows; finer levels are refined in
    /// parallel by colour classes
    #[arg(long, value_enum, default_value_t = Self::default().order)]
    pub order: Order,
    /// Seed of everything drawn at random.
    #[arg(skip)]
    pub seed: u64,
}

impl Default for SynthesisOptions {
    fn default() -> Self {
        Self {
            k: None,
            levels: None,
            neighborhood: None,
            search: Search::default(),
            metric: MetricKind::default(),
            spectrum: 0.97,
            coherence: 1.5,
            distance_floor: 0.001,
            passes: 3,
            repair_rounds: 2,
            start_passes: 2,
            reuse_penalty: 1.0,
            order: Order::default(),
            seed: 0,
        }
    }
}

impl SynthesisOptions {
    /// Checks every field by itself; [`check`](crate::synthesis::check) holds them against the inputs.
    pub fn validate(&self) -> Result<()> {
        let at_least_one = |option: &str, value: u64| {
            if value >= 1 {
                return Ok(());
            }
            Err(Error::option(option, value.to_string(), "1 or more"))
        };
        at_least_one("k", self.k.map_or(1, |k| k as u64))?;
        at_least_one("levels", self.levels.map_or(1, u64::from))?;
        let few = |option: &str, value: u32, least: u32| {
            if (least..=MOST_ROUNDS).contains(&value) {
                return Ok(());
            }
            Err(Error::option(
                option,
                value.to_string(),
                format!("{least} to {MOST_ROUNDS}: each visits every site of a level"),
            ))
        };
        few("passes", self.passes, 1)?;
        few("repair-rounds", self.repair_rounds, 0)?;
        few("start-passes", self.start_passes, 1)?;
        check_neighborhood(self.neighborhood)?;
        if !(self.spectrum > 0.0 && self.spectrum <= 1.0) {
            return Err(Error::option(
                "spectrum",
                self.spectrum.to_string(),
                "a share above 0, at most 1",
            ));
        }
        for (option, value, least) in [
            ("coherence", self.coherence, 1.0),
            ("distance-floor", self.distance_floor, 0.0),
            ("reuse-penalty", self.reuse_penalty, 0.0),
        ] {
            if !(least..=LARGEST_FACTOR).contains(&value) {
                return Err(Error::option(
                    option,
                    value.to_string(),
                    format!(
                        "{least} to {LARGEST_FACTOR:e}: distances times larger numbers overflow"
                    ),
                ));
            }
        }
        Ok(())
    }
}

fn check_neighborhood(width: Option<u32>) -> Result<()> {
    match width {
        Some(width) if width % 2 == 0 => Err(Error::option(
            "neighborhood",
            width.to_string(),
            "an odd width, as 5 or 7",
        )),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(change: impl FnOnce(&mut SynthesisOptions)) -> String {
        let mut options = SynthesisOptions::default();
        change(&mut options);
        options.validate().unwrap_err().to_string()
    }

    #[test]
    fn the_defaults_are_valid() {
        SynthesisOptions::default().validate().unwrap();
    }

    #[test]
    fn every_field_is_checked() {
        assert!(message(|o| o.k = Some(0)).contains("--k: 0"));
        assert!(message(|o| o.levels = Some(0)).contains("--levels: 0"));
        assert!(message(|o| o.neighborhood = Some(6)).contains("an odd width"));
        assert!(message(|o| o.spectrum = 0.0).contains("--spectrum: 0"));
        assert!(message(|o| o.spectrum = f64::NAN).contains("--spectrum: NaN"));
        assert!(message(|o| o.coherence = 0.5).contains("--coherence: 0.5"));
        assert!(message(|o| o.distance_floor = -0.1).contains("--distance-floor: -0.1"));
        assert!(message(|o| o.passes = 0).contains("--passes: 0"));
        assert!(message(|o| o.reuse_penalty = -0.1).contains("--reuse-penalty: -0.1"));
        assert!(message(|o| o.start_passes = 0).contains("--start-passes: 0"));
        assert!(message(|o| o.start_passes = u32::MAX).contains("1 to 1000: each visits"));
        assert!(message(|o| o.passes = 1001).contains("--passes: 1001"));
        assert!(message(|o| o.repair_rounds = u32::MAX).contains("0 to 1000"));
        assert!(message(|o| o.coherence = 1e308).contains("1 to 1e12"));
    }

    #[test]
    fn a_scene_file_states_the_same_fields() {
        let options: SynthesisOptions =
            toml::from_str("k = 5\nsearch = \"full\"\nmetric = \"gram\"\norder = \"field\"")
                .unwrap();
        assert_eq!(options.k, Some(5));
        assert_eq!(options.search, Search::Full);
        assert!(toml::from_str::<SynthesisOptions>("kk = 5").is_err());
    }
}
