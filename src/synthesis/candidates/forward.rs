//! The candidates of a site by k-coherence (Tong 2002 §5.2): the forward-shifted texels of its
//! neighbours, and the nearest texels of each, every texel once.

use crate::exemplar::level::ExemplarLevel;
use crate::grid::{TexCoord, TexelGrid};
use crate::index::TexelIndex;
use crate::sites::level::Neighbor;
use crate::synthesis::candidates::proposals::Proposals;

/// A texel to try.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Candidate {
    /// Its flat index.
    pub texel: u32,
    /// What its distance counts: 1 where a neighbour's texel, shifted, leads to it.
    pub factor: f64,
}

/// What a done neighbour at offset (x, y) with coordinate `at` proposes: (s − x, t − y), which may
/// lie off the grid.
#[inline]
pub fn shifted(at: TexCoord, x: f32, y: f32) -> TexCoord {
    TexCoord {
        s: at.s - x,
        t: at.t - y,
    }
}

/// Least distance of a coordinate from its texel's border, in texels, against rounding.
const MARGIN: f32 = 1.0 / 64.0;

/// A list of candidates, refilled from site to site.
#[derive(Clone, Debug, Default)]
pub struct CandidateList {
    list: Vec<Candidate>,
    /// The source that each candidate is or is near to.
    origins: Vec<u32>,
    /// Coherent texels, whole or not: those whose neighbour lists are read.
    sources: Vec<u32>,
    /// In which round each texel was last seen.
    seen: Vec<u32>,
    round: u32,
    proposals: Proposals,
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
        neighbors: impl Iterator<Item = Neighbor>,
        coords: &[TexCoord],
        counts: impl Fn(usize) -> bool,
    ) {
        self.begin(exemplar.grid.len());
        self.proposals.clear();
        if let Some(at) = own {
            self.proposals.push(at);
        }
        for neighbor in neighbors {
            let site = neighbor.site as usize;
            if counts(site) {
                let at = shifted(coords[site], neighbor.x, neighbor.y);
                self.proposals.push(at);
            }
        }
        self.list_proposed(exemplar);
    }

    /// Collects the whole texels that some coordinates lie in; a coordinate may lie off the grid.
    pub fn collect_proposed(
        &mut self,
        exemplar: &ExemplarLevel<'_>,
        proposals: impl Iterator<Item = TexCoord>,
    ) {
        self.begin(exemplar.grid.len());
        self.proposals.clear();
        proposals.for_each(|at| self.proposals.push(at));
        self.list_proposed(exemplar);
    }

    fn list_proposed(&mut self, exemplar: &ExemplarLevel<'_>) {
        self.proposals.place(exemplar.grid);
        for proposal in 0..self.proposals.len() {
            if let Some(texel) = self.proposals.texel(proposal)
                && self.is_new(texel)
            {
                self.sources.push(texel);
                self.add_whole(exemplar, texel, self.sources.len() - 1, 1.0);
            }
        }
    }

    /// Drops the candidates that are not to be tried.
    pub fn retain(&mut self, keep: impl Fn(u32) -> bool) {
        let mut kept = 0;
        for at in 0..self.list.len() {
            if keep(self.list[at].texel) {
                self.list.swap(kept, at);
                self.origins.swap(kept, at);
                kept += 1;
            }
        }
        self.list.truncate(kept);
        self.origins.truncate(kept);
    }

    /// Lists texels instead of what neighbours propose.
    pub fn replace(&mut self, texels: impl Iterator<Item = u32>) {
        self.list.clear();
        self.origins.clear();
        self.list
            .extend(texels.map(|texel| Candidate { texel, factor: 1.0 }));
    }

    /// Adds the nearest texels of every coherent one, whose distances count `coherence` times, and
    /// returns where they begin.
    pub fn add_nearest(&mut self, exemplar: &ExemplarLevel<'_>, coherence: f64) -> usize {
        let begin = self.list.len();
        for source in 0..self.sources.len() {
            for &texel in &exemplar.nearest(self.sources[source])[1..] {
                if self.is_new(texel) {
                    self.add_whole(exemplar, texel, source, coherence);
                }
            }
        }
        begin
    }

    /// Lists a texel that comes of a source, if it is whole.
    #[inline(always)]
    fn add_whole(&mut self, exemplar: &ExemplarLevel<'_>, texel: u32, source: usize, factor: f64) {
        if exemplar.whole[texel as usize] {
            self.origins.push(source as u32);
            self.list.push(Candidate { texel, factor });
        }
    }

    /// The coordinate a listed texel brings along: where in the texel the proposals of its source lie
    /// on average, so that rounding to texel centres does not accumulate in a copied patch. The centre of a
    /// texel that is not listed.
    pub fn place(&self, grid: TexelGrid, texel: u32) -> TexCoord {
        let listed = self.list.iter().position(|listed| listed.texel == texel);
        let Some(&origin) = listed.and_then(|listed| self.origins.get(listed)) else {
            return grid.centre(TexelIndex(texel));
        };
        let source = self.sources[origin as usize];
        let inside = self.proposals.mean_inside(source);
        let [right, down] = inside.map(|place| place.clamp(MARGIN, 1.0 - MARGIN));
        let (row, col) = grid.row_col(TexelIndex(texel));
        TexCoord {
            s: col as f32 + right,
            t: grid.height as f32 - (row as f32 + down),
        }
    }

    /// Lets the distances of the candidates from `begin` on count some factor more.
    pub fn weigh(&mut self, begin: usize, factor: impl Fn(u32) -> f64) {
        for candidate in &mut self.list[begin..] {
            candidate.factor *= factor(candidate.texel);
        }
    }

    fn begin(&mut self, texels: usize) {
        self.list.clear();
        self.origins.clear();
        self.sources.clear();
        if self.seen.len() != texels || self.round == u32::MAX {
            self.seen.clear();
            self.seen.resize(texels, 0);
            self.round = 0;
        }
        self.round += 1;
    }

    /// Whether a texel is seen for the first time at this site.
    #[inline(always)]
    fn is_new(&mut self, texel: u32) -> bool {
        let seen = &mut self.seen[texel as usize];
        let new = *seen != self.round;
        *seen = self.round;
        new
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthesis::tests::fixtures;
    use std::collections::BTreeSet;

    const GRID: TexelGrid = TexelGrid {
        width: 8,
        height: 6,
        tileable: false,
    };

    fn forward_shift(grid: TexelGrid, at: TexCoord, x: f32, y: f32) -> Option<u32> {
        grid.texel_holding(shifted(at, x, y)).map(|texel| texel.0)
    }

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
    fn a_texel_lies_where_its_proposals_do() {
        let (space, table) = fixtures::random_exemplar(3, 12, 2, true);
        let exemplar = ExemplarLevel::new(&space, &table, 0, 4, true);
        let grid = exemplar.grid;
        let near = |x: f32, y: f32| Neighbor { site: 0, x, y };
        // Of (5.5, 6.5): (4.7, 6.4) and (4.3, 6.1) lie in one texel, (6.0, 6.5) in another.
        let coords = [TexCoord { s: 5.5, t: 6.5 }];
        let neighbors = [near(0.8, 0.1), near(1.2, 0.4), near(-0.5, 0.0)];
        let mut list = CandidateList::default();
        list.collect_coherent(&exemplar, None, neighbors.into_iter(), &coords, |_| true);
        list.add_nearest(&exemplar, 1.2);
        let twice = grid.texel_holding(TexCoord { s: 4.5, t: 6.25 }).unwrap();
        let place = list.place(grid, twice.0);
        assert!((place.s - 4.5).abs() < 1e-5 && (place.t - 6.25).abs() < 1e-5);
        // One near it takes its place along.
        let near = exemplar.nearest(twice.0)[1..].iter().find(|&&texel| {
            list.origins[list.list.iter().position(|c| c.texel == texel).unwrap()] == 0
        });
        let near = *near.unwrap();
        let (place, corner) = (list.place(grid, near), grid.centre(TexelIndex(near)));
        assert!((place.s - corner.s).abs() < 1e-5 && (place.t - corner.t + 0.25).abs() < 1e-5);
        for candidate in list.candidates() {
            let place = list.place(grid, candidate.texel);
            assert_eq!(grid.texel_holding(place), Some(TexelIndex(candidate.texel)));
        }
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
            let near = neighbors.iter().copied();
            list.collect_coherent(&exemplar, Some(coords[0]), near, &coords, |s| s != 4);
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
