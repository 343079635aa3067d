//! On how many levels a surface is synthesized where the user does not say.
//!
//! In: a space, its neighbour table and the number of sites. Out: levels, and the reason in words.
//!
//! The windows of a level reach twice as far as those of the level below. So the coarsest level must be coarse enough
//! that its windows hold a feature of the sample. It must also have sites enough: it grows from random texels, and what
//! it uses too often or too seldom, all finer levels inherit. On a small mesh, or one with limbs, windows that are a
//! large part of the surface lie beyond its borders besides.

use crate::exemplar::feature_size::feature_size;
use crate::exemplar::neighbor_table::NeighborTable;
use crate::exemplar::space::Space;
use crate::neighborhood::window_width;
use crate::synthesis::check::fitting_levels;

/// Sites that the coarsest level should have.
const ENOUGH_SITES: usize = 150;
/// Levels below which a map is not refined at all.
const LEAST_LEVELS: usize = 2;

/// Levels, and why.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LevelChoice {
    /// The levels that are synthesized.
    pub levels: usize,
    /// What limits them.
    pub reason: String,
}

/// What the levels of a target are chosen by.
struct Levels<'a> {
    table: &'a NeighborTable,
    /// Sites of the finest level.
    sites: usize,
    /// Levels of the sample that its windows fit.
    fitting: usize,
    /// The size of the sample's features, in texels.
    feature: u32,
}

impl LevelChoice {
    /// The levels of `sites` sites: as many as the table has and its windows fit; fewer where the coarsest would have
    /// too few sites, but not so few that the sample's features are wider than its windows.
    pub fn new(space: &Space, table: &NeighborTable, sites: usize) -> Self {
        let of = Levels {
            table,
            sites,
            fitting: fitting_levels(space, table).max(1),
            feature: space.levels.first().map_or(1, feature_size),
        };
        // Take as many levels as have enough sites, but enough to hold the features.
        let (possible, populous) = (of.possible(), of.populous());
        let least = LEAST_LEVELS.max(of.holding_features()).min(possible);
        let levels = populous.max(least);
        let coarsest = of.coarsest(levels);
        // Say why.
        let reason = match levels {
            _ if levels == table.levels.len() => {
                format!("all of the table; {coarsest} sites on the coarsest level")
            }
            _ if levels == of.fitting => {
                format!(
                    "coarser ones would be narrower than the window; {coarsest} sites on the coarsest level"
                )
            }
            _ if levels > populous => format!(
                "{coarsest} sites on the coarsest level, whose windows span {} texels of the sample; its features are {} \
                 texels wide",
                of.reach(levels),
                of.feature
            ),
            _ => format!(
                "{coarsest} sites on the coarsest level, whose windows span {} texels of the sample; its features are {} \
                 texels wide; one more level would leave {} sites",
                of.reach(levels),
                of.feature,
                of.coarsest(levels + 1)
            ),
        };
        Self { levels, reason }
    }
}

impl Levels<'_> {
    /// Sites on the coarsest of this many levels: retiling leaves about a quarter of the vertices.
    fn coarsest(&self, levels: usize) -> usize {
        self.sites >> (2 * (levels - 1))
    }

    /// The width of the window on the coarsest of this many levels, in texels of the finest.
    fn reach(&self, levels: usize) -> u64 {
        let offsets = &self.table.levels[levels - 1].neighborhood.offsets;
        u64::from(window_width(offsets)) << (levels - 1)
    }

    /// The most levels whose coarsest has twice as many sites as its window has samples.
    fn possible(&self) -> usize {
        let samples = |levels: usize| self.table.levels[levels - 1].neighborhood.offsets.len();
        let fits = |&levels: &usize| self.coarsest(levels) >= 2 * samples(levels);
        (1..=self.fitting).rev().find(fits).unwrap_or(1)
    }

    /// The most levels whose coarsest has sites enough.
    fn populous(&self) -> usize {
        let has = |&levels: &usize| self.coarsest(levels) >= ENOUGH_SITES;
        (1..=self.fitting).rev().find(has).unwrap_or(1)
    }

    /// The fewest levels whose coarsest window is as wide as a feature.
    fn holding_features(&self) -> usize {
        let holds = |&levels: &usize| self.reach(levels) >= u64::from(self.feature);
        (1..=self.fitting).find(holds).unwrap_or(self.fitting)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exemplar::space::{Features, SpaceLevel};
    use crate::grid::TexelGrid;
    use crate::synthesis::tests::fixtures;

    /// Windows 5 wide on 64, 32, 16 and 8 texels; every texel has the label of its column.
    fn exemplar(label: fn(u32) -> u16) -> (Space, NeighborTable) {
        let (mut space, mut table) = fixtures::random_exemplar(3, 8, 1, true);
        table.levels = vec![table.levels[0].clone(); 4];
        let level = |at: u32| SpaceLevel {
            grid: TexelGrid {
                width: 64 >> at,
                height: 64 >> at,
                tileable: true,
            },
            features: Features::Textons {
                labels: (0..(64 * 64) >> (2 * at))
                    .map(|texel| label(texel % 64))
                    .collect(),
                gram: fixtures::random_gram(1, 2, 8),
            },
        };
        space.levels = (0..4).map(level).collect();
        (space, table)
    }

    #[test]
    fn levels_follow_the_sites() {
        let (space, table) = exemplar(|_| 0);
        let of = |sites| LevelChoice::new(&space, &table, sites);
        let levels = [9_600, 9_500, 2_300, 600, 60].map(|sites| of(sites).levels);
        assert_eq!(levels, [4, 3, 2, 2, 1]);
        assert!(of(9_600).reason.contains("all of the table; 150 sites"));
        let reason = of(2_300).reason;
        assert!(reason.contains("575 sites") && reason.contains("would leave 143"));
        assert!(reason.contains("windows span 10 texels"), "{reason}");
    }

    #[test]
    fn large_features_take_levels_as_far_as_the_sites_go() {
        // Stripes resemble themselves along their length at any lag: the feature is as long as the side.
        let (space, table) = exemplar(|col| u16::from(col >= 32));
        let found = LevelChoice::new(&space, &table, 2_300);
        assert_eq!(found.levels, 3, "{}", found.reason);
        assert!(found.reason.contains("features are 64"));
        assert_eq!(LevelChoice::new(&space, &table, 400).levels, 2);
    }
}
