//! Choosy sampling of one level (Castellanos and Williams §3.11, algorithm 2).

use crate::mesh::topology::NONE;
use crate::sites::faces::level::FaceLevel;
use crate::sites::faces::neighborhood::{Neighborhood, SECTORS};
use crate::synthesis::recipes::choosy::counted_tree::{Choice, CountedTree, is_exact};
use crate::synthesis::recipes::choosy::face_values::FaceValues;
use crate::synthesis::recipes::choosy::sample::AnalysisSample;
use crate::synthesis::recipes::choosy::source_faces::{Source, SourceFaces};
use crate::synthesis::rule::{Foreseen, Rule};

/// What the faces of a level hold while it is sampled.
#[derive(Clone, Debug)]
pub struct LevelState {
    /// G_k.
    pub values: FaceValues,
    /// L_(k+1), empty at the finest level.
    pub children: FaceValues,
    /// The source of every face, or a guess.
    pub sources: Vec<Source>,
    /// How often every face of the sample was taken.
    pub uses: CountedTree,
    /// What was set since the run began.
    pub changes: RunChanges,
}

/// What was set since a run of visits began.
#[derive(Clone, Debug, Default)]
pub struct RunChanges {
    /// The number of the run, from 1 on.
    run: u32,
    /// Per face of the surface, the run in which its values changed last.
    changed: Vec<u32>,
    /// Per face of the sample that can be chosen, the run in which it was taken last.
    taken: Vec<u32>,
    /// The smallest number of uses when the run began.
    smallest: u32,
}

impl RunChanges {
    /// For this many faces of the surface, and of the sample.
    pub fn new(sites: usize, items: usize) -> Self {
        Self {
            run: 0,
            changed: vec![0; sites],
            taken: vec![0; items],
            smallest: 0,
        }
    }
}

/// A face takes the sample's face whose neighbourhood is most similar, weighted by its uses.
pub struct ChoosyRule<'a> {
    /// The surface's level.
    pub level: &'a FaceLevel,
    /// The faces round every face.
    pub neighborhoods: &'a [Neighborhood],
    /// The sample, and the number of the level.
    pub sample: (&'a AnalysisSample, usize),
    /// The sample's faces on that level.
    pub faces: &'a SourceFaces<'a>,
}

/// Working memory.
#[derive(Default)]
pub struct Patterns {
    pattern: Vec<f32>,
    projected: Vec<f32>,
}

impl Rule for ChoosyRule<'_> {
    type State = LevelState;
    type Take = Source;
    type Scratch = Patterns;

    fn held(&self, state: &LevelState, site: usize) -> Source {
        state.sources[site]
    }

    fn choose(&self, state: &LevelState, site: usize, scratch: &mut Patterns) -> Source {
        let around = &self.neighborhoods[site];
        scratch.pattern.resize(self.faces.length(), 0.0);
        self.faces
            .pattern(&state.values, around, &mut scratch.pattern);
        let choice = match around.contains(&NONE) {
            true => self.search_with_gaps(state, site, &scratch.pattern),
            false => self.search(state, site, scratch),
        };
        self.faces.source(choice.item, choice.phase)
    }

    fn batch(&self) -> usize {
        BATCH
    }

    fn set(&self, state: &mut LevelState, site: usize, source: Source) {
        let (sample, level) = self.sample;
        let pyramid = &sample.pyramids[usize::from(source.turn)];
        let row = pyramid.gaussian[level].row(source.face as usize);
        if state.values.row(site) != row {
            state.values.row_mut(site).copy_from_slice(row);
            state.changes.changed[site] = state.changes.run;
        }
        if let Some(laplacian) = pyramid.laplacian.get(level + 1) {
            for child in 0..4 {
                let row = laplacian.row(source.child(child).face as usize);
                let own = state.children.row_mut(4 * site + child as usize);
                own.copy_from_slice(row);
            }
        }
        let item = self.faces.item(source);
        state.uses.count_use(item);
        state.changes.taken[item as usize] = state.changes.run;
        state.sources[site] = source;
    }
}

/// Sites that a thread takes at a time.
const BATCH: usize = 8;
/// Visits of a run, at most, as a share of the faces of the surface and of those of the sample: few choices are made
/// again.
const RUN_SHARE: usize = 256;
const RUN_SHARE_OF_SAMPLE: usize = 16;

impl Foreseen for ChoosyRule<'_> {
    fn run(&self) -> usize {
        let most = self.faces.count() / RUN_SHARE_OF_SAMPLE;
        (self.level.count() / RUN_SHARE).min(most)
    }

    fn begin_run(&self, state: &mut LevelState) {
        state.changes.run += 1;
        state.changes.smallest = state.uses.smallest();
    }

    /// A use only makes a face of the sample worse, and a larger smallest count changes all scores by the same factor.
    /// So the best one stays the best unless it was used itself or something round the site has changed.
    fn stands(&self, state: &LevelState, site: usize, take: Source) -> bool {
        let changes = &state.changes;
        let is_new = |&face: &u32| face != NONE && changes.changed[face as usize] == changes.run;
        let item = self.faces.item(take);
        changes.taken[item as usize] != changes.run
            && is_exact(state.uses.uses(item), changes.smallest)
            && !self.neighborhoods[site].iter().any(is_new)
    }
}

impl ChoosyRule<'_> {
    fn search_with_gaps(&self, state: &LevelState, site: usize, pattern: &[f32]) -> Choice {
        let around = &self.neighborhoods[site];
        let mut start = Choice::NONE;
        for guess in self.guesses(state, site) {
            let guess = (self.faces.item(guess), guess.phase);
            start.offer(
                self.faces
                    .compared_with_gaps(pattern, around, &state.uses, guess),
            );
        }
        self.faces
            .search_with_gaps(pattern, around, &state.uses, start)
    }

    /// The best of three phases. The search starts from good guesses, which shorten it and do not change what is
    /// found: the source that the face has already, and what lies beside the sources of the faces round it.
    fn search(&self, state: &LevelState, site: usize, scratch: &mut Patterns) -> Choice {
        let components = self.faces.components();
        let kept = components.kept();
        let Patterns { pattern, projected } = scratch;
        projected.resize(SECTORS * kept, 0.0);
        for projected in projected.chunks_exact_mut(kept) {
            components.project(pattern, projected);
            // At phase p, sector c of the surface meets sector c + p of the sample.
            let part = pattern.len() / SECTORS;
            pattern.rotate_right(part);
        }
        let of_phase = |phase: usize| &projected[phase * kept..][..kept];
        let mut best = Choice::NONE;
        for guess in self.guesses(state, site) {
            let numbers = of_phase(usize::from(guess.phase));
            let item = self.faces.item(guess);
            best.offer(state.uses.compared(numbers, item, guess.phase));
        }
        let first = usize::from(best.phase);
        for phase in (first..first + SECTORS).map(|phase| phase % SECTORS) {
            state.uses.search(of_phase(phase), phase as u8, &mut best);
        }
        best
    }

    /// The source of a face, and those that would continue the sources of the faces across its edges.
    fn guesses(&self, state: &LevelState, site: usize) -> impl Iterator<Item = Source> {
        let (sample, level) = self.sample;
        let grid = &sample.grid.pyramid.levels[level].topology;
        let across = (0..3).filter_map(move |edge| {
            let twin = self.level.topology.opposite[3 * site + edge];
            let neighbor = (twin != NONE).then(|| state.sources[twin as usize / 3])?;
            neighbor.across(grid, twin % 3, edge as u32)
        });
        [state.sources[site]].into_iter().chain(across)
    }
}
