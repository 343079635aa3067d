//! How often a level uses each texel, or each texton: a choice that keeps state (after the usage penalty of Castellanos
//! and Williams, and the histogram matching of Kopf et al. 2007, *Solid Texture Synthesis from 2D Exemplars*).
//!
//! In: what the sites of a level hold. Out: a factor for every texel's distance, above 1 for those that
//! are used more often than in the sample. Minimising neighbourhood distances alone, a random start
//! falls into the parts of the sample that resemble themselves most: a plain tile, a smooth patch. The coarsest level,
//! which is visited site after site, counts texels. Finer levels count textons: the places of a copied patch are then
//! free. While a colour class is visited, the counts stand still.

use crate::exemplar::level::ExemplarLevel;
use crate::grid::TexCoord;
use crate::index::TexelIndex;

/// The uses of every kind of texel.
#[derive(Clone, Debug, PartialEq)]
pub struct Uses {
    /// The kind of each texel: itself, or its texton.
    kinds: Vec<u32>,
    /// The sites that hold each kind.
    counts: Vec<u32>,
    /// One over the sites that would hold each kind if all texels were used alike.
    shares: Vec<f64>,
    penalty: f64,
}

impl Uses {
    /// Counts the texels that the sites hold, against whole ones used alike.
    pub fn of_texels(exemplar: &ExemplarLevel<'_>, coords: &[TexCoord], penalty: f64) -> Self {
        let kinds = (0..exemplar.grid.len() as u32).collect();
        Self::new(exemplar, (kinds, &exemplar.whole_texels), coords, penalty)
    }

    /// Counts the textons that the sites hold, against all of the sample; of an exemplar with textons.
    pub fn of_textons(exemplar: &ExemplarLevel<'_>, coords: &[TexCoord], penalty: f64) -> Self {
        let all: Vec<u32> = (0..exemplar.grid.len() as u32).collect();
        Self::new(exemplar, (exemplar.rows.clone(), &all), coords, penalty)
    }

    /// Counts kinds of texels; `alike` are those of which all should be used alike.
    fn new(
        exemplar: &ExemplarLevel<'_>,
        (kinds, alike): (Vec<u32>, &[u32]),
        coords: &[TexCoord],
        penalty: f64,
    ) -> Self {
        let size = kinds.iter().max().map_or(0, |&kind| kind as usize + 1);
        let (mut counts, mut wanted) = (vec![0; size], vec![0.0; size]);
        for &at in coords {
            counts[kinds[exemplar.grid.texel_nearest(at).index()] as usize] += 1;
        }
        for &texel in alike {
            wanted[kinds[texel as usize] as usize] += coords.len() as f64 / alike.len() as f64;
        }
        // A kind that no such texel has is never tried.
        let share = |&wanted: &f64| if wanted > 0.0 { 1.0 / wanted } else { 0.0 };
        Self {
            shares: wanted.iter().map(share).collect(),
            kinds,
            counts,
            penalty,
        }
    }

    /// A site gives up its texel.
    pub fn leave(&mut self, texel: TexelIndex) {
        self.counts[self.kinds[texel.index()] as usize] -= 1;
    }

    /// A site takes a texel.
    pub fn take(&mut self, texel: TexelIndex) {
        self.counts[self.kinds[texel.index()] as usize] += 1;
    }

    /// The factor on the distance of a texel for a site that gives up `own`: 1 up to the wanted use, then rising
    /// with the excess.
    #[inline]
    pub fn factor(&self, texel: u32, own: TexelIndex) -> f64 {
        let kind = self.kinds[texel as usize];
        let uses = self.counts[kind as usize] - u32::from(kind == self.kinds[own.index()]);
        let excess = f64::from(uses) * self.shares[kind as usize] - 1.0;
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
        let mut uses = Uses::of_texels(&exemplar, &coords, 0.5);
        let none = TexelIndex(40);
        assert_eq!(uses.factor(5, none), 1.0 + 0.5 * 2.5);
        assert_eq!(uses.factor(5, TexelIndex(5)), 2.0);
        assert_eq!([uses.factor(6, none), uses.factor(63, none)], [1.0, 1.0]);
        uses.leave(TexelIndex(5));
        uses.take(TexelIndex(6));
        assert_eq!([uses.factor(5, none), uses.factor(6, none)], [2.0, 1.25]);
    }

    #[test]
    fn textons_count_against_their_share_of_the_sample() {
        let (space, table) = fixtures::random_exemplar(3, 8, 1, false);
        let exemplar = ExemplarLevel::new(&space, &table, 0, 2, false);
        let centre = |texel: u32| exemplar.grid.centre(TexelIndex(texel));
        let copy: Vec<TexCoord> = (0..64).map(centre).collect();
        let uses = Uses::of_textons(&exemplar, &copy, 1.0);
        // A copy uses every texton as often as the sample does, whatever a site gives up.
        assert!((0..64).all(|texel| uses.factor(texel, TexelIndex(9)) <= 1.0 + 1e-12));
        // One texton everywhere: 64 sites where the sample has so many.
        let uses = Uses::of_textons(&exemplar, &[centre(9); 64], 1.0);
        let alike = exemplar.rows.iter().filter(|&&row| row == exemplar.rows[9]);
        let expected = 63.0 / alike.count() as f64;
        assert!((uses.factor(9, TexelIndex(9)) - expected).abs() < 1e-9);
    }
}
