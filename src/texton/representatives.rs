//! Representative images (Tong 2002 §4): K-means over the images instead of the texels.
//!
//! In: the sample's images. Out: the numbers of the chosen ones, ascending. An image appearance
//! vector is the concatenation of an image's filter responses at the points of a regular sub-grid;
//! of each cluster the image nearest to the mean is chosen.

use ndarray::{Array2, ArrayViewMut2, Axis};
use rand::Rng;

use crate::error::Result;
use crate::progress::Progress;
use crate::random::Stream;
use crate::texton::gram_kmeans;
use crate::texton::image_stack::ImageStack;
use crate::texton::outer_products::OuterProducts;
use crate::texton::sketch::principal;
use crate::texton::sub_grid::SubGrid;
use crate::texton::vector_kmeans;

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

/// Chooses `count` of the stack's images.
pub fn choose(
    stack: &ImageStack<'_>,
    sub_grid: &SubGrid,
    count: usize,
    held: ImageVectors,
    random: &mut Stream,
    progress: Progress<'_>,
) -> Result<Vec<u32>> {
    let vectors = image_vectors(stack, sub_grid, held, random, progress)?;
    let found = match held {
        ImageVectors::Exact => {
            let mut products = OuterProducts::new(vectors.nrows());
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

/// Image appearance vectors [images, C · points · 48], or folded.
fn image_vectors(
    stack: &ImageStack<'_>,
    sub_grid: &SubGrid,
    held: ImageVectors,
    random: &mut Stream,
    progress: Progress<'_>,
) -> Result<Array2<f32>> {
    let images = stack.sample.image_count();
    let components = stack.channels.count() * sub_grid.components();
    let fold = match held {
        ImageVectors::Exact => None,
        ImageVectors::Folded => Some(Fold::new(components, random)),
    };
    let columns = if fold.is_some() { FOLDED } else { components };
    let mut vectors = Array2::zeros((images, columns));
    let numbers: Vec<u32> = (0..images as u32).collect();
    progress.begin("image appearance", images as u64);
    let targets = vectors.axis_chunks_iter_mut(Axis(0), stack.panel());
    for (numbers, mut target) in numbers.chunks(stack.panel()).zip(targets) {
        let responses = sub_grid.responses(&stack.read_finest(numbers)?);
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
