//! The rule: of the texels that may stand at a site, first the label of the one whose mask is most similar round it,
//! then the one whose colours and mask are (Zhang 2003 §5.1).

use std::sync::atomic::{AtomicU64, Ordering};

use crate::grid::{TexCoord, TexelGrid};
use crate::sites::controls::SiteControls;
use crate::sites::level::{Neighbor, Sites};
use crate::synthesis::candidates::forward::{CandidateList, shifted};
use crate::synthesis::metric::site_values::{SiteNeighborhood, Unfinished};
use crate::synthesis::recipes::progressive::exemplar::{Kind, VariantLevel, Windows};
use crate::synthesis::recipes::progressive::options::Widths;
use crate::synthesis::recipes::progressive::ring_metric::RingPattern;
use crate::synthesis::rule::Rule;
use crate::synthesis::state::Texels;

/// How many times the distance of a texel counts that no neighbour proposes itself.
const COHERENCE: f64 = 1.5;
/// Neighbours propose texels from at most this many texels away.
const NEAR: f32 = 3.0;

/// What the sites of a level hold.
#[derive(Clone, Debug, PartialEq)]
pub struct State {
    /// Texels.
    pub texels: Texels,
    /// Labels; empty where masks are left out.
    pub labels: Vec<u32>,
}

impl State {
    /// Texels, each with the label that a mask has there; an empty mask is left out.
    pub fn of(texels: Texels, mask: &[u32], grid: TexelGrid) -> Self {
        let label = |&at: &TexCoord| mask.get(grid.texel_nearest(at).index()).copied();
        Self {
            labels: texels.coords.iter().filter_map(label).collect(),
            texels,
        }
    }
}

/// What one site takes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Labelled {
    at: TexCoord,
    label: u32,
}

/// What a pass compares.
#[derive(Clone, Copy, Debug)]
pub struct Pass {
    /// The window of masks that labels are chosen by; `None` leaves labels as they are.
    pub mask_window: Option<Widths>,
    /// The window that texels are chosen by.
    pub color_window: Widths,
}

/// The rule on one level.
pub struct Varied<'a, const N: usize, S> {
    /// The exemplar's level.
    pub level: &'a VariantLevel<'a>,
    /// The sites.
    pub sites: &'a S,
    /// What they follow.
    pub controls: &'a SiteControls,
    /// What the coarser level holds, where there is one.
    pub coarser: Option<&'a State>,
    /// What is compared.
    pub pass: Pass,
    /// Choices for which no neighbour proposed a texel that may stand there, so that the whole band was tried.
    pub searched: &'a AtomicU64,
}

/// Working memory of one thread.
#[derive(Default)]
pub struct Scratch {
    candidates: CandidateList,
    colors: Patterns,
    masks: Patterns,
}

/// What is round a site in one kind of numbers.
#[derive(Default)]
struct Patterns {
    own: RingPattern,
    parent: RingPattern,
}

impl<const N: usize, S: Sites<N>> Rule for Varied<'_, N, S> {
    type State = State;
    type Take = Labelled;
    type Scratch = Scratch;

    fn held(&self, state: &State, site: usize) -> Labelled {
        Labelled {
            at: state.texels.coords[site],
            label: state.labels.get(site).copied().unwrap_or_default(),
        }
    }

    fn choose(&self, state: &State, site: usize, scratch: &mut Scratch) -> Labelled {
        if !self.collect(state, site, &mut scratch.candidates) {
            // The first site of a part keeps its random texel.
            return self.held(state, site);
        }
        let label = self.label(state, site, scratch);
        let texel = self.texel(state, site, label, scratch);
        let grid = self.level.exemplar.grid;
        Labelled {
            at: scratch.candidates.place(grid, texel),
            label,
        }
    }

    fn set(&self, state: &mut State, site: usize, held: Labelled) {
        state.texels.set(&self.level.exemplar, site, held.at);
        if let Some(label) = state.labels.get_mut(site) {
            *label = held.label;
        }
    }
}

impl<const N: usize, S: Sites<N>> Varied<'_, N, S> {
    /// Collects the texels that may stand at a site, with the painted label if there is one in the band; whether
    /// there is anything to compare them by.
    fn collect(&self, state: &State, site: usize, candidates: &mut CandidateList) -> bool {
        // Find the neighbours that are done.
        let (exemplar, coords) = (&self.level.exemplar, &state.texels.coords);
        let done = state.texels.done.as_deref();
        let near = |near: &Neighbor| near.x.hypot(near.y) <= NEAR;
        let neighbors = self.sites.neighbors(site).take_while(near);
        let mut neighbors = neighbors
            .filter(|near| done.is_none_or(|done| done[near.site as usize]))
            .peekable();
        if done.is_some() && neighbors.peek().is_none() {
            return false;
        }
        // Collect what they propose, turned to the exemplar's orientation, and what is nearest to
        // it.
        let own = done.is_none().then(|| coords[site]);
        let proposed = neighbors.map(|near| {
            let at = coords[near.site as usize];
            let offset = self.level.turned(at, near.x, near.y);
            shifted(at, offset.x, offset.y)
        });
        candidates.collect_proposed(exemplar, own.into_iter().chain(proposed));
        candidates.add_nearest(exemplar, COHERENCE);
        // Keep what has the transition and the painted label.
        let (band, value) = (&self.level.band, self.controls.transition[site]);
        let painted = self.painted(site);
        let has_label =
            |texel: u32| painted.is_none_or(|label| self.level.labels[texel as usize] == label);
        candidates.retain(|texel| band.admits(texel, value) && has_label(texel));
        // Take all texels of the transition where nothing is left.
        if candidates.candidates().is_empty() {
            let within = band.texels(value).iter().copied();
            candidates.replace(within.clone().filter(|&texel| has_label(texel)));
            if candidates.candidates().is_empty() {
                candidates.replace(within);
            }
            self.searched.fetch_add(1, Ordering::Relaxed);
        }
        true
    }

    /// The label that is painted at a site, where masks count.
    fn painted(&self, site: usize) -> Option<u32> {
        let mask = self.controls.mask.as_ref()?;
        (!self.level.labels.is_empty()).then(|| u32::from(mask[site]))
    }

    /// The label of a site: the painted one, else that of the candidate whose mask is most similar round it.
    fn label(&self, state: &State, site: usize, scratch: &mut Scratch) -> u32 {
        let Some(masks) = &self.level.own.masks else {
            return 0;
        };
        if let Some(label) = self.painted(site) {
            return label;
        }
        let Some(widths) = self.pass.mask_window else {
            return state.labels[site];
        };
        let rings = widths.rings(self.controls.transition[site]);
        let Scratch {
            candidates,
            masks: patterns,
            ..
        } = scratch;
        let neighborhood = self.masks_round(state, site);
        masks.read(&neighborhood, rings, &mut patterns.own);
        self.read_parent(&neighborhood, Kind::Masks, &mut patterns.parent);
        let texel = most_alike(candidates, |texel, limit| {
            // Its own label is what is sought.
            let own = masks.distance(&patterns.own, texel, 1, (0.0, limit));
            self.with_parent(Kind::Masks, &patterns.parent, texel, (own, limit))
        });
        self.level.labels[texel as usize]
    }

    /// The candidate whose colours and mask are most similar round a site, of which the mask has a label.
    fn texel(&self, state: &State, site: usize, label: u32, scratch: &mut Scratch) -> u32 {
        let Windows { colors, masks } = &self.level.own;
        let rings = self.pass.color_window.rings(self.controls.transition[site]);
        let Scratch {
            candidates,
            colors: color_patterns,
            masks: mask_patterns,
        } = scratch;
        let neighborhood = self.colors_round(state, site);
        colors.read(&neighborhood, rings, &mut color_patterns.own);
        self.read_parent(&neighborhood, Kind::Colors, &mut color_patterns.parent);
        if let Some(masks) = masks {
            let neighborhood = self.masks_round(state, site);
            masks.read(&neighborhood, rings, &mut mask_patterns.own);
            masks.set_centre(&mut mask_patterns.own, label);
            self.read_parent(&neighborhood, Kind::Masks, &mut mask_patterns.parent);
        }
        most_alike(candidates, |texel, limit| {
            let mut sum = 0.0;
            if let Some(masks) = masks {
                sum = masks.distance(&mask_patterns.own, texel, 0, (sum, limit));
                let parent = &mask_patterns.parent;
                sum = self.with_parent(Kind::Masks, parent, texel, (sum, limit));
            }
            let parent = &color_patterns.parent;
            sum = self.with_parent(Kind::Colors, parent, texel, (sum, limit));
            colors.distance(&color_patterns.own, texel, 1, (sum, limit))
        })
    }

    fn colors_round<'s>(&'s self, state: &'s State, site: usize) -> SiteNeighborhood<'s, S> {
        SiteNeighborhood {
            site,
            sites: self.sites,
            rows: &state.texels.rows,
            done: state.texels.done.as_deref(),
            unfinished: Unfinished::LeftOut,
            coarser: self.coarser.map(|coarser| &coarser.texels.rows[..]),
        }
    }

    fn masks_round<'s>(&'s self, state: &'s State, site: usize) -> SiteNeighborhood<'s, S> {
        SiteNeighborhood {
            rows: &state.labels,
            coarser: self.coarser.map(|coarser| &coarser.labels[..]),
            ..self.colors_round(state, site)
        }
    }

    /// Reads the samples on the coarser level, where there is one.
    fn read_parent(&self, site: &SiteNeighborhood<'_, S>, kind: Kind, pattern: &mut RingPattern) {
        if let Some(coarser) = &self.level.coarser
            && let Some(metric) = coarser.windows.of(kind)
        {
            metric.read_parent(site, pattern);
        }
    }

    /// A distance and that on the coarser level, where there is one.
    #[inline(always)]
    fn with_parent(
        &self,
        kind: Kind,
        pattern: &RingPattern,
        texel: u32,
        (sum, limit): (f32, f32),
    ) -> f32 {
        if let Some(coarser) = &self.level.coarser
            && let Some(metric) = coarser.windows.of(kind)
            && sum <= limit
        {
            return metric.distance(pattern, coarser.parents[texel as usize], 0, (sum, limit));
        }
        sum
    }
}

/// The candidate of the smallest distance, of equals that of the smallest number.
fn most_alike(candidates: &CandidateList, distance: impl Fn(u32, f32) -> f32) -> u32 {
    let mut best = (f32::INFINITY, u32::MAX);
    for candidate in candidates.candidates() {
        let (texel, factor) = (candidate.texel, candidate.factor as f32);
        let found = factor * distance(texel, best.0 / factor);
        if (found, texel) < best {
            best = (found, texel);
        }
    }
    best.1
}
