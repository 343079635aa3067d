//! Representative images (Tong 2002 §4): K-means over the images instead of the texels.
//!
//! In: the sample's images. Out: the numbers of the chosen ones, ascending. An image appearance
//! vector is the concatenation of an image's filter responses at the points of a regular sub-grid;
//! of each cluster the image nearest to the mean is chosen.

use ndarray::{Array2, Array3, ArrayView2, ArrayViewMut2, Axis, s};
use rand::Rng;
use rayon::prelude::*;

use crate::error::Result;
use crate::progress::Progress;
use crate::random::Stream;
use crate::texton::basis::{AxisBasis, PARITIES, PLANE_PARITIES, Parity, PlaneBasis, Transfer};
use crate::texton::filter_bank::FILTERS;
use crate::texton::gram_kmeans;
use crate::texton::image_stack::ImageStack;
use crate::texton::matrix::{Target, as_rows, multiply};
use crate::texton::outer_products::OuterProducts;
use crate::texton::sketch::principal;
use crate::texton::vector_kmeans;

/// Planes that one task filters.
const BLOCK: usize = 64;

/// Responses at the points of a regular sub-grid, straight from coefficients.
pub struct SubGridFilters<'a> {
    basis: &'a PlaneBasis,
    rows: Vec<usize>,
    cols: Vec<usize>,
    /// For parity y and wave ky: [kx, col · 48 + filter], Σ_px d S_px.
    along_x: Vec<Vec<Array2<f32>>>,
}

impl<'a> SubGridFilters<'a> {
    /// At most `points` rows and columns, evenly spread.
    pub fn new(basis: &'a PlaneBasis, transfer: &Transfer, points: usize) -> Self {
        let (height, width) = basis.sides();
        let (rows, cols) = (spread(height, points), spread(width, points));
        let along_x = PARITIES
            .into_iter()
            .map(|parity| {
                (0..height)
                    .into_par_iter()
                    .map(|wave_y| along_x(basis, transfer, parity, wave_y, &cols))
                    .collect()
            })
            .collect();
        Self {
            basis,
            rows,
            cols,
            along_x,
        }
    }

    /// Numbers of one plane's responses.
    pub fn components(&self) -> usize {
        self.rows.len() * self.cols.len() * FILTERS
    }

    /// The texels of the sub-grid, row by row.
    pub fn points(&self) -> Vec<usize> {
        let width = self.basis.sides().1;
        let of_row = |&row: &usize| self.cols.iter().map(move |&col| row * width + col);
        self.rows.iter().flat_map(of_row).collect()
    }

    /// Responses [planes, row · cols · 48 + col · 48 + filter] of coefficients [planes, waves].
    pub fn responses(&self, planes: ArrayView2<'_, f32>) -> Array2<f32> {
        let mut out = Array2::zeros((planes.nrows(), self.components()));
        out.axis_chunks_iter_mut(Axis(0), BLOCK)
            .into_par_iter()
            .zip(planes.axis_chunks_iter(Axis(0), BLOCK))
            .for_each(|(out, planes)| self.filter_block(planes, out));
        out
    }

    fn filter_block(&self, planes: ArrayView2<'_, f32>, mut out: ArrayViewMut2<'_, f32>) {
        let (height, width) = self.basis.sides();
        let line = self.cols.len() * FILTERS;
        let mut lines = Array3::<f32>::zeros((planes.nrows(), height, line));
        for (parity, along_x) in PARITIES.into_iter().zip(&self.along_x) {
            for (wave_y, filters) in along_x.iter().enumerate() {
                let waves = planes.slice(s![.., wave_y * width..(wave_y + 1) * width]);
                let target = lines.slice_mut(s![.., wave_y, ..]);
                multiply(waves, filters.view(), target, Target::Replace);
            }
            let along_y = self.basis.y.synthesis(parity).select(Axis(0), &self.rows);
            for (lines, mut out) in lines.outer_iter().zip(out.outer_iter_mut()) {
                let Some(out) = out.as_slice_mut() else {
                    continue;
                };
                let target = crate::texton::matrix::as_rows_mut(out, self.rows.len(), line);
                multiply(along_y.view(), lines, target, Target::Add);
            }
        }
    }
}

fn along_x(
    basis: &PlaneBasis,
    transfer: &Transfer,
    parity_y: Parity,
    wave_y: usize,
    cols: &[usize],
) -> Array2<f32> {
    let width = basis.sides().1;
    let mut filters = Array2::zeros((width, cols.len() * FILTERS));
    for (p, [py, px]) in PLANE_PARITIES.into_iter().enumerate() {
        if py != parity_y {
            continue;
        }
        let (waves, factors) = (synthesis_at(&basis.x, px, cols), transfer.factors(p));
        for ((kx, at), target) in filters.indexed_iter_mut() {
            let (col, filter) = (at / FILTERS, at % FILTERS);
            *target += waves[[col, kx]] * factors[[filter, wave_y * width + kx]];
        }
    }
    filters
}

fn synthesis_at(axis: &AxisBasis, parity: Parity, points: &[usize]) -> Array2<f32> {
    axis.synthesis(parity).select(Axis(0), points)
}

/// The middles of `points` equal parts of a side.
fn spread(side: usize, points: usize) -> Vec<usize> {
    let points = points.min(side);
    (0..points)
        .map(|i| (2 * i + 1) * side / (2 * points))
        .collect()
}

/// How image appearance vectors are held.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ImageVectors {
    /// In full, and clustered through all pairs of dot products.
    Exact,
    /// Folded to [`FOLDED`] numbers by random signs (Charikar and others 2002, count sketch), and
    /// clustered as vectors: for samples of more images than memory has room for.
    Folded,
}

/// Numbers of a folded image appearance vector.
pub const FOLDED: usize = 512;

impl ImageVectors {
    /// Bytes to cluster so many images of so many planes' responses.
    pub fn bytes(self, images: usize, components: usize) -> u64 {
        let (images, components) = (images as u64, components as u64);
        match self {
            Self::Exact => 4 * images * (components + images),
            Self::Folded => 3 * 4 * images * FOLDED as u64 + (256 << 20),
        }
    }
}

/// Chooses `count` of the stack's images; `panel` images are read at once.
pub fn choose(
    stack: &ImageStack<'_>,
    basis: &PlaneBasis,
    filters: &SubGridFilters<'_>,
    count: usize,
    (panel, held): (usize, ImageVectors),
    random: &mut Stream,
    progress: Progress<'_>,
) -> Result<Vec<u32>> {
    let vectors = image_vectors(stack, basis, filters, (panel, held), random, progress)?;
    let found = match held {
        ImageVectors::Exact => {
            let mut products = OuterProducts::new(vectors.nrows());
            products.add(vectors.t());
            drop(vectors);
            let gram = products.finish();
            gram_kmeans::cluster(gram.view(), count, MAX_ITERATIONS, random, progress)?
        }
        ImageVectors::Folded => {
            let vectors = principal(vectors);
            vector_kmeans::cluster(vectors.view(), count, MAX_ITERATIONS, random, progress)?
        }
    };
    let mut chosen = found.nearest;
    chosen.sort_unstable();
    Ok(chosen)
}

/// Lloyd steps over the images; representatives need no fixed point.
const MAX_ITERATIONS: u32 = 100;

/// Image appearance vectors [images, C · points · 48], or folded.
fn image_vectors(
    stack: &ImageStack<'_>,
    basis: &PlaneBasis,
    filters: &SubGridFilters<'_>,
    (panel, held): (usize, ImageVectors),
    random: &mut Stream,
    progress: Progress<'_>,
) -> Result<Array2<f32>> {
    let (images, channels) = (stack.sample.image_count(), stack.channels.count());
    let components = channels * filters.components();
    let fold = match held {
        ImageVectors::Exact => None,
        ImageVectors::Folded => Some(Fold::new(components, random)),
    };
    let columns = if fold.is_some() { FOLDED } else { components };
    let mut vectors = Array2::zeros((images, columns));
    let numbers: Vec<u32> = (0..images as u32).collect();
    progress.begin("image appearance", images as u64);
    let targets = vectors.axis_chunks_iter_mut(Axis(0), panel);
    for (numbers, mut target) in numbers.chunks(panel).zip(targets) {
        let mut planes = stack.read_finest(numbers)?;
        basis.analyze(&mut planes);
        let planes = as_rows(&planes, numbers.len() * channels, basis.grid.len());
        let responses = filters.responses(planes);
        match &fold {
            None => target.iter_mut().zip(&responses).for_each(|(t, &r)| *t = r),
            Some(fold) => fold.add(&responses, target),
        }
        progress.advance(numbers.len() as u64)?;
    }
    progress.end();
    Ok(vectors)
}

/// Adds every component, with a random sign, to one of few numbers.
struct Fold {
    /// Place and sign of each component.
    places: Vec<(usize, f32)>,
}

impl Fold {
    fn new(components: usize, random: &mut Stream) -> Self {
        let place = |_| {
            let sign = if random.r#gen() { 1.0 } else { -1.0 };
            (random.gen_range(0..FOLDED), sign)
        };
        Self {
            places: (0..components).map(place).collect(),
        }
    }

    /// Adds the responses of images' planes, plane after plane.
    fn add(&self, responses: &Array2<f32>, mut target: ArrayViewMut2<'_, f32>) {
        let channels = responses.nrows() / target.nrows().max(1);
        for (responses, mut target) in responses
            .axis_chunks_iter(Axis(0), channels)
            .zip(target.outer_iter_mut())
        {
            for (&(place, sign), value) in self.places.iter().zip(&responses) {
                target[place] += sign * value;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::TexelGrid;
    use crate::texton::filter_bank::leung_malik;
    use crate::texton::oracle;

    #[test]
    fn sub_grid_responses_are_those_of_the_whole_image() {
        let bank = leung_malik();
        for tileable in [true, false] {
            let grid = TexelGrid {
                width: 11,
                height: 8,
                tileable,
            };
            let plane: Vec<f32> = (0..88).map(|i| ((i * 37) % 41) as f32).collect();
            let basis = PlaneBasis::new(grid);
            let transfer = basis.transfer(&bank);
            let filters = SubGridFilters::new(&basis, &transfer, 3);
            assert_eq!(
                (filters.rows.as_slice(), filters.cols.as_slice()),
                (&[1, 4, 6][..], &[1, 5, 9][..])
            );
            let mut coefficients = plane.clone();
            basis.analyze(&mut coefficients);
            let fast = filters.responses(as_rows(&coefficients, 1, 88));
            let slow = oracle::responses(grid, &bank, &plane);
            for (r, &row) in filters.rows.iter().enumerate() {
                for (c, &col) in filters.cols.iter().enumerate() {
                    for filter in 0..FILTERS {
                        let a = fast[[0, (r * 3 + c) * FILTERS + filter]];
                        let b = slow[[filter, row * 11 + col]];
                        assert!((f64::from(a) - b).abs() < 1e-4, "{a} against {b}");
                    }
                }
            }
        }
    }
}
