//! The candidates of a site by k-coherence (Tong 2002 §5.2): the forward-shifted texels of its
//! neighbours, and the nearest texels of each, every texel once.

use crate::grid::{TexCoord, TexelGrid};
use crate::mesh::hierarchy::Neighbor;
use crate::synthesis::exemplar_level::ExemplarLevel;

/// A texel to try.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Candidate {
    /// Its flat index.
    pub texel: u32,
    /// What its distance counts: 1 where a neighbour's texel, shifted, leads to it.
    pub factor: f64,
}

/// The texel a done neighbour at offset (x, y) with coordinate `at` proposes: the one that holds
/// (s − x, t − y); wrapped if tileable, else `None` off the grid.
#[inline]
pub fn forward_shift(grid: TexelGrid, at: TexCoord, x: f32, y: f32) -> Option<u32> {
    let shifted = TexCoord {
        s: at.s - x,
        t: at.t - y,
    };
    grid.texel_holding(shifted).map(|texel| texel.0)
}

/// A list of candidates, refilled from site to site.
#[derive(Clone, Debug, Default)]
pub struct CandidateList {
    list: Vec<Candidate>,
    /// Coherent texels, whole or not: those whose neighbour lists are read.
    sources: Vec<u32>,
    /// Per texel the round in which it was last seen.
    seen: Vec<u32>,
    round: u32,
}

impl CandidateList {
    /// The candidates found last.
    pub fn candidates(&self) -> &[Candidate] {
        &self.list
    }

    /// Collects the coherent candidates: of the site's own coordinate, where it has one, and of
    /// those neighbours that `counts` admits. Only whole texels are listed.
    pub fn collect_coherent(
        &mut self,
        exemplar: &ExemplarLevel<'_>,
        own: Option<TexCoord>,
        neighbors: &[Neighbor],
        coords: &[TexCoord],
        counts: impl Fn(usize) -> bool,
    ) {
        self.begin(exemplar.grid.len());
        let own = own.and_then(|at| forward_shift(exemplar.grid, at, 0.0, 0.0));
        if let Some(texel) = own {
            self.add_source(exemplar, texel);
        }
        for neighbor in neighbors {
            let site = neighbor.site as usize;
            if !counts(site) {
                continue;
            }
            let shifted = forward_shift(exemplar.grid, coords[site], neighbor.x, neighbor.y);
            if let Some(texel) = shifted {
                self.add_source(exemplar, texel);
            }
        }
    }

    /// Adds the nearest texels of every coherent one, whose distances count `coherence` times.
    pub fn add_nearest(&mut self, exemplar: &ExemplarLevel<'_>, coherence: f64) {
        for index in 0..self.sources.len() {
            for &texel in &exemplar.nearest(self.sources[index])[1..] {
                if self.is_new(texel) && exemplar.whole[texel as usize] {
                    self.list.push(Candidate {
                        texel,
                        factor: coherence,
                    });
                }
            }
        }
    }

    /// Lets every candidate's distance count some factor more.
    pub fn weigh(&mut self, factor: impl Fn(u32) -> f64) {
        for candidate in &mut self.list {
            candidate.factor *= factor(candidate.texel);
        }
    }

    fn begin(&mut self, texels: usize) {
        self.list.clear();
        self.sources.clear();
        if self.seen.len() != texels || self.round == u32::MAX {
            self.seen.clear();
            self.seen.resize(texels, 0);
            self.round = 0;
        }
        self.round += 1;
    }

    #[inline]
    fn is_new(&mut self, texel: u32) -> bool {
        std::mem::replace(&mut self.seen[texel as usize], self.round) != self.round
    }

    fn add_source(&mut self, exemplar: &ExemplarLevel<'_>, texel: u32) {
        if !self.is_new(texel) {
            return;
        }
        self.sources.push(texel);
        if exemplar.whole[texel as usize] {
            self.list.push(Candidate { texel, factor: 1.0 });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::index::TexelIndex;
    use crate::synthesis::fixtures;
    use std::collections::BTreeSet;

    const GRID: TexelGrid = TexelGrid {
        width: 8,
        height: 6,
        tileable: false,
    };

    #[test]
    fn a_neighbour_right_and_up_proposes_left_and_down() {
        // The neighbour at (x, y) = (1, 2) holds row 1, col 5: row + y, col − x.
        let at = GRID.centre(GRID.texel(1, 5));
        assert_eq!(forward_shift(GRID, at, 1.0, 2.0), Some(GRID.texel(3, 4).0));
        assert_eq!(forward_shift(GRID, at, 6.0, 0.0), None);
        let tile = TexelGrid {
            tileable: true,
            ..GRID
        };
        assert_eq!(forward_shift(tile, at, 6.0, 0.0), Some(GRID.texel(1, 7).0));
    }

    #[test]
    fn candidates_are_the_lists_of_the_coherent_without_repeats() {
        let (space, table) = fixtures::random_exemplar(3, 12, 2, true);
        let exemplar = ExemplarLevel::new(&space, &table, 0, 4, true);
        let grid = exemplar.grid;
        let coords: Vec<TexCoord> = (0..9).map(|i| grid.centre(TexelIndex(7 * i))).collect();
        let neighbors: Vec<Neighbor> = (1..9)
            .map(|site| Neighbor {
                site,
                x: (site % 3) as f32 - 1.0,
                y: 1.0 - (site / 3) as f32,
            })
            .collect();
        let mut list = CandidateList::default();
        for _ in 0..2 {
            list.collect_coherent(&exemplar, Some(coords[0]), &neighbors, &coords, |s| s != 4);
            let coherent: BTreeSet<u32> = list.candidates().iter().map(|c| c.texel).collect();
            assert_eq!(coherent.len(), list.candidates().len());
            list.add_nearest(&exemplar, 1.2);
            let mut expected = BTreeSet::new();
            let proposals = neighbors.iter().filter(|n| n.site != 4);
            let proposals =
                proposals.map(|n| forward_shift(grid, coords[n.site as usize], n.x, n.y).unwrap());
            for texel in proposals.chain([0]) {
                expected.extend(exemplar.nearest(texel));
            }
            let found: BTreeSet<u32> = list.candidates().iter().map(|c| c.texel).collect();
            assert_eq!(found, expected);
            assert_eq!(found.len(), list.candidates().len());
        }
    }
}
