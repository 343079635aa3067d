//! Gaussian convolution on faces, and its two uses: reduce and project (Castellanos and Williams §3.6, §3.7).

use rayon::prelude::*;

use crate::mesh::face_colors::across_edges;
use crate::sites::faces::level::{AdjacentDistances, FaceLevel};
use crate::sites::faces::pyramid::FacePyramid;
use crate::synthesis::recipes::choosy::face_values::FaceValues;

/// How far the Gaussian reaches, in standard deviations: 3, and a little more so that rounding does not decide about
/// faces of a regular grid at that distance.
const REACH: f64 = 3.0 * (1.0 + 1e-4);
/// The child whose value a parent takes when a level is reduced.
const CENTER: usize = 3;
/// Children of a face.
const CHILDREN: usize = 4;
/// Faces that a thread takes at a time.
const BATCH: usize = 1 << 12;

/// A Gaussian on the faces of a level.
///
/// Face j weighs exp(−d²/2σ²) · area of j in the mean round face i, where d is the distance of their centres. The
/// faces that count are reached from i across edges, each no farther from i than 3σ.
#[derive(Clone, Copy, Debug)]
pub struct FaceKernel<'a> {
    level: &'a FaceLevel,
    /// σ, in mesh units.
    deviation: f64,
}

/// The ratio of the largest and the mean distance of adjacent faces: 1 on a regular grid.
///
/// Castellanos and Williams §3.10 measure distances of a surface's level in units that make the mean distance of
/// adjacent faces that of the sample's grid, and let σ be the largest. So σ is this ratio times the mean distance, on
/// the surface and on the grid alike, each in its own units.
pub fn distance_ratio(level: &FaceLevel) -> f64 {
    let AdjacentDistances { mean, largest } = level.adjacent_distances();
    if mean > 0.0 { largest / mean } else { 1.0 }
}

/// The kernels of all levels of a pyramid, from the ratios of σ and the mean distance of adjacent faces.
pub fn kernels<'a>(pyramid: &'a FacePyramid, ratios: &[f64]) -> Vec<FaceKernel<'a>> {
    let levels = pyramid.levels.iter().zip(ratios);
    levels
        .map(|(level, ratio)| FaceKernel::new(level, ratio * level.adjacent_distances().mean))
        .collect()
}

impl<'a> FaceKernel<'a> {
    /// The kernel of standard deviation `deviation`, in mesh units.
    pub fn new(level: &'a FaceLevel, deviation: f64) -> Self {
        Self { level, deviation }
    }

    /// The values of the coarser level: the mean round the centre child of every parent.
    pub fn reduce(&self, values: &FaceValues) -> FaceValues {
        let center_of = |parent: usize| CHILDREN * parent + CENTER;
        let same = |face: usize| Some(face);
        self.means(self.level.count() / CHILDREN, center_of, values, same)
    }

    /// The values of this level from those of the coarser one. White faces have their parents' values and black
    /// faces none; every face is the mean of the white ones round it, which is what the factor Γ comes to.
    pub fn project(&self, coarser: &FaceValues) -> FaceValues {
        let itself = |face: usize| face;
        let of_white = |face: usize| self.level.white[face].then_some(face / CHILDREN);
        self.means(self.level.count(), itself, coarser, of_white)
    }

    /// Weighted means of rows of values, one per output; `row_of` says which row stands for a face, if any.
    fn means(
        &self,
        count: usize,
        face_of: impl Fn(usize) -> usize + Sync,
        values: &FaceValues,
        row_of: impl Fn(usize) -> Option<usize> + Sync,
    ) -> FaceValues {
        let channels = values.channels;
        let mut means = FaceValues::zeros(count, channels);
        let batches = means.numbers.par_chunks_mut((BATCH * channels).max(1));
        // Sum the weighted rows round each face, where there are any.
        batches.enumerate().for_each(|(batch, rows)| {
            let mut support = Support::new(self.level.count());
            let mut sums = vec![0.0f64; channels];
            for (index, row) in rows.chunks_exact_mut(channels.max(1)).enumerate() {
                support.gather(self, face_of(batch * BATCH + index));
                sums.fill(0.0);
                let mut total = 0.0;
                for &(face, weight) in &support.weighted {
                    if let Some(held) = row_of(face as usize) {
                        total += weight;
                        for (sum, &value) in sums.iter_mut().zip(values.row(held)) {
                            *sum += weight * f64::from(value);
                        }
                    }
                }
                for (mean, sum) in row.iter_mut().zip(&sums) {
                    *mean = if total > 0.0 {
                        (sum / total) as f32
                    } else {
                        0.0
                    };
                }
            }
        });
        means
    }
}

/// The faces under a kernel.
struct Support {
    /// Per face the number of the search that met it last.
    met: Vec<u32>,
    search: u32,
    /// The faces and their weights, the middle first.
    weighted: Vec<(u32, f64)>,
}

impl Support {
    fn new(faces: usize) -> Self {
        Self {
            met: vec![0; faces],
            search: 0,
            weighted: Vec::new(),
        }
    }

    fn gather(&mut self, kernel: &FaceKernel<'_>, middle: usize) {
        let FaceKernel { level, deviation } = *kernel;
        self.search += 1;
        self.weighted.clear();
        self.met[middle] = self.search;
        self.weighted
            .push((middle as u32, f64::from(level.areas[middle])));
        let mut next = 0;
        while let Some(&(face, _)) = self.weighted.get(next) {
            next += 1;
            for neighbor in across_edges(&level.topology, face) {
                let met = &mut self.met[neighbor as usize];
                if *met == self.search {
                    continue;
                }
                *met = self.search;
                let distance = level.distance(middle, neighbor as usize) / deviation;
                if distance <= REACH {
                    let weight = (-0.5 * distance * distance).exp();
                    let area = f64::from(level.areas[neighbor as usize]);
                    self.weighted.push((neighbor, weight * area));
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::face_colors::colored_base;
    use crate::mesh::shapes;
    use crate::progress::Progress;
    use crate::random;
    use rand::Rng;

    fn torus() -> FacePyramid {
        let torus = shapes::torus(12, 8, 1.0, 0.4);
        let base = colored_base(&torus, 192, 0.7, Progress::silent()).unwrap();
        FacePyramid::subdivided(&base, 1, Progress::silent()).unwrap()
    }

    fn noise(faces: usize, channels: usize) -> FaceValues {
        let mut stream = random::stream(4, "noise", 0, 0);
        let numbers = (0..faces * channels).map(|_| stream.gen_range(-1.0..1.0));
        FaceValues {
            channels,
            numbers: numbers.collect(),
        }
    }

    /// Faces joined to another through faces within 3σ of it, found by sweeps over all.
    fn direct_support(level: &FaceLevel, middle: usize, deviation: f64) -> Vec<(usize, f64)> {
        let mut joined = vec![false; level.count()];
        joined[middle] = true;
        loop {
            let grown: Vec<usize> = (0..level.count())
                .filter(|&face| !joined[face] && level.distance(middle, face) <= 3.0 * deviation)
                .filter(|&face| {
                    let mut neighbors = across_edges(&level.topology, face as u32);
                    neighbors.any(|neighbor| joined[neighbor as usize])
                })
                .collect();
            if grown.is_empty() {
                break;
            }
            grown.into_iter().for_each(|face| joined[face] = true);
        }
        let weight = |face: usize| {
            let distance = level.distance(middle, face) / deviation;
            (-0.5 * distance.powi(2)).exp() * f64::from(level.areas[face])
        };
        let all = (0..level.count()).filter(|&face| joined[face]);
        all.map(|face| (face, weight(face))).collect()
    }

    #[test]
    fn reduce_and_project_are_the_direct_sums() {
        let pyramid = torus();
        let fine = &pyramid.levels[1];
        let deviation = fine.adjacent_distances().largest;
        let kernel = FaceKernel::new(fine, deviation);
        let (fine_values, coarse_values) = (noise(768, 2), noise(192, 2));
        let (reduced, projected) = (kernel.reduce(&fine_values), kernel.project(&coarse_values));
        assert_eq!((reduced.count(), projected.count()), (192, 768));
        for parent in 0..192 {
            let support = direct_support(fine, 4 * parent + 3, deviation);
            for channel in 0..2 {
                let total: f64 = support.iter().map(|&(_, weight)| weight).sum();
                let terms = support
                    .iter()
                    .map(|&(face, weight)| weight * f64::from(fine_values.row(face)[channel]));
                let wanted = terms.sum::<f64>() / total;
                assert!((f64::from(reduced.row(parent)[channel]) - wanted).abs() < 1e-6);
            }
        }
        for face in 0..768 {
            let support = direct_support(fine, face, deviation);
            let white = || support.iter().filter(|&&(face, _)| fine.white[face]);
            let gamma: f64 = white().map(|&(_, weight)| weight).sum();
            let terms = white()
                .map(|&(face, weight)| weight / gamma * f64::from(coarse_values.row(face / 4)[1]));
            let wanted: f64 = terms.sum();
            assert!((f64::from(projected.row(face)[1]) - wanted).abs() < 1e-6);
        }
    }

    #[test]
    fn constants_are_kept_and_scale_does_not_matter() {
        let pyramid = torus();
        let ratio = distance_ratio(&pyramid.levels[1]);
        let half = |faces: usize| FaceValues {
            channels: 1,
            numbers: vec![0.5; faces],
        };
        let kernel = kernels(&pyramid, &[1.0, ratio])[1];
        assert_eq!(kernel.reduce(&half(768)), half(192));
        assert_eq!(kernel.project(&half(192)), half(768));
        let mut large = pyramid.levels[1].clone();
        for position in &mut large.mesh.positions {
            *position *= 8.0;
        }
        let large = FaceLevel::new(large.mesh, large.white);
        assert!((distance_ratio(&large) - ratio).abs() < 1e-12);
        let scaled = FaceKernel::new(&large, 8.0 * kernel.deviation);
        assert_eq!(scaled.reduce(&noise(768, 1)), kernel.reduce(&noise(768, 1)));
    }
}
