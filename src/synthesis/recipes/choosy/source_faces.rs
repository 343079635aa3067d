//! The faces of one level of the sample that can be chosen, and what a choice means.

use rayon::prelude::*;

use crate::mesh::topology::{NONE, Topology};
use crate::sites::faces::neighborhood::{
    FaceTemplate, NEIGHBORS, Neighborhood, PER_SECTOR, SECTORS,
};
use crate::synthesis::recipes::choosy::counted_tree::{Choice, CountedTree, penalty};
use crate::synthesis::recipes::choosy::face_values::FaceValues;
use crate::synthesis::recipes::choosy::principal_components::PrincipalComponents;
use crate::synthesis::recipes::choosy::sample::AnalysisSample;

/// The factor of σ in the weights of neighbours (Castellanos and Williams, eq. 7).
const WEIGHT_REACH: f64 = 1.3;
/// The floor of squared distances, as a share of the neighbourhoods' variance.
const FLOOR_SHARE: f64 = 0.02;
/// Faces compared by one thread where neighbours are missing.
const BATCH: usize = 1 << 10;

/// A face of the sample, and how it lies on the face that took it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Source {
    /// The face, by its number on its level of the grid.
    pub face: u32,
    /// The grid: 0 for the upright one, 1 for the one rotated by 90°.
    pub turn: u8,
    /// Corner k of the face that took it lies on corner k + phase of the source.
    pub phase: u8,
}

impl Source {
    /// The source of a child: what child 0–3 of a face has on the next level, if the face has this source.
    ///
    /// The outer children turn with the source; the centre stays the centre. All have the phase of their parents.
    pub fn child(self, child: u32) -> Self {
        let child = match child {
            3 => 3,
            outer => (outer + u32::from(self.phase)) % 3,
        };
        Self {
            face: 4 * self.face + child,
            ..self
        }
    }

    /// The source that continues this one across edge `own` of the face that has it, for a face whose edge `other` that
    /// is; `None` where the grid ends.
    pub fn across(self, grid: &Topology, own: u32, other: u32) -> Option<Self> {
        let edge = (own + u32::from(self.phase)) % 3;
        let twin = grid.opposite[(3 * self.face + edge) as usize];
        (twin != NONE).then(|| Self {
            face: twin / 3,
            phase: ((twin % 3 + 3 - other) % 3) as u8,
            ..self
        })
    }
}

/// The faces of a level, on both grids; all of them can be chosen.
///
/// Deviation: in the paper neighbourhoods that reach the border cannot be chosen, which leaves out 2,752 of the
/// 30,720 faces of 96 × 96 pixels, and a larger share on coarser levels. Here the sample continues beyond its border
/// as its mirror image.
#[derive(Clone, Debug)]
pub struct SourceFaces<'a> {
    /// The values of the level on both grids.
    values: [&'a FaceValues; 2],
    /// The neighbourhood of every face, the same on both grids.
    neighborhoods: Vec<Neighborhood>,
    /// The weight of every place in a sector.
    weights: [f32; PER_SECTOR],
    components: PrincipalComponents,
}

impl<'a> SourceFaces<'a> {
    /// The faces of a level; `ratio` is σ over the mean distance of adjacent faces, `dimensions` how many principal
    /// components are kept. `None` if the level is so small that every neighbourhood reaches its border.
    pub fn new(
        (sample, level): (&'a AnalysisSample, usize),
        template: &FaceTemplate,
        ratio: f64,
        dimensions: usize,
    ) -> Option<Self> {
        // Require a face that is surrounded on all sides.
        let topology = &sample.grid.pyramid.levels[level].topology;
        let count = sample.grid.pyramid.levels[level].count() as u32;
        let is_whole = |face| !template.around(topology, face).contains(&NONE);
        if !(0..count).into_par_iter().any(is_whole) {
            return None;
        }
        // List the neighbourhoods, mirrored at the borders.
        let around = |face| template.around_mirrored(topology, face);
        let neighborhoods: Vec<_> = (0..count).into_par_iter().map(around).collect();
        let [upright, turned] = &sample.pyramids;
        let values = [&upright.gaussian[level], &turned.gaussian[level]];
        // Weight the neighbours by their distance.
        let weights = template.distances().map(|distance| {
            let distance = distance / (WEIGHT_REACH * ratio);
            (-0.5 * distance * distance).exp() as f32
        });
        let length = NEIGHBORS * values[0].channels;
        // Find the principal components.
        let vector = |item: usize, out: &mut [f32]| {
            let around = &neighborhoods[item % neighborhoods.len()];
            weighted(values[item / neighborhoods.len()], around, &weights, out);
        };
        let size = (2 * neighborhoods.len(), length, SECTORS);
        let components = PrincipalComponents::new(size, dimensions, vector);
        Some(Self {
            values,
            weights,
            components,
            neighborhoods,
        })
    }

    /// Faces that can be chosen, on both grids together.
    pub fn count(&self) -> usize {
        2 * self.neighborhoods.len()
    }

    /// Numbers of a neighbourhood.
    pub fn length(&self) -> usize {
        NEIGHBORS * self.values[0].channels
    }

    /// The principal components of the weighted neighbourhoods.
    pub fn components(&self) -> &PrincipalComponents {
        &self.components
    }

    /// The tree of the projected neighbourhoods; its points are the faces that can be chosen.
    pub fn tree(&self) -> CountedTree {
        let (length, kept) = (self.length(), self.components.kept());
        let mut numbers = vec![0.0; self.count() * kept];
        let rows = numbers.par_chunks_exact_mut(kept).enumerate();
        rows.for_each_init(
            || vec![0.0; length],
            |vector, (item, row)| {
                let (values, around) = self.neighborhood(item);
                weighted(values, around, &self.weights, vector);
                self.components.project(vector, row);
            },
        );
        CountedTree::new(&numbers, kept, (FLOOR_SHARE * self.variance()) as f32)
    }

    /// The mean squared distance of the neighbourhoods from their first principal component, which is little but their
    /// mean.
    fn variance(&self) -> f64 {
        let others = self.components.eigenvalues.iter().skip(1);
        others.sum::<f64>() / (SECTORS * self.count()) as f64
    }

    /// The face of a point of the tree, at a phase.
    pub fn source(&self, item: u32, phase: u8) -> Source {
        let faces = self.neighborhoods.len() as u32;
        Source {
            face: item % faces,
            turn: (item / faces) as u8,
            phase,
        }
    }

    /// The point of the tree that stands for a face.
    pub fn item(&self, source: Source) -> u32 {
        u32::from(source.turn) * self.neighborhoods.len() as u32 + source.face
    }

    /// Writes the weighted values round a face of a surface; 0 for neighbours that are missing.
    pub fn pattern(&self, values: &FaceValues, around: &Neighborhood, out: &mut [f32]) {
        weighted(values, around, &self.weights, out);
    }

    /// The best face where neighbours are missing: those count nothing, and all numbers of the others are compared.
    /// `pattern` holds the weighted values.
    pub fn search_with_gaps(
        &self,
        pattern: &[f32],
        around: &Neighborhood,
        uses: &CountedTree,
        start: Choice,
    ) -> Choice {
        let items: Vec<u32> = (0..self.count() as u32).step_by(BATCH).collect();
        let present = present(around);
        let of_batch = |&first: &u32| {
            let mut best = start;
            for item in first..(first + BATCH as u32).min(self.count() as u32) {
                for phase in 0..SECTORS as u8 {
                    let own = (pattern, present.as_slice());
                    best.offer(self.scored_with_gaps(own, uses, (item, phase), best.score));
                }
            }
            best
        };
        let found: Vec<Choice> = items.par_iter().map(of_batch).collect();
        found.into_iter().fold(start, |mut best, other| {
            best.offer(other);
            best
        })
    }

    /// What one face scores at a phase where neighbours are missing.
    pub fn compared_with_gaps(
        &self,
        pattern: &[f32],
        around: &Neighborhood,
        uses: &CountedTree,
        guess: (u32, u8),
    ) -> Choice {
        self.scored_with_gaps((pattern, &present(around)), uses, guess, f64::INFINITY)
    }

    /// The score over the neighbours that are there, nearest first; less than all of it once it is larger than a limit.
    fn scored_with_gaps(
        &self,
        (pattern, present): (&[f32], &[usize]),
        uses: &CountedTree,
        (item, phase): (u32, u8),
        limit: f64,
    ) -> Choice {
        // Begin with what the item's uses cost.
        let count = uses.uses(item);
        let (factor, floor) = (penalty(count, uses.smallest()), f64::from(uses.floor()));
        let (values, sources) = self.neighborhood(item as usize);
        let mut sum = 0.0;
        // Add neighbour after neighbour until the limit.
        for &at in present {
            let source = sources[(at + usize::from(phase) * PER_SECTOR) % NEIGHBORS];
            let weight = self.weights[at % PER_SECTOR];
            let own = &pattern[at * values.channels..];
            let row = values.row(source as usize).iter();
            let apart = own
                .iter()
                .zip(row)
                .map(|(own, number)| own - weight * number);
            sum += f64::from(apart.map(|apart| apart * apart).sum::<f32>());
            if (sum + floor) * factor > limit {
                break;
            }
        }
        Choice {
            score: (sum + floor) * factor,
            count,
            item,
            phase,
        }
    }

    fn neighborhood(&self, item: usize) -> (&'a FaceValues, &Neighborhood) {
        let faces = self.neighborhoods.len();
        (self.values[item / faces], &self.neighborhoods[item % faces])
    }
}

/// The places of the neighbours that are there, nearest first.
fn present(around: &Neighborhood) -> Vec<usize> {
    let nearest_first = (0..PER_SECTOR).flat_map(|place| [0, 1, 2].map(|c| c * PER_SECTOR + place));
    nearest_first.filter(|&at| around[at] != NONE).collect()
}

/// Writes the values of a neighbourhood, each times the weight of its place; 0 for those that are missing.
fn weighted(
    values: &FaceValues,
    around: &Neighborhood,
    weights: &[f32; PER_SECTOR],
    out: &mut [f32],
) {
    let rows = out.chunks_exact_mut(values.channels);
    for (at, (row, &face)) in rows.zip(around).enumerate() {
        if face == NONE {
            row.fill(0.0);
            continue;
        }
        let weight = weights[at % PER_SECTOR];
        for (out, &number) in row.iter_mut().zip(values.row(face as usize)) {
            *out = weight * number;
        }
    }
}
