//! Representative images (Tong 2002 §4): K-means over the images instead of the texels.
//!
//! In: the sample's images. Out: the numbers of the chosen ones, ascending. An image appearance
//! vector is the concatenation of an image's filter responses at the points of a regular sub-grid;
//! of each cluster the image nearest to the mean is chosen.

use std::ops::Range;

use ndarray::{Array2, ArrayViewMut2, Axis, s};
use rand::Rng;
use serde::{Deserialize, Serialize};

use crate::error::Result;
use crate::progress::Progress;
use crate::random::Stream;
use crate::texton::gram_kmeans;
use crate::texton::image_stack::ImageStack;
use crate::texton::point_filters::PointFilters;
use crate::texton::scatter_matrix::ScatterMatrix;
use crate::texton::sketch::principal;
use crate::texton::vector_kmeans;

/// How image appearance vectors are held.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
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
    /// Bytes to make some images' vectors of this many responses, where they are written as they are made.
    pub fn reading_bytes(self, components: usize) -> u64 {
        let folds = match self {
            Self::Exact => 0,
            Self::Folded => 16 * components as u64,
        };
        folds + 3 * 4 * READ_NUMBERS as u64
    }

    /// Bytes to cluster so many images of this many planes' responses.
    pub fn bytes(self, images: usize, components: usize) -> u64 {
        let (images, components) = (images as u64, components as u64);
        match self {
            Self::Exact => 4 * images * (components + images),
            Self::Folded => 3 * 4 * images * FOLDED as u64 + (256 << 20),
        }
    }
}

/// Numbers of appearance vectors, not folded, that are held at once while images are read.
const READ_NUMBERS: usize = 1 << 24;

/// Appearance vectors of images, a row each, made a few images at a time.
pub struct ImageAppearance<'a> {
    stack: &'a ImageStack<'a>,
    point_filters: PointFilters,
    /// Numbers of a vector that is not folded.
    components: usize,
    fold: Option<Fold>,
}

impl<'a> ImageAppearance<'a> {
    /// Vectors over the points of a sub-grid; how they are folded is drawn first from `random`.
    pub fn new(
        stack: &'a ImageStack<'a>,
        point_filters: PointFilters,
        held: ImageVectors,
        random: &mut Stream,
    ) -> Self {
        let components = stack.channels.count() * point_filters.components();
        let fold = match held {
            ImageVectors::Exact => None,
            ImageVectors::Folded => Some(Fold::new(components, random)),
        };
        Self {
            stack,
            point_filters,
            components,
            fold,
        }
    }

    /// Numbers of a row: C · points · 48, or folded.
    pub fn columns(&self) -> usize {
        match self.fold {
            Some(_) => FOLDED,
            None => self.components,
        }
    }

    /// The rows of some images [images, columns], a few images at a time.
    pub fn rows_of(
        &self,
        images: Range<usize>,
        progress: Progress<'_>,
    ) -> impl Iterator<Item = Result<Array2<f32>>> {
        let at_once = (READ_NUMBERS / self.components.max(1)).clamp(1, self.stack.batch());
        let starts = images.clone().step_by(at_once);
        starts.map(move |first| {
            let numbers = |first: usize| -> Vec<u32> {
                (first as u32..images.end.min(first + at_once) as u32).collect()
            };
            self.stack.announce(&numbers(first + at_once));
            let rows = self.rows(&numbers(first))?;
            progress.advance(rows.nrows() as u64)?;
            Ok(rows)
        })
    }

    fn rows(&self, images: &[u32]) -> Result<Array2<f32>> {
        let responses = self
            .point_filters
            .responses(&self.stack.read_finest(images)?);
        let mut rows = Array2::zeros((images.len(), self.columns()));
        match &self.fold {
            None => rows.iter_mut().zip(&responses).for_each(|(t, &r)| *t = r),
            Some(fold) => fold.add(&responses, rows.view_mut()),
        }
        Ok(rows)
    }

    /// The rows of all images of the stack.
    pub fn all(&self, progress: Progress<'_>) -> Result<Array2<f32>> {
        let images = self.stack.sample.image_count();
        let mut vectors = Array2::zeros((images, self.columns()));
        progress.begin("image appearance", images as u64);
        let mut first = 0;
        for rows in self.rows_of(0..images, progress) {
            let rows = rows?;
            let place = s![first..first + rows.nrows(), ..];
            vectors.slice_mut(place).assign(&rows);
            first += rows.nrows();
        }
        progress.end();
        Ok(vectors)
    }
}

/// Chooses `count` images by their appearance vectors, a row each; `random` has drawn how these are folded.
pub fn choose(
    vectors: Array2<f32>,
    held: ImageVectors,
    count: usize,
    random: &mut Stream,
    progress: Progress<'_>,
) -> Result<Vec<u32>> {
    let found = match held {
        ImageVectors::Exact => {
            let mut products = ScatterMatrix::new(vectors.nrows());
            products.add(vectors.t(), progress);
            drop(vectors);
            let gram = products.finish(progress)?;
            gram_kmeans::cluster(gram.view(), count, MAX_ITERATIONS, random, progress)?
        }
        ImageVectors::Folded => {
            let vectors = principal(vectors, progress)?;
            vector_kmeans::cluster(vectors.view(), count, MAX_ITERATIONS, random, progress)?
        }
    };
    let mut chosen = found.nearest;
    chosen.sort_unstable();
    Ok(chosen)
}

/// Lloyd steps over the images; representatives need no fixed point.
const MAX_ITERATIONS: u32 = 100;

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
