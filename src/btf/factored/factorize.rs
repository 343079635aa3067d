//! A factored sample made from any images.
//!
//! In: a source of images, and a rank or an error. Out: a sample of layout `factored`, and the error it
//! leaves. R, G and B are factored each by itself: of all factorizations with K eigentextures per
//! channel that leaves the least error in each, and it is what public factored sets hold.

use std::path::Path;

use half::f16;
use half::slice::HalfFloatSliceExt;
use ndarray::Array2;
use serde_json::{Value, json};

use crate::btf::description::{DType, Description, Layout};
use crate::btf::factored::factorization::{CHANNELS, Factorization};
use crate::btf::factored::factors::Factors;
use crate::btf::factored::image_matrix::ImageMatrix;
use crate::btf::factored::randomized_svd::{self, ChannelSvd, leading_directions};
use crate::btf::factored::residual::{Residual, measure};
use crate::btf::factored::writer::FactoredWriter;
use crate::btf::height_map::HeightMap;
use crate::btf::image_source::ImageSource;
use crate::error::{Error, Result};
use crate::progress::Progress;

/// Directions looked for beside those asked for: they take the error of the last ones.
const OVERSAMPLED: usize = 16;
/// Directions looked for first where an error is asked for.
const FIRST_COUNT: usize = 48;

/// How good the factors are to be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Accuracy {
    /// So many eigentextures per channel.
    Rank(u32),
    /// As few as leave at most this error, relative to the root mean square of all values.
    Error(f64),
}

/// Options of a factorization.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FactorOptions {
    /// How good the factors are to be.
    pub accuracy: Accuracy,
    /// Number type of the factors.
    pub dtype: DType,
    /// Seed of everything drawn at random.
    pub seed: u64,
}

impl FactorOptions {
    /// Refuses what no images of this many and so large could meet.
    pub fn validate(&self, description: &Description) -> Result<()> {
        let most = most_directions(description);
        match self.accuracy {
            Accuracy::Rank(rank) if rank == 0 || rank as usize > most => Err(Error::option(
                "rank",
                format!(
                    "{rank} for {} images of {} texels",
                    description.image_count(),
                    description.grid().len()
                ),
                format!("1 to {most}"),
            )),
            Accuracy::Error(error) if !(error > 0.0 && error < 1.0) => Err(Error::option(
                "error",
                error.to_string(),
                "above 0 and below 1: a share of the root mean square of all values",
            )),
            Accuracy::Rank(_) | Accuracy::Error(_) => Ok(()),
        }
    }

    /// Bytes that the passes take at first.
    pub fn planned_bytes(&self, source: &dyn ImageSource) -> u64 {
        let images = ImageMatrix::new(source);
        let count = self.first_count(source.description());
        images.bytes() + randomized_svd::bytes(images.rows, images.columns, count)
    }

    fn first_count(&self, description: &Description) -> usize {
        let wanted = match self.accuracy {
            Accuracy::Rank(rank) => rank as usize + rank as usize / 4 + OVERSAMPLED,
            Accuracy::Error(_) => FIRST_COUNT,
        };
        wanted.min(most_directions(description))
    }
}

/// The most directions that images can have.
fn most_directions(description: &Description) -> usize {
    description.image_count().min(description.grid().len())
}

/// Factors `source` into the sample `target`. `origin` says what the images are, for the description.
pub fn factorize(
    source: &dyn ImageSource,
    options: &FactorOptions,
    origin: Value,
    target: &Path,
    progress: Progress<'_>,
) -> Result<(Description, Residual)> {
    options.validate(source.description())?;
    let heights = source.heights()?;
    let images = ImageMatrix::new(source);
    let found = match options.accuracy {
        Accuracy::Rank(rank) => of_rank(&images, rank as usize, options, progress)?,
        Accuracy::Error(limit) => of_error(&images, limit, options, progress)?,
    };
    let description = write(
        source.description(),
        heights,
        &found,
        (options.dtype, origin),
        target,
    )?;
    Ok((description, found.residual))
}

/// Factors of every channel, and what they leave.
struct Found {
    factorization: Factorization,
    directions: [Array2<f32>; CHANNELS],
    eigentextures: [Array2<f32>; CHANNELS],
    residual: Residual,
}

fn of_rank(
    images: &ImageMatrix<'_>,
    rank: usize,
    options: &FactorOptions,
    progress: Progress<'_>,
) -> Result<Found> {
    let count = options.first_count(images.description());
    let channels = leading_directions(images, count, options.seed, progress)?;
    cut(images, &channels, rank, options.dtype, progress)
}

/// The least rank that leaves at most `limit`: as the singular values say, then as it is measured.
fn of_error(
    images: &ImageMatrix<'_>,
    limit: f64,
    options: &FactorOptions,
    progress: Progress<'_>,
) -> Result<Found> {
    let most = most_directions(images.description());
    let mut count = options.first_count(images.description());
    loop {
        let channels = leading_directions(images, count, options.seed, progress)?;
        // The last directions found are not the best ones, unless they are all there are.
        let trusted = if count == most {
            most
        } else {
            count - count / 4
        };
        let all = cut(images, &channels, trusted, DType::F4, progress)?;
        let left = Left::new(&channels, trusted, all.residual.relative);
        let mut rank = first_rank(images, &channels, &left, limit, progress)?;
        while rank <= trusted {
            let found = cut(images, &channels, rank, options.dtype, progress)?;
            let measured = found.residual.relative;
            if measured <= limit {
                return Ok(found);
            }
            let rounding = rounding(images, &channels, rank, measured, options.dtype, progress)?;
            if rounding > limit {
                return Err(out_of_reach(limit, rounding, options.dtype));
            }
            rank += 1;
        }
        if count == most {
            let least = all.residual.relative.max(limit);
            return Err(out_of_reach(limit, least, options.dtype));
        }
        count = most.min(2 * count);
    }
}

/// The rank to try first. Values below 0 become 0, which leaves less than the singular values say: by how much is
/// measured at the rank that these ask for.
fn first_rank(
    images: &ImageMatrix<'_>,
    channels: &[ChannelSvd],
    left: &Left,
    limit: f64,
    progress: Progress<'_>,
) -> Result<usize> {
    let rank = left.rank_for(limit);
    if rank > left.errors.len() {
        return Ok(rank);
    }
    let measured = cut(images, channels, rank, DType::F4, progress)?
        .residual
        .relative;
    let share = measured / left.errors[rank - 1];
    match share > 0.0 && share < 1.0 {
        true => Ok(left.rank_for(limit / share)),
        false => Ok(rank),
    }
}

/// The error that every rank leaves: what the last one does, as measured, and the singular values from there.
struct Left {
    /// Of ranks 1, 2, ….
    errors: Vec<f64>,
}

impl Left {
    fn new(channels: &[ChannelSvd], last: usize, measured: f64) -> Self {
        let total: f64 = channels.iter().map(|channel| channel.total).sum();
        let mut squares = measured * measured * total;
        let mut errors = vec![measured];
        for place in (1..last).rev() {
            let energies = channels.iter().filter_map(|c| c.energies.get(place));
            squares += energies.sum::<f64>();
            errors.push(if total > 0.0 {
                (squares / total).sqrt()
            } else {
                0.0
            });
        }
        errors.reverse();
        Self { errors }
    }

    /// The least rank that leaves at most `limit`; one more than there are where none does.
    fn rank_for(&self, limit: f64) -> usize {
        1 + self
            .errors
            .iter()
            .take_while(|&&error| error > limit)
            .count()
    }
}

/// The part of the error that the number type leaves, whatever the rank.
fn rounding(
    images: &ImageMatrix<'_>,
    channels: &[ChannelSvd],
    rank: usize,
    left: f64,
    dtype: DType,
    progress: Progress<'_>,
) -> Result<f64> {
    if dtype == DType::F4 {
        return Ok(0.0);
    }
    let exact = cut(images, channels, rank, DType::F4, progress)?;
    let exact = exact.residual.relative;
    Ok((left * left - exact * exact).max(0.0).sqrt())
}

fn out_of_reach(limit: f64, left: f64, dtype: DType) -> Error {
    let expected = match dtype {
        DType::F2 => format!("{left:.2e} or more; or --dtype f4, which rounds less"),
        DType::F4 => format!("{left:.2e} or more"),
    };
    Error::option(
        "error",
        format!("{limit} leaves nothing for rounding"),
        expected,
    )
}

/// The factors of one rank, rounded as they are stored, and the error they leave.
fn cut(
    images: &ImageMatrix<'_>,
    channels: &[ChannelSvd],
    rank: usize,
    dtype: DType,
    progress: Progress<'_>,
) -> Result<Found> {
    let factorization = Factorization::of_rank(rank as u32);
    let mut pairs = channels.iter().map(|channel| channel.leading(rank));
    let mut next = || pairs.next().unwrap_or_default().map(|m| rounded(m, dtype));
    let [[u0, e0], [u1, e1], [u2, e2]] = [next(), next(), next()];
    let (directions, eigentextures) = ([u0, u1, u2], [e0, e1, e2]);
    let factors = Factors::of_arrays(factorization, &directions, &eigentextures);
    Ok(Found {
        residual: measure(images, &factors, dtype, progress)?,
        factorization,
        directions,
        eigentextures,
    })
}

/// Numbers as a file of a type holds them.
fn rounded(mut matrix: Array2<f32>, dtype: DType) -> Array2<f32> {
    if let (DType::F2, Some(numbers)) = (dtype, matrix.as_slice_mut()) {
        let mut halves = vec![f16::ZERO; numbers.len()];
        halves.convert_from_f32_slice(numbers);
        halves.convert_to_f32_slice(numbers);
    }
    matrix
}

fn write(
    images: &Description,
    heights: Option<HeightMap>,
    found: &Found,
    (dtype, origin): (DType, Value),
    target: &Path,
) -> Result<Description> {
    let description = Description {
        dtype,
        layout: Layout::Factored(found.factorization),
        source: json!({"kind": "factored", "of": origin, "error": found.residual}),
        ..images.clone()
    };
    let mut writer = FactoredWriter::create(target, description)?;
    writer.set_heights(heights);
    for rows in &found.directions {
        writer.push_directions(rows.as_slice().unwrap_or_default())?;
    }
    for rows in &found.eigentextures {
        writer.push_eigentextures(rows.as_slice().unwrap_or_default())?;
    }
    writer.finish()
}
