//! The error that factors leave.
//!
//! In: images and factors. Out: root mean squares of the difference of every value as it is read from
//! the factors, over all values, in the worst image and at the worst texel; each over the root mean square
//! of all values of the images, so that the three compare.

use rayon::prelude::*;
use serde::Serialize;

use crate::btf::description::DType;
use crate::btf::factored::factorization::CHANNELS;
use crate::btf::factored::factors::Factors;
use crate::btf::factored::image_matrix::ImageMatrix;
use crate::btf::factored::products::Values;
use crate::btf::sample::Pixels;
use crate::error::Result;
use crate::progress::Progress;

/// Images expanded at once by one task.
const GROUP: usize = 8;
/// Texels whose sums one task adds to.
const TEXELS: usize = 1 << 12;

/// What is left, relative to the root mean square of all values.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Residual {
    /// Of all values: the Frobenius norm of the difference over that of the images.
    pub relative: f64,
    /// The image with the largest error; of equally large ones the first.
    pub worst_image: usize,
    /// Its error.
    pub worst_image_error: f64,
    /// The texel with the largest error, row · width + column; of equally large ones the first.
    pub worst_texel: usize,
    /// Its error.
    pub worst_texel_error: f64,
}

/// Reads all images and compares them with what the factors give, read as numbers of a type.
pub fn measure(
    images: &ImageMatrix<'_>,
    factors: &Factors,
    dtype: DType,
    progress: Progress<'_>,
) -> Result<Residual> {
    let mut total = 0.0;
    let mut of_images = Vec::with_capacity(images.rows);
    let mut of_texels = vec![0.0; images.columns];
    images.each_as_read("measuring the error", progress, |panel, numbers| {
        let squares: Vec<f64> = numbers
            .par_chunks(CHANNELS * images.columns)
            .map(|image| image.iter().map(|&v| f64::from(v) * f64::from(v)).sum())
            .collect();
        total += squares.iter().sum::<f64>();
        let differences = squared_differences(panel.start, numbers, factors, dtype);
        let each: Vec<f64> = differences
            .par_chunks(images.columns)
            .map(|image| image.iter().map(|&v| f64::from(v)).sum())
            .collect();
        of_images.extend(each);
        add_by_texel(&differences, &mut of_texels);
    })?;
    Ok(summary(total, &of_images, &of_texels))
}

/// Squared differences of images, summed over the channels: [images, texels].
fn squared_differences(first: usize, numbers: &[f32], factors: &Factors, dtype: DType) -> Vec<f32> {
    let [_, texels] = factors.sides();
    let mut differences = vec![0.0; numbers.len() / CHANNELS];
    differences
        .par_chunks_mut(GROUP * texels)
        .zip(numbers.par_chunks(GROUP * CHANNELS * texels))
        .enumerate()
        .for_each(|(group, (differences, numbers))| {
            let from = first + group * GROUP;
            let images = from..from + differences.len() / texels;
            let images: Vec<u32> = images.map(|image| image as u32).collect();
            let mut products = vec![0.0; numbers.len()];
            factors.multiply(&images, 0..texels, Values::Radiance, &mut products);
            let mut stored = Pixels::of_type(dtype);
            stored.assign(&products);
            stored.copy_to(&mut products);
            let pairs = numbers
                .chunks_exact(CHANNELS)
                .zip(products.chunks_exact(CHANNELS));
            for (difference, (wanted, found)) in differences.iter_mut().zip(pairs) {
                let squares = wanted.iter().zip(found).map(|(a, b)| (a - b) * (a - b));
                *difference = squares.sum();
            }
        });
    differences
}

/// Adds every image's numbers, image after image.
fn add_by_texel(differences: &[f32], sums: &mut [f64]) {
    let texels = sums.len();
    sums.par_chunks_mut(TEXELS)
        .enumerate()
        .for_each(|(part, sums)| {
            for image in differences.chunks_exact(texels) {
                let numbers = &image[part * TEXELS..];
                sums.iter_mut()
                    .zip(numbers)
                    .for_each(|(sum, &v)| *sum += f64::from(v));
            }
        });
}

fn summary(total: f64, of_images: &[f64], of_texels: &[f64]) -> Residual {
    let (images, texels) = (of_images.len() as f64, of_texels.len() as f64);
    let relative = |squares: f64, share: f64| match total > 0.0 {
        true => (squares / (total * share)).sqrt(),
        false => 0.0,
    };
    let (worst_image, image_squares) = largest(of_images);
    let (worst_texel, texel_squares) = largest(of_texels);
    Residual {
        relative: relative(of_images.iter().sum(), 1.0),
        worst_image,
        worst_image_error: relative(image_squares, 1.0 / images),
        worst_texel,
        worst_texel_error: relative(texel_squares, 1.0 / texels),
    }
}

/// The first of the largest numbers, and its place.
fn largest(numbers: &[f64]) -> (usize, f64) {
    let mut best = (0, 0.0);
    for (at, &number) in numbers.iter().enumerate() {
        if number > best.1 {
            best = (at, number);
        }
    }
    best
}
