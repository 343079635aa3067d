//! What happens to a level: a random start, growth from one site, a first guess from the coarser
//! level, and refinement of what is there (Tong 2002 §5.1).

use std::sync::{Mutex, PoisonError};

use rand::Rng;
use rayon::prelude::*;

use crate::error::Result;
use crate::grid::{TexCoord, TexelGrid};
use crate::index::TexelIndex;
use crate::mesh::hierarchy::{NeighborLists, Parent, SiteLevel};
use crate::progress::Progress;
use crate::random;
use crate::synthesis::candidates::CandidateList;
use crate::synthesis::changes::Changes;
use crate::synthesis::choice::{Pick, Preference};
use crate::synthesis::exemplar_level::ExemplarLevel;
use crate::synthesis::metric::Metric;
use crate::synthesis::options::{Search, SynthesisOptions};
use crate::synthesis::order::growing_order;
use crate::synthesis::site_samples::{SampledSites, SiteNeighborhood};
use crate::synthesis::usage::Usage;

/// Sites a thread takes at a time.
const BATCH: usize = 64;
/// Sites a thread takes at a time to search in full.
const FULL_BATCH: usize = 2;
/// Sites that are enough to know the distance by chance.
const PROBED_SITES: usize = 256;

/// What the sites of a level hold.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LevelState {
    /// Texture coordinates, in texels of the level.
    pub coords: Vec<TexCoord>,
    /// The feature row of the texel that holds each.
    pub rows: Vec<u32>,
}

/// One level while it is synthesized.
pub struct LevelPass<'a, M> {
    /// Its index, 0 the finest.
    pub level: u32,
    /// The exemplar's level.
    pub exemplar: &'a ExemplarLevel<'a>,
    /// The sites.
    pub sites: &'a SiteLevel,
    /// What the coarser level holds, where there is one.
    pub coarser: Option<&'a LevelState>,
    /// How neighbourhoods are compared.
    pub metric: &'a M,
    /// What was asked.
    pub options: &'a SynthesisOptions,
    /// What is added to all distances of a choice.
    pub noise: f64,
}

/// What a choice sees of the other sites.
#[derive(Clone, Copy)]
enum Seen<'a> {
    /// What all of them hold.
    All,
    /// Only those that are done.
    Done(&'a [bool]),
    /// All, and how often each texel is used.
    Used(&'a Usage),
}

impl<'a> Seen<'a> {
    fn done(self) -> Option<&'a [bool]> {
        match self {
            Self::Done(done) => Some(done),
            Self::All | Self::Used(_) => None,
        }
    }
}

/// Working memory of one thread.
struct Scratch<P> {
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

impl LevelState {
    /// Every site holds the centre of a texel.
    pub fn of_texels(exemplar: &ExemplarLevel<'_>, texels: impl Iterator<Item = u32>) -> Self {
        let mut state = Self::default();
        for texel in texels {
            state.coords.push(exemplar.grid.centre(TexelIndex(texel)));
            state.rows.push(exemplar.rows[texel as usize]);
        }
        state
    }

    /// Every site holds a coordinate, wrapped or clamped to the grid.
    pub fn of_coords(exemplar: &ExemplarLevel<'_>, coords: Vec<TexCoord>) -> Self {
        let row = |&at: &TexCoord| exemplar.rows[exemplar.grid.texel_nearest(at).index()];
        Self {
            rows: coords.iter().map(row).collect(),
            coords,
        }
    }

    fn set(&mut self, exemplar: &ExemplarLevel<'_>, site: usize, at: TexCoord) {
        self.coords[site] = at;
        self.rows[site] = exemplar.rows[exemplar.grid.texel_nearest(at).index()];
    }
}

/// The texture coordinate a site takes from its parent (DESIGN's first pass): with u the coarse site
/// at offset (x, y) from the parent point, s = 2(s_u − x) and H − t = 2(H′ − (t_u − y)), wrapped or
/// clamped to the finer grid.
pub fn first_guess(fine: TexelGrid, coarser: &[TexCoord], parent: &Parent) -> TexCoord {
    let at = coarser[parent.site as usize];
    let coarse_height = fine.coarser().height as f32;
    let s = 2.0 * (at.s - parent.x);
    let down = 2.0 * (coarse_height - (at.t - parent.y));
    let (width, height) = (fine.width as f32, fine.height as f32);
    if fine.tileable {
        let wrapped = |value: f32, side: f32| {
            let rest = value.rem_euclid(side);
            // The remainder of a tiny negative number rounds up to the side itself.
            if rest < side { rest } else { 0.0 }
        };
        return TexCoord {
            s: wrapped(s, width),
            t: height - wrapped(down, height),
        };
    }
    TexCoord {
        s: s.clamp(0.0, width.next_down()),
        t: height - down.clamp(0.0, height.next_down()),
    }
}

impl<M: Metric> LevelPass<'_, M> {
    /// The mean distance of random texels in a map of random texels, at a few sites.
    pub fn distance_by_chance(&self) -> f64 {
        let state = self.random_start();
        let mut stream = random::stream(self.options.seed, "distance by chance", self.level, 0);
        let (whole, sites) = (&self.exemplar.whole_texels, self.sites.site_count);
        let mut pattern = M::Pattern::default();
        let step = sites.div_ceil(PROBED_SITES).max(1);
        let distances = (0..sites).step_by(step).map(|site| {
            self.metric
                .read(&self.neighborhood(site, &state, None), &mut pattern);
            let texel = whole[stream.gen_range(0..whole.len())];
            self.metric.distance(&pattern, texel, f64::INFINITY)
        });
        let distances: Vec<f64> = distances.collect();
        distances.iter().sum::<f64>() / distances.len().max(1) as f64
    }

    /// A random whole texel at every site.
    pub fn random_start(&self) -> LevelState {
        let mut stream = random::stream(self.options.seed, "random start", self.level, 0);
        let whole = &self.exemplar.whole_texels;
        let texels = (0..self.sites.site_count).map(|_| whole[stream.gen_range(0..whole.len())]);
        LevelState::of_texels(self.exemplar, texels)
    }

    /// Visits every site once in a growing order, each seeing what all others hold by then, and
    /// shunning texels that are used more often than others.
    pub fn sweep(
        &self,
        state: &mut LevelState,
        order: &[u32],
        progress: Progress<'_>,
    ) -> Result<()> {
        let mut scratch = Scratch::<M::Pattern>::default();
        let mut usage = Usage::of(self.exemplar, &state.coords, self.options.evenness);
        for (visit, &site) in order.iter().enumerate() {
            tell(progress, visit)?;
            let site = site as usize;
            usage.leave(self.exemplar.grid.texel_nearest(state.coords[site]));
            let at = self.choose(site, state, Seen::Used(&usage), &mut scratch);
            usage.take(self.exemplar.grid.texel_nearest(at));
            state.set(self.exemplar, site, at);
        }
        Ok(())
    }

    /// Grows the level from one random texel at one random site: only what is done counts.
    pub fn grow(&self, progress: Progress<'_>) -> Result<LevelState> {
        let mut state = self.random_start();
        let mut done = vec![false; self.sites.site_count];
        let mut scratch = Scratch::<M::Pattern>::default();
        let order = self.visiting_order(0, progress)?;
        for (visit, site) in order.into_iter().enumerate() {
            tell(progress, visit)?;
            let site = site as usize;
            let mut neighbors = self.sites.neighbors.of_site(site);
            if neighbors.any(|near| done[near.site as usize]) {
                let at = self.choose(site, &state, Seen::Done(&done), &mut scratch);
                state.set(self.exemplar, site, at);
            }
            done[site] = true;
        }
        Ok(state)
    }

    /// The first pass: every site takes its coordinate from its parent.
    pub fn from_coarser(&self, coarser: &LevelState) -> LevelState {
        let grid = self.exemplar.grid;
        let guess = |parent: &Parent| first_guess(grid, &coarser.coords, parent);
        let coords = self.sites.parents.par_iter().map(guess).collect();
        LevelState::of_coords(self.exemplar, coords)
    }

    /// The second pass, and `passes` of them: every site chooses anew, colour class after colour class.
    pub fn refine(
        &self,
        state: &mut LevelState,
        classes: &[Vec<u32>],
        passes: u32,
        progress: Progress<'_>,
    ) -> Result<()> {
        let pool = Mutex::new(Vec::<Scratch<M::Pattern>>::new());
        let mut changes = Changes::new(self.sites.site_count, classes.len());
        let batch = match self.options.search {
            Search::KCoherence => BATCH,
            Search::Full => FULL_BATCH,
        };
        let mut chosen = Vec::new();
        for class in (0..passes).flat_map(|_| classes) {
            changes.next_class();
            chosen.clear();
            chosen.resize(class.len(), TexCoord::default());
            let batches = chosen.par_chunks_mut(batch).zip(class.par_chunks(batch));
            batches.for_each(|(chosen, sites)| {
                if progress.is_interrupted() {
                    return;
                }
                let taken = pool.lock().unwrap_or_else(PoisonError::into_inner).pop();
                let mut scratch = taken.unwrap_or_default();
                for (at, &site) in chosen.iter_mut().zip(sites) {
                    let site = site as usize;
                    *at = match changes.is_settled(self.sites, site) {
                        true => state.coords[site],
                        false => self.choose(site, state, Seen::All, &mut scratch),
                    };
                }
                pool.lock()
                    .unwrap_or_else(PoisonError::into_inner)
                    .push(scratch);
            });
            progress.check()?;
            for (&site, &at) in class.iter().zip(&chosen) {
                let site = site as usize;
                if at != state.coords[site] {
                    state.set(self.exemplar, site, at);
                    changes.changed(site);
                }
            }
            progress.advance(class.len() as u64)?;
        }
        Ok(())
    }

    /// A growing order from a random site.
    pub fn visiting_order(&self, sweep: u64, progress: Progress<'_>) -> Result<Vec<u32>> {
        let sites = self.sites.site_count;
        let mut stream = random::stream(self.options.seed, "growth start", self.level, sweep);
        let start = stream
            .gen_range(0..sites.max(1))
            .min(sites.saturating_sub(1));
        growing_order(&self.sites.neighbors, start, self.options.order, progress)
    }

    /// The coordinate a site should hold, given what the others do. Where no candidate is whole, all
    /// whole texels are searched.
    fn choose(
        &self,
        site: usize,
        state: &LevelState,
        seen: Seen<'_>,
        scratch: &mut Scratch<M::Pattern>,
    ) -> TexCoord {
        let done = seen.done();
        let own = done.is_none().then(|| state.coords[site]);
        let Scratch {
            candidates,
            pattern,
        } = scratch;
        let (exemplar, coords) = (self.exemplar, &state.coords);
        let counts = |other: usize| done.is_none_or(|done| done[other]);
        // Case by case, so that each is a loop of its own.
        match &self.sites.neighbors {
            NeighborLists::OfPatches(lists) => {
                candidates.collect_coherent(exemplar, own, lists.of_site(site), coords, counts);
            }
            NeighborLists::OfGrid(grid) => {
                candidates.collect_coherent(exemplar, own, grid.of_site(site), coords, counts);
            }
        }
        let neighborhood = self.neighborhood(site, state, done);
        self.metric.read(&neighborhood, pattern);
        let preference = Preference {
            coherence: self.options.coherence,
            noise: self.noise,
        };
        let mut pick = None;
        if self.options.search == Search::KCoherence {
            pick = self.best_nearby(pattern, candidates, seen);
        }
        let all = |pattern| {
            self.metric
                .best_of_all(pattern, candidates.candidates(), preference)
        };
        let pick = pick.or_else(|| all(pattern));
        let texel = pick.map_or(self.exemplar.whole_texels[0], |pick| pick.texel);
        candidates.place(self.exemplar.grid, texel)
    }

    /// The best of the coherent candidates and the nearest of each.
    fn best_nearby(
        &self,
        pattern: &M::Pattern,
        candidates: &mut CandidateList,
        seen: Seen<'_>,
    ) -> Option<Pick> {
        let (coherence, noise) = (self.options.coherence, self.noise);
        if let Seen::Used(usage) = seen {
            candidates.add_nearest(self.exemplar, coherence);
            candidates.weigh(|texel| usage.factor(texel));
            return self
                .metric
                .best(pattern, candidates.candidates(), None, noise);
        }
        let coherent = self
            .metric
            .best(pattern, candidates.candidates(), None, noise);
        // Not even a distance of nothing would beat this one.
        if coherent.is_some_and(|pick| pick.score < coherence * noise) {
            return coherent;
        }
        let begin = candidates.add_nearest(self.exemplar, coherence);
        let others = &candidates.candidates()[begin..];
        self.metric.best(pattern, others, coherent, noise)
    }

    /// What is round a site, done or not.
    pub fn neighborhood<'s>(
        &'s self,
        site: usize,
        state: &'s LevelState,
        done: Option<&'s [bool]>,
    ) -> SiteNeighborhood<'s> {
        let coarse = self.sites.coarse.as_ref().zip(self.coarser);
        SiteNeighborhood {
            site,
            fine: SampledSites {
                done,
                ..SampledSites::all(&self.sites.fine, &state.rows)
            },
            coarse: coarse.map(|(stencils, held)| SampledSites::all(stencils, &held.rows)),
        }
    }
}

/// Reports a sequential pass now and then; hears at every visit that it should stop.
fn tell(progress: Progress<'_>, visit: usize) -> Result<()> {
    const STEP: usize = 256;
    if visit % STEP == STEP - 1 {
        progress.advance(STEP as u64)?;
    }
    progress.check()
}
