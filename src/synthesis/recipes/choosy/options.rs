//! What can be asked of choosy sampling.

use serde::Serialize;

use crate::error::{Error, Result};
use crate::synthesis::own_options::OwnOptions;

/// Visits of a level, at most.
const MOST_ITERATIONS: u32 = 1000;

/// Options of Castellanos and Williams' method.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, clap::Args)]
#[serde(rename_all = "kebab-case")]
#[command(next_help_heading = "Method choosy")]
pub struct ChoosyOptions {
    /// How often the faces of each level are visited, from the coarsest level on; the last number is repeated for all
    /// finer levels (§3.13)
    #[arg(long, value_name = "N,N…", value_delimiter = ',', default_values_t = Self::default().iterations)]
    pub iterations: Vec<u32>,
    /// Principal components of a neighbourhood that are compared, at most as many as it has numbers (§6.2)
    #[arg(long, value_name = "N", default_value_t = Self::default().dimensions)]
    pub dimensions: usize,
    /// The seed of all random numbers. Set by synthesis.
    #[arg(skip)]
    #[serde(skip)]
    pub seed: u64,
}

impl Default for ChoosyOptions {
    fn default() -> Self {
        Self {
            iterations: vec![1],
            dimensions: 20,
            seed: 0,
        }
    }
}

impl OwnOptions for ChoosyOptions {
    fn validate(&self) -> Result<()> {
        let allowed = 1..=MOST_ITERATIONS;
        if self.iterations.is_empty() {
            return Err(Error::option("iterations", "nothing", "one number or more"));
        }
        if let Some(other) = self
            .iterations
            .iter()
            .find(|&count| !allowed.contains(count))
        {
            let expected = format!("numbers from 1 to {MOST_ITERATIONS}");
            return Err(Error::option("iterations", other.to_string(), expected));
        }
        match self.dimensions {
            0 => Err(Error::option("dimensions", "0", "1 or more")),
            _ => Ok(()),
        }
    }

    fn changed(&self) -> Vec<(&'static str, bool)> {
        let default = Self::default();
        vec![
            ("iterations", self.iterations != default.iterations),
            ("dimensions", self.dimensions != default.dimensions),
        ]
    }
}

impl ChoosyOptions {
    /// How often the faces of a level are visited.
    pub fn iterations_of(&self, level: usize) -> u32 {
        let last = self.iterations.len().saturating_sub(1);
        self.iterations.get(level.min(last)).copied().unwrap_or(1)
    }
}
