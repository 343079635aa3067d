//! How often a level uses each texel: a choice that keeps state, and so is sequential (after the
//! penalty by use of Castellanos and Williams).
//!
//! In: what the sites of a level hold. Out: a factor for every texel's distance, above 1 for those that
//! are used more often than whole texels are on average. Minimising neighbourhood distances alone, a random start
//! falls into the parts of the sample that resemble themselves most: a plain tile, a smooth patch.

use crate::exemplar::level::ExemplarLevel;
use crate::grid::TexCoord;
use crate::index::TexelIndex;

/// The uses of every texel.
#[derive(Clone, Debug, PartialEq)]
pub struct Uses {
    counts: Vec<u32>,
    /// Sites per texel if all whole ones were used alike.
    mean: f64,
    penalty: f64,
}

impl Uses {
    /// Counts what the sites hold.
    pub fn of(exemplar: &ExemplarLevel<'_>, coords: &[TexCoord], penalty: f64) -> Self {
        let mut counts = vec![0; exemplar.grid.len()];
        for &at in coords {
            counts[exemplar.grid.texel_nearest(at).index()] += 1;
        }
        Self {
            counts,
            mean: coords.len() as f64 / exemplar.whole_texels.len() as f64,
            penalty,
        }
    }

    /// A site gives up its texel.
    pub fn leave(&mut self, texel: TexelIndex) {
        self.counts[texel.index()] -= 1;
    }

    /// A site takes a texel.
    pub fn take(&mut self, texel: TexelIndex) {
        self.counts[texel.index()] += 1;
    }

    /// The factor on the distance of a texel for a site that gives up `own`: 1 up to the mean use, then rising
    /// with the excess.
    #[inline]
    pub fn factor(&self, texel: u32, own: TexelIndex) -> f64 {
        let uses = self.counts[texel as usize] - u32::from(texel == own.0);
        let excess = f64::from(uses) / self.mean - 1.0;
        1.0 + self.penalty * excess.max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthesis::tests::fixtures;

    #[test]
    fn texels_used_above_the_mean_count_more() {
        let (space, table) = fixtures::random_exemplar(3, 8, 1, true);
        let exemplar = ExemplarLevel::new(&space, &table, 0, 2, false);
        // Two sites a texel on average; texel 5 has seven.
        let texels = (0..123).map(|i| i % 64).chain([5; 5]);
        let coords: Vec<TexCoord> = texels
            .map(|i| exemplar.grid.centre(TexelIndex(i)))
            .collect();
        let mut uses = Uses::of(&exemplar, &coords, 0.5);
        let none = TexelIndex(40);
        assert_eq!(uses.factor(5, none), 1.0 + 0.5 * 2.5);
        assert_eq!(uses.factor(5, TexelIndex(5)), 2.0);
        assert_eq!([uses.factor(6, none), uses.factor(63, none)], [1.0, 1.0]);
        uses.leave(TexelIndex(5));
        uses.take(TexelIndex(6));
        assert_eq!([uses.factor(5, none), uses.factor(6, none)], [2.0, 1.25]);
    }
}
