//! Choosy sampling of one level (Castellanos and Williams §3.11, algorithm 2).

use crate::mesh::topology::NONE;
use crate::sites::faces::level::FaceLevel;
use crate::sites::faces::neighborhood::{FaceTemplate, Neighborhood, SECTORS};
use crate::synthesis::recipes::choosy::counted_tree::{Choice, CountedTree, Query};
use crate::synthesis::recipes::choosy::face_values::FaceValues;
use crate::synthesis::recipes::choosy::sample::AnalysisSample;
use crate::synthesis::recipes::choosy::source_faces::{Source, SourceFaces};
use crate::synthesis::rule::Rule;

/// What the faces of a level hold while it is sampled.
pub struct LevelState {
    /// G_k.
    pub values: FaceValues,
    /// L_(k+1), empty at the finest level.
    pub children: FaceValues,
    /// The source of every face, or a guess.
    pub sources: Vec<Source>,
    /// How often every face of the sample was taken.
    pub uses: CountedTree,
}

/// A face takes the sample's face whose neighbourhood is most alike, weighted by its uses.
pub struct ChoosyRule<'a> {
    /// The surface's level.
    pub level: &'a FaceLevel,
    /// The shape of neighbourhoods.
    pub template: &'a FaceTemplate,
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
    query: Query,
}

impl Rule for ChoosyRule<'_> {
    type State = LevelState;
    type Take = Source;
    type Scratch = Patterns;

    fn held(&self, state: &LevelState, site: usize) -> Source {
        state.sources[site]
    }

    fn choose(&self, state: &LevelState, site: usize, scratch: &mut Patterns) -> Source {
        let around = self.template.around(&self.level.topology, site as u32);
        scratch.pattern.resize(self.faces.length(), 0.0);
        self.faces
            .pattern(&state.values, &around, &mut scratch.pattern);
        let choice = match around.contains(&NONE) {
            true => self.search_with_gaps(state, &scratch.pattern, &around),
            false => self.search(state, site, scratch),
        };
        self.faces.source(choice.item, choice.phase)
    }

    fn set(&self, state: &mut LevelState, site: usize, source: Source) {
        let (sample, level) = self.sample;
        let pyramid = &sample.pyramids[usize::from(source.turn)];
        let row = pyramid.gaussian[level].row(source.face as usize);
        state.values.row_mut(site).copy_from_slice(row);
        if let Some(laplacian) = pyramid.laplacian.get(level + 1) {
            for child in 0..4 {
                let row = laplacian.row(source.child(child).face as usize);
                let own = state.children.row_mut(4 * site + child as usize);
                own.copy_from_slice(row);
            }
        }
        if let Some(item) = self.faces.item(source) {
            state.uses.count_use(item);
        }
        state.sources[site] = source;
    }
}

impl ChoosyRule<'_> {
    fn search_with_gaps(
        &self,
        state: &LevelState,
        pattern: &[f32],
        around: &Neighborhood,
    ) -> Choice {
        let start = Choice::NONE;
        self.faces
            .search_with_gaps(pattern, around, &state.uses, start)
    }

    /// The best of three phases. The search starts from the source that the face has already.
    fn search(&self, state: &LevelState, site: usize, scratch: &mut Patterns) -> Choice {
        let components = self.faces.components();
        let kept = components.kept();
        scratch.projected.resize(SECTORS * kept, 0.0);
        for projected in scratch.projected.chunks_exact_mut(kept) {
            components.project(&scratch.pattern, projected);
            let part = scratch.pattern.len() / SECTORS;
            // At phase p, sector c of the surface meets sector c + p of the sample.
            scratch.pattern.rotate_right(part);
        }
        let guess = state.sources[site];
        let mut best = Choice::NONE;
        let Patterns {
            projected, query, ..
        } = scratch;
        if let Some(item) = self.faces.item(guess) {
            let numbers = &projected[usize::from(guess.phase) * kept..][..kept];
            state.uses.set_query(query, numbers);
            best.offer(state.uses.compared(query, item, guess.phase));
        }
        for (phase, numbers) in projected.chunks_exact(kept).enumerate() {
            state.uses.set_query(query, numbers);
            state.uses.search(query, phase as u8, &mut best);
        }
        best
    }
}
