//! The rule of k-coherence (Tong 2002 §5.2): of the texels that a site's neighbours propose by forward shift, and the
//! nearest of each in the neighbour table, the one whose neighbourhood is most similar.
//!
//! Where no candidate is whole, and with [`CandidateSearch::Full`] always, every whole texel is tried.

use crate::exemplar::level::ExemplarLevel;
use crate::grid::TexCoord;
use crate::sites::level::Sites;
use crate::synthesis::candidates::forward::CandidateList;
use crate::synthesis::keep::{Pick, Preference};
use crate::synthesis::metric::Metric;
use crate::synthesis::metric::site_values::{SiteNeighborhood, Unfinished};
use crate::synthesis::options::CandidateSearch;
use crate::synthesis::rule::Rule;
use crate::synthesis::state::Texels;

/// Sites that a thread takes at a time to search in full.
const FULL_BATCH: usize = 2;

/// The rule on one level.
pub struct KCoherence<'a, const N: usize, S, M> {
    /// The exemplar's level.
    pub exemplar: &'a ExemplarLevel<'a>,
    /// The sites.
    pub sites: &'a S,
    /// What the coarser level holds, where there is one.
    pub coarser: Option<&'a Texels>,
    /// How neighbourhoods are compared.
    pub metric: &'a M,
    /// Which texels are tried.
    pub search: CandidateSearch,
    /// What is preferred beside small distances.
    pub preference: Preference,
}

// Derived implementations would ask the same of S and M.
impl<const N: usize, S, M> Clone for KCoherence<'_, N, S, M> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<const N: usize, S, M> Copy for KCoherence<'_, N, S, M> {}

/// Working memory of one thread.
pub struct Scratch<P> {
    candidates: CandidateList,
    pattern: P,
}

impl<P: Default> Default for Scratch<P> {
    fn default() -> Self {
        Self {
            candidates: CandidateList::default(),
            pattern: P::default(),
        }
    }
}

impl<const N: usize, S: Sites<N>, M: Metric> Rule for KCoherence<'_, N, S, M> {
    type State = Texels;
    type Take = TexCoord;
    type Scratch = Scratch<M::Pattern>;

    fn held(&self, state: &Texels, site: usize) -> TexCoord {
        state.coords[site]
    }

    fn choose(&self, state: &Texels, site: usize, scratch: &mut Scratch<M::Pattern>) -> TexCoord {
        let Scratch {
            candidates,
            pattern,
        } = scratch;
        // Leave a site as it is until a neighbour is done.
        let done = state.done.as_deref();
        let counts = |other: usize| done.is_none_or(|done| done[other]);
        if done.is_some()
            && !self
                .sites
                .neighbors(site)
                .any(|near| counts(near.site as usize))
        {
            return state.coords[site];
        }
        // Collect candidates.
        let own = done.is_none().then(|| state.coords[site]);
        let neighbors = self.sites.neighbors(site);
        candidates.collect_coherent(self.exemplar, own, neighbors, &state.coords, counts);
        // Choose the nearest, among all texels where the candidates give none.
        self.metric.read(&self.neighborhood(state, site), pattern);
        let pick = match self.search {
            CandidateSearch::KCoherence => self.best_nearby(state, site, pattern, candidates),
            CandidateSearch::Full => None,
        };
        let all = |pattern| {
            self.metric
                .best_of_all(pattern, candidates.candidates(), self.preference)
        };
        let pick = pick.or_else(|| all(pattern));
        let texel = pick.map_or(self.exemplar.whole_texels[0], |pick| pick.texel);
        candidates.place(self.exemplar.grid, texel)
    }

    fn set(&self, state: &mut Texels, site: usize, at: TexCoord) {
        state.set(self.exemplar, site, at);
    }

    fn batch(&self) -> usize {
        match self.search {
            CandidateSearch::KCoherence => 64,
            CandidateSearch::Full => FULL_BATCH,
        }
    }
}

impl<'a, const N: usize, S: Sites<N>, M: Metric> KCoherence<'a, N, S, M> {
    /// What is round a site.
    pub fn neighborhood<'s>(&'s self, state: &'s Texels, site: usize) -> SiteNeighborhood<'s, S> {
        SiteNeighborhood {
            site,
            sites: self.sites,
            rows: &state.rows,
            done: state.done.as_deref(),
            unfinished: Unfinished::LeftOut,
            coarser: self.coarser.map(|coarser| &coarser.rows[..]),
        }
    }

    /// The best of the coherent candidates and the nearest of each.
    fn best_nearby(
        &self,
        state: &Texels,
        site: usize,
        pattern: &M::Pattern,
        candidates: &mut CandidateList,
    ) -> Option<Pick> {
        let Preference { coherence, floor } = self.preference;
        let best = |candidates: &[_], first| self.metric.best(pattern, candidates, first, floor);
        let own = self.exemplar.grid.texel_nearest(state.coords[site]);
        let weigh = |candidates: &mut CandidateList, begin| {
            if let Some(uses) = &state.uses {
                candidates.weigh(begin, |texel| uses.factor(texel, own));
            }
        };
        weigh(candidates, 0);
        let coherent = best(candidates.candidates(), None);
        // Not even a distance of 0 would beat this one.
        if coherent.is_some_and(|pick| pick.score < coherence * floor) {
            return coherent;
        }
        let begin = candidates.add_nearest(self.exemplar, coherence);
        weigh(candidates, begin);
        best(&candidates.candidates()[begin..], coherent)
    }
}
