//! A sample of one view becomes a fit: least squares per texel, over the numbers that displays take.

use nalgebra::{DVector, Matrix3, SymmetricEigen};
use rayon::prelude::*;

use crate::btf::direction::Direction;
use crate::btf::fits::basis::Basis;
use crate::btf::fits::fit::{Colors, Fit};
use crate::btf::fits::normal_equations::NormalEquations;
use crate::btf::fits::quantization::Quantization;
use crate::btf::sample::{Pixels, Sample};
use crate::error::{Error, Result};
use crate::format::image::encode_srgb;
use crate::progress::Progress;

/// Texels fitted by one task.
const BLOCK: usize = 4096;
/// A view further than this from directly above is worth a warning, in degrees.
const TILTED: f64 = 2.0;

/// A fit and how well it repeats its sample. Residuals are root mean squares over all lights, texels and colours, in
/// steps of 8-bit display numbers.
#[derive(Debug)]
pub struct Fitted {
    /// The fit, as a file holds it.
    pub fit: Fit,
    /// What least squares leave.
    pub residual: f64,
    /// What is left after coefficients and colours were rounded to bytes.
    pub stored_residual: f64,
}

/// Fits every texel of a sample of one view.
pub fn fit_sample(
    sample: &Sample,
    basis: Basis,
    colors: Colors,
    progress: Progress<'_>,
) -> Result<Fitted> {
    // Solve for the coefficients of every texel.
    let lights = lights_of(sample, progress)?;
    let equations = NormalEquations::new(basis, &lights)?;
    let white = match basis {
        Basis::Polynomial => 255.0,
        Basis::Hemispherical(_) => 1.0,
    };
    let solved = solve(sample, &equations, white, progress)?;
    // Round them to what the format stores.
    let fit = Fit {
        width: sample.grid().width,
        height: sample.grid().height,
        basis,
        colors,
        scale: Vec::new(),
        offset: Vec::new(),
        coefficients: Vec::new(),
        texel_colors: Vec::new(),
        white: white as f32,
    };
    let (fit, mut errors) = match colors {
        Colors::Rgb => round_colors(fit, &solved, &equations)?,
        Colors::Lrgb => round_luminance(fit, &solved, &equations)?,
    };
    // Measure both errors in steps of 8-bit values.
    errors.fitted += solved.error;
    errors.stored += solved.error;
    let count = (3 * lights.len() * sample.grid().len()) as f64;
    let steps = |error: f64| 255.0 / white * (error / count).sqrt();
    Ok(Fitted {
        fit,
        residual: steps(errors.fitted),
        stored_residual: steps(errors.stored),
    })
}

/// The light of each image; refuses samples of several views.
fn lights_of(sample: &Sample, progress: Progress<'_>) -> Result<Vec<Direction>> {
    let description = sample.description();
    if description.views.len() != 1 {
        return Err(Error::data("views", description.views.len().to_string())
            .expected("1: a fit is over lights alone"));
    }
    let tilt = description.views[0].theta().to_degrees();
    if tilt > TILTED {
        progress.warn(format!(
            "the view is {tilt:.1}° from directly above; readers of the fit take it as directly above"
        ));
    }
    let light = |image| description.lights[description.view_and_light(image).1];
    Ok((0..description.image_count()).map(light).collect())
}

/// The coefficients of smallest error of every texel and colour.
struct Solved {
    /// `[texel][colour]`, each of as many numbers as terms.
    coefficients: Vec<[DVector<f64>; 3]>,
    /// Squared error left, summed.
    error: f64,
}

fn solve(
    sample: &Sample,
    equations: &NormalEquations,
    white: f64,
    progress: Progress<'_>,
) -> Result<Solved> {
    let texels = sample.grid().len();
    let blocks: Vec<usize> = (0..texels).step_by(BLOCK).collect();
    progress.begin("fitting texels", blocks.len() as u64);
    let solved: Vec<Solved> = blocks
        .par_iter()
        .map(|&first| {
            let block = first..(first + BLOCK).min(texels);
            let solved = solve_block(sample, block, equations, white, progress)?;
            progress.advance(1)?;
            Ok(solved)
        })
        .collect::<Result<_>>()?;
    progress.end();
    let mut all = Solved {
        coefficients: Vec::with_capacity(texels),
        error: 0.0,
    };
    for block in solved {
        all.coefficients.extend(block.coefficients);
        all.error += block.error;
    }
    Ok(all)
}

fn solve_block(
    sample: &Sample,
    block: std::ops::Range<usize>,
    equations: &NormalEquations,
    white: f64,
    progress: Progress<'_>,
) -> Result<Solved> {
    let (terms, numbers) = (equations.terms, 3 * block.len());
    // Sum the products of values and basis functions over the images.
    let mut moments = vec![0.0; numbers * terms];
    let mut squares = 0.0;
    let mut pixels = Pixels::of_type(sample.description().dtype);
    for (image, at_light) in equations.at_lights.iter().enumerate() {
        progress.check()?;
        sample.read_texels(image, block.clone(), &mut pixels)?;
        for number in 0..numbers {
            let reflectance = pixels.get(number) * std::f32::consts::PI;
            let value = white * f64::from(encode_srgb(reflectance));
            squares += value * value;
            let moments = &mut moments[number * terms..][..terms];
            moments
                .iter_mut()
                .zip(at_light)
                .for_each(|(moment, term)| *moment += value * term);
        }
    }
    // Solve for the coefficients; what they explain of the squares is not left as error.
    let mut explained = 0.0;
    let mut of_number = |number: usize| {
        let moments = &moments[number * terms..][..terms];
        let found = equations.solve(moments);
        let with_moments: f64 = found.iter().zip(moments).map(|(a, b)| a * b).sum();
        explained += 2.0 * with_moments - equations.product(&found, &found);
        found
    };
    let texels = 0..block.len();
    let coefficients = texels
        .map(|texel| [0, 1, 2].map(|c| of_number(3 * texel + c)))
        .collect();
    Ok(Solved {
        coefficients,
        error: (squares - explained).max(0.0),
    })
}

/// Squared errors beyond those of the free fit.
#[derive(Default)]
struct Errors {
    fitted: f64,
    stored: f64,
}

/// Rounds three sums per texel.
fn round_colors(
    mut fit: Fit,
    solved: &Solved,
    equations: &NormalEquations,
) -> Result<(Fit, Errors)> {
    let sums: Vec<&DVector<f64>> = solved.coefficients.iter().flatten().collect();
    let quantization =
        Quantization::new(equations, &ranges(sums.iter().copied(), equations.terms))?;
    fit.coefficients = vec![0; sums.len() * equations.terms];
    let mut errors = Errors::default();
    for (sum, bytes) in sums
        .iter()
        .zip(fit.coefficients.chunks_exact_mut(equations.terms))
    {
        let difference = quantization.round(sum, bytes) - *sum;
        errors.stored += equations.product(&difference, &difference);
    }
    fit.scale = quantization.scale;
    fit.offset = quantization.offset;
    Ok((fit, errors))
}

/// Rounds a colour and one sum per texel.
fn round_luminance(
    mut fit: Fit,
    solved: &Solved,
    equations: &NormalEquations,
) -> Result<(Fit, Errors)> {
    let mut errors = Errors::default();
    let mut sums = Vec::with_capacity(solved.coefficients.len());
    for free in &solved.coefficients {
        let color = color_of(free, equations);
        errors.fitted += distance(free, color, &along(free, color), equations);
        let bytes = color.map(|part| (255.0 * part).round() as u8);
        fit.texel_colors.extend(bytes);
        sums.push(along(free, bytes.map(|byte| f64::from(byte) / 255.0)));
    }
    let quantization = Quantization::new(equations, &ranges(sums.iter(), equations.terms))?;
    fit.coefficients = vec![0; sums.len() * equations.terms];
    let colors = fit.texel_colors.chunks_exact(3);
    let bytes = fit.coefficients.chunks_exact_mut(equations.terms);
    for (((free, sum), color), bytes) in
        solved.coefficients.iter().zip(&sums).zip(colors).zip(bytes)
    {
        let stored = quantization.round(sum, bytes);
        let color = [0, 1, 2].map(|c| f64::from(color[c]) / 255.0);
        errors.stored += distance(free, color, &stored, equations);
    }
    fit.scale = quantization.scale;
    fit.offset = quantization.offset;
    Ok((fit, errors))
}

/// The colour whose multiples come nearest to a texel's three sums: the first eigenvector of their products, parts
/// from 0 to 1.
fn color_of(free: &[DVector<f64>; 3], equations: &NormalEquations) -> [f64; 3] {
    let products = Matrix3::from_fn(|a, b| equations.product(&free[a], &free[b]));
    let eigen = SymmetricEigen::new(products);
    let first = eigen.eigenvectors.column(eigen.eigenvalues.imax());
    let sign = if first.sum() < 0.0 { -1.0 } else { 1.0 };
    let parts = [0, 1, 2].map(|c| (sign * first[c]).max(0.0));
    let most = parts.iter().copied().fold(0.0, f64::max);
    match most > 0.0 {
        true => parts.map(|part| part / most),
        false => [1.0; 3],
    }
}

/// The sum that, times a colour, comes nearest to a texel's three sums.
fn along(free: &[DVector<f64>; 3], color: [f64; 3]) -> DVector<f64> {
    let square: f64 = color.iter().map(|part| part * part).sum();
    (&free[0] * color[0] + &free[1] * color[1] + &free[2] * color[2]) / square
}

/// Squared distance of a texel's three sums from one sum times a colour.
fn distance(
    free: &[DVector<f64>; 3],
    color: [f64; 3],
    sum: &DVector<f64>,
    equations: &NormalEquations,
) -> f64 {
    let of_color = |(free, part): (&DVector<f64>, f64)| {
        let difference = free - sum * part;
        equations.product(&difference, &difference)
    };
    free.iter().zip(color).map(of_color).sum()
}

/// The smallest and largest coefficient of each term.
fn ranges<'a>(sums: impl Iterator<Item = &'a DVector<f64>>, terms: usize) -> Vec<(f64, f64)> {
    let mut ranges = vec![(f64::INFINITY, f64::NEG_INFINITY); terms];
    for sum in sums {
        for ((low, high), &value) in ranges.iter_mut().zip(sum.iter()) {
            (*low, *high) = (low.min(value), high.max(value));
        }
    }
    ranges
}
