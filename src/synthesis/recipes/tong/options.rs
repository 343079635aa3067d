//! What k-coherence can be asked beside what every method can. Each option says what the paper has where
//! the default differs.

use serde::Serialize;

use crate::error::Result;
use crate::sites::order::Order;
use crate::synthesis::option_ranges::{at_least_one, few_rounds, within_factors};
use crate::synthesis::own_options::OwnOptions;
use crate::synthesis::polish::Effort;

/// Which texels are tried at a site.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum CandidateSearch {
    /// The forward-shifted texels of the neighbours, and the nearest texels of each (Tong 2002 §5.2).
    #[default]
    KCoherence,
    /// Every whole texel.
    Full,
}

/// The options of k-coherence.
#[derive(Clone, Debug, PartialEq, Serialize, clap::Args)]
#[serde(rename_all = "kebab-case")]
#[command(next_help_heading = "Method k-coherence")]
pub struct KCoherenceOptions {
    /// Nearest texels that are tried with each coherent texel, itself included; 1 suits natural textures [default:
    /// the table's]
    #[arg(long)]
    pub k: Option<usize>,
    /// Which texels are tried at a site
    #[arg(long, value_enum, default_value_t = Self::default().search)]
    pub search: CandidateSearch,
    /// Preference for coherent texels: the distances of all others are multiplied by this; 1 as in the paper
    #[arg(long, default_value_t = Self::default().coherence)]
    pub coherence: f64,
    /// Constant added to all distances, as a share of the mean distance of random texels. It keeps differences between
    /// tiny distances from outweighing coherence, and is four times as large on each coarser level. 0 as in the paper
    #[arg(long, default_value_t = Self::default().distance_floor)]
    pub distance_floor: f64,
    /// Rounds of repair after synthesis: a full search at sites whose distances are far above the mean, then a new
    /// choice at all sites above the mean. 0 as in the paper. Not with --search full
    #[arg(long, default_value_t = Self::default().repair_rounds)]
    pub repair_rounds: u32,
    /// Rounds of polishing after synthesis: whole regions take one copied patch where that hides seams and uses the
    /// exemplar more evenly. auto: one round over regions with repeated texels if the sample does not tile, otherwise
    /// none. 0 as in the paper
    #[arg(long, value_name = "ROUNDS", default_value_t = Self::default().polish)]
    pub polish: Effort,
    /// Sweeps over the coarsest level after its random start
    #[arg(long, default_value_t = Self::default().start_passes)]
    pub start_passes: u32,
    /// Penalty on texels (coarsest level) and textons (finer levels) that are used too often: if one is used n times as
    /// often as in the sample, its distance is multiplied by 1 + PENALTY·(n − 1). 0 as in the paper. Not with --search
    /// full
    #[arg(long, default_value_t = Self::default().reuse_penalty)]
    pub reuse_penalty: f64,
    /// The order in which the coarsest level, or the only one, is visited; finer levels are refined in parallel by
    /// colour classes
    #[arg(long, value_enum, default_value_t = Self::default().order)]
    pub order: Order,
}

impl Default for KCoherenceOptions {
    fn default() -> Self {
        Self {
            k: None,
            search: CandidateSearch::default(),
            coherence: 1.5,
            distance_floor: 0.001,
            repair_rounds: 2,
            polish: Effort::Auto,
            start_passes: 2,
            reuse_penalty: 1.0,
            order: Order::default(),
        }
    }
}

impl OwnOptions for KCoherenceOptions {
    fn validate(&self) -> Result<()> {
        at_least_one("k", self.k.map_or(1, |k| k as u64))?;
        few_rounds("repair-rounds", self.repair_rounds, 0)?;
        self.polish.validate()?;
        few_rounds("start-passes", self.start_passes, 1)?;
        within_factors("coherence", self.coherence, 1.0)?;
        within_factors("distance-floor", self.distance_floor, 0.0)?;
        within_factors("reuse-penalty", self.reuse_penalty, 0.0)
    }

    fn changed(&self) -> Vec<(&'static str, bool)> {
        let default = Self::default();
        vec![
            ("k", self.k != default.k),
            ("search", self.search != default.search),
            ("coherence", self.coherence != default.coherence),
            (
                "distance-floor",
                self.distance_floor != default.distance_floor,
            ),
            ("repair-rounds", self.repair_rounds != default.repair_rounds),
            ("polish", self.polish != default.polish),
            ("start-passes", self.start_passes != default.start_passes),
            ("reuse-penalty", self.reuse_penalty != default.reuse_penalty),
            ("order", self.order != default.order),
        ]
    }
}
