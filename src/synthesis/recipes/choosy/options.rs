//! What can be asked of choosy sampling.

use serde::Serialize;

use crate::error::{Error, Result};

/// Visits of a level, at most.
const MOST_ITERATIONS: u32 = 1000;

/// Options of Castellanos and Williams' method.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct ChoosyOptions {
    /// How often the faces of every level are visited, from the coarsest level on; the last number stands for all
    /// finer levels too (§3.13).
    pub iterations: Vec<u32>,
    /// Principal components of a neighbourhood that are compared; no more than it has numbers (§6.2).
    pub dimensions: usize,
    /// The seed of all random numbers.
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

impl ChoosyOptions {
    /// Refuses numbers outside their ranges.
    pub fn check(&self) -> Result<()> {
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

    /// How often the faces of a level are visited.
    pub fn iterations_of(&self, level: usize) -> u32 {
        let last = self.iterations.len().saturating_sub(1);
        self.iterations.get(level.min(last)).copied().unwrap_or(1)
    }
}
