//! Which passes a level of k-coherence gets.

use crate::synthesis::options::{CandidateSearch, SynthesisOptions};

/// The passes of one level.
#[derive(Clone, Copy, Debug)]
pub struct Passes<'a> {
    /// What was asked.
    pub options: &'a SynthesisOptions,
    /// The level, 0 the finest.
    pub level: usize,
    /// Levels in all.
    pub levels: usize,
}

impl<'a> Passes<'a> {
    /// Those of one level of several.
    pub fn of(options: &'a SynthesisOptions, level: usize, levels: usize) -> Self {
        Self {
            options,
            level,
            levels,
        }
    }

    /// Whether the level has a coarser one above it.
    pub fn is_fine(self) -> bool {
        self.level + 1 < self.levels
    }

    /// Whether the level is refined after its first guess.
    pub fn refines(self) -> bool {
        self.is_fine() && self.options.passes > 1
    }

    /// Whether the level ends with a full search where it fits worst.
    pub fn repairs(self) -> bool {
        self.level == 0 && self.refines() && !self.searches() && self.k_coherence_repairs()
    }

    /// Whether every whole texel is tried at every site.
    pub fn searches(self) -> bool {
        self.options.k_coherence.search == CandidateSearch::Full
    }

    /// How many choices the level takes at `sites` sites, seam repair apart.
    pub fn visits(self, sites: usize) -> u64 {
        let times = match (self.is_fine(), self.levels) {
            (true, _) => self.options.passes - 1,
            (false, 1) => 1,
            (false, _) => self.options.k_coherence.start_passes,
        };
        sites as u64 * u64::from(times)
    }

    fn k_coherence_repairs(self) -> bool {
        self.options.k_coherence.repair_rounds > 0
    }
}
