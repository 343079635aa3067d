//! The faces of one level of the sample that can be chosen, and what a choice means.

use rayon::prelude::*;

use crate::mesh::topology::NONE;
use crate::sites::faces::neighborhood::{
    FaceTemplate, NEIGHBORS, Neighborhood, PER_SECTOR, SECTORS,
};
use crate::synthesis::recipes::choosy::counted_tree::{Choice, CountedTree, penalty};
use crate::synthesis::recipes::choosy::face_values::FaceValues;
use crate::synthesis::recipes::choosy::principal_components::PrincipalComponents;
use crate::synthesis::recipes::choosy::sample::AnalysisSample;

/// The factor of σ in the weights of neighbours (Castellanos and Williams, eq. 7).
const WEIGHT_REACH: f64 = 1.3;
/// Faces compared by one thread where neighbours are missing.
const BATCH: usize = 1 << 10;

/// A face of the sample, and how it lies on the face that took it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Source {
    /// The face, by its number on its level of the grid.
    pub face: u32,
    /// The grid: 0 for the upright one, 1 for the one turned by 90°.
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
}

/// The faces of a level that can be chosen: those whose neighbourhoods are whole, on both grids.
///
/// Deviation: in the paper no vertex of the neighbourhood may lie on the border. That leaves few faces of coarse levels.
#[derive(Clone, Debug)]
pub struct SourceFaces<'a> {
    /// The values of the level on both grids.
    values: [&'a FaceValues; 2],
    /// Faces with whole neighbourhoods, the same on both grids.
    faces: Vec<u32>,
    /// Per face of the level its place in `faces`, or [`NONE`].
    places: Vec<u32>,
    neighborhoods: Vec<Neighborhood>,
    /// The weight of every place in a sector.
    weights: [f32; PER_SECTOR],
    components: PrincipalComponents,
}

impl<'a> SourceFaces<'a> {
    /// The faces of a level; `ratio` is σ over the mean distance of adjacent faces, `dimensions` how many principal
    /// components are kept. `None` if no neighbourhood is whole.
    pub fn new(
        (sample, level): (&'a AnalysisSample, usize),
        template: &FaceTemplate,
        ratio: f64,
        dimensions: usize,
    ) -> Option<Self> {
        let topology = &sample.grid.pyramid.levels[level].topology;
        let count = sample.grid.pyramid.levels[level].count();
        let around = |face: u32| (face, template.around(topology, face));
        let is_whole = |(_, around): &(u32, Neighborhood)| !around.contains(&NONE);
        let all = (0..count as u32).into_par_iter().map(around);
        let (faces, neighborhoods): (Vec<u32>, Vec<_>) = all.filter(is_whole).unzip();
        if faces.is_empty() {
            return None;
        }
        let mut places = vec![NONE; count];
        for (place, &face) in faces.iter().enumerate() {
            places[face as usize] = place as u32;
        }
        let [upright, turned] = &sample.pyramids;
        let values = [&upright.gaussian[level], &turned.gaussian[level]];
        let weights = template.distances().map(|distance| {
            let distance = distance / (WEIGHT_REACH * ratio);
            (-0.5 * distance * distance).exp() as f32
        });
        let length = NEIGHBORS * values[0].channels;
        let vector = |item: usize, out: &mut [f32]| {
            let around = &neighborhoods[item % faces.len()];
            weighted(values[item / faces.len()], around, &weights, out);
        };
        let size = (2 * faces.len(), length, SECTORS);
        let components = PrincipalComponents::new(size, dimensions, vector);
        Some(Self {
            values,
            places,
            weights,
            components,
            neighborhoods,
            faces,
        })
    }

    /// Faces that can be chosen, on both grids together.
    pub fn count(&self) -> usize {
        2 * self.faces.len()
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
        CountedTree::new(&numbers, kept)
    }

    /// The face of a point of the tree, at a phase.
    pub fn source(&self, item: u32, phase: u8) -> Source {
        let item = item as usize;
        Source {
            face: self.faces[item % self.faces.len()],
            turn: (item / self.faces.len()) as u8,
            phase,
        }
    }

    /// The point of the tree that stands for a face, if it can be chosen.
    pub fn item(&self, source: Source) -> Option<u32> {
        let place = self.places[source.face as usize];
        let first = u32::from(source.turn) * self.faces.len() as u32;
        (place != NONE).then(|| first + place)
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
        let smallest = uses.smallest();
        let of_batch = |&first: &u32| {
            let mut best = start;
            for item in first..(first + BATCH as u32).min(self.count() as u32) {
                let count = uses.uses(item);
                let factor = penalty(count, smallest);
                for phase in 0..SECTORS as u8 {
                    let limit = best.score / factor;
                    let distance = self.distance_with_gaps(pattern, around, (item, phase), limit);
                    best.offer(Choice {
                        score: distance * factor,
                        count,
                        item,
                        phase,
                    });
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

    /// The squared distance over the neighbours that are there; not all of it once it is larger than a limit.
    fn distance_with_gaps(
        &self,
        pattern: &[f32],
        around: &Neighborhood,
        (item, phase): (u32, u8),
        limit: f64,
    ) -> f64 {
        let (values, sources) = self.neighborhood(item as usize);
        let own = around.iter().zip(pattern.chunks_exact(values.channels));
        let mut sum = 0.0;
        for (at, (_, own)) in own.enumerate().filter(|(_, (face, _))| **face != NONE) {
            let source = sources[(at + usize::from(phase) * PER_SECTOR) % NEIGHBORS];
            let weight = self.weights[at % PER_SECTOR];
            let row = values.row(source as usize);
            let apart = own
                .iter()
                .zip(row)
                .map(|(own, number)| own - weight * number);
            sum += f64::from(apart.map(|apart| apart * apart).sum::<f32>());
            if sum > limit {
                break;
            }
        }
        sum
    }

    fn neighborhood(&self, item: usize) -> (&'a FaceValues, &Neighborhood) {
        let values = self.values[item / self.faces.len()];
        (values, &self.neighborhoods[item % self.faces.len()])
    }
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
