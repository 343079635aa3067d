//! The factors of a DFMF or FMF file, copied into a factored sample.
//!
//! Reflectance becomes radiance by the colour step alone: T and m are multiplied by 1/π, and all factors stay as they
//! are, bit for bit where the number type does. Where the file has the cosine divided out, the rows of U are
//! multiplied by it; a colour mean then becomes one more component, whose eigentextures are constant.

use std::path::Path;

use glam::{DMat3, DVec3};

use crate::btf::bonn::factors::{Channel, Factors};
use crate::btf::bonn::matrix::MatrixRows;
use crate::btf::description::{Description, Layout};
use crate::btf::factored::factorization::Factorization;
use crate::btf::factored::writer::FactoredWriter;
use crate::btf::height_map::HeightMap;
use crate::error::{Error, Result};
use crate::progress::Progress;

/// Numbers copied at a time.
const BLOCK: usize = 1 << 20;

/// Factors to be copied.
pub(super) struct FactorCopy<'a> {
    pub(super) factors: &'a Factors,
    /// The sample's value of a white plane facing the light, over the file's.
    pub(super) white: f64,
    /// The cosine of each light, where values are to be multiplied by it.
    pub(super) cosines: Option<&'a [f32]>,
    /// How high each texel lies, if the file states it.
    pub(super) heights: Option<HeightMap>,
    pub(super) progress: Progress<'a>,
}

/// What rows are copied with.
struct Rows {
    /// Numbers of a row.
    rank: usize,
    /// The mean of each channel, where it is the last component.
    means: Option<DVec3>,
    /// What the description states about them.
    factorization: Factorization,
}

impl FactorCopy<'_> {
    /// Writes the sample.
    pub(super) fn write(mut self, description: Description, target: &Path) -> Result<Description> {
        let rows = self.rows()?;
        let shared = rows.factorization.shared_eigentextures;
        let description = Description {
            layout: Layout::Factored(rows.factorization),
            ..description
        };
        description
            .check()
            .map_err(|error| error.advice("--expand writes the images instead"))?;
        let (images, texels) = (description.image_count(), description.grid().len());
        let rgb = self.factors.rgb;
        let sets = if shared { 1 } else { rgb.len() };
        let mut writer = FactoredWriter::create(target, description)?;
        writer.set_heights(self.heights.take());
        self.progress
            .begin("copying factors", (3 * images + sets * texels) as u64);
        for (at, &channel) in rgb.iter().enumerate() {
            let channel = &self.factors.channels[channel];
            self.copy_directions(channel, &rows, &mut writer)?;
            if at < sets {
                self.copy_eigentextures(channel, at, &rows, &mut writer)?;
            }
        }
        self.progress.end();
        writer.finish()
    }

    /// How rows and colours are copied.
    fn rows(&self) -> Result<Rows> {
        let factors = self.factors;
        let Some((matrix, mean)) = factors.color.linear() else {
            let model = factors.color.model.name();
            return Err(Error::data("color_model", model).expected("a linear one"));
        };
        let has_own_mean = self.cosines.is_some() && mean != DVec3::ZERO;
        let rank = factors.rank() + usize::from(has_own_mean);
        let (means, mean) = match has_own_mean {
            true => (Some(mean_in_channels(matrix, mean)?), DVec3::ZERO),
            false => (None, mean * self.white),
        };
        let factorization = Factorization {
            rank: rank as u32,
            shared_eigentextures: factors.shares_eigentextures() && !has_own_mean,
            color_transform: (matrix * self.white).transpose().to_cols_array(),
            color_mean: mean.to_array(),
        };
        Ok(Rows {
            rank,
            means,
            factorization,
        })
    }

    /// Rows of U, each with a number for the mean where that is a component.
    fn copy_directions(
        &self,
        channel: &Channel,
        rows: &Rows,
        writer: &mut FactoredWriter,
    ) -> Result<()> {
        self.each_block(&*channel.directions, rows.rank, |first, block| {
            for (image, row) in block.chunks_mut(rows.rank).enumerate() {
                if rows.means.is_some() {
                    row[rows.rank - 1] = 1.0;
                }
                if let Some(cosines) = self.cosines {
                    let cosine = cosines[(first + image) % cosines.len()];
                    row.iter_mut().for_each(|number| *number *= cosine);
                }
            }
            writer.push_directions(block)
        })
    }

    /// Rows of eigentextures, each with the channel's mean where that is a component.
    fn copy_eigentextures(
        &self,
        channel: &Channel,
        at: usize,
        rows: &Rows,
        writer: &mut FactoredWriter,
    ) -> Result<()> {
        self.each_block(&*channel.eigentextures, rows.rank, |_, block| {
            if let Some(means) = rows.means {
                let last = block.iter_mut().skip(rows.rank - 1).step_by(rows.rank);
                last.for_each(|number| *number = means[at] as f32);
            }
            writer.push_eigentextures(block)
        })
    }

    /// Calls `take` with runs of rows, filled up with 0 to `rank` numbers, and the first row's place.
    fn each_block(
        &self,
        matrix: &dyn MatrixRows,
        rank: usize,
        mut take: impl FnMut(usize, &mut [f32]) -> Result<()>,
    ) -> Result<()> {
        let each = (BLOCK / rank).max(1);
        let mut numbers = Vec::new();
        for start in (0..matrix.rows()).step_by(each) {
            let rows = start..matrix.rows().min(start + each);
            let count = rows.len();
            numbers.resize(count * matrix.columns(), 0.0);
            matrix.read(rows, &mut numbers)?;
            let mut wide = widened(&numbers, matrix.columns(), rank);
            take(start, &mut wide)?;
            self.progress.advance(count as u64)?;
        }
        Ok(())
    }
}

/// The channels whose colour is the mean.
fn mean_in_channels(matrix: DMat3, mean: DVec3) -> Result<DVec3> {
    let inverse = matrix.inverse();
    match inverse.is_finite() {
        true => Ok(inverse * mean),
        false => Err(
            Error::data("color transformation", "a matrix without inverse")
                .expected("an invertible one, because the cosine has to be put into the mean too")
                .advice("--expand writes the images instead"),
        ),
    }
}

/// Rows of `own` numbers, filled up with 0 to `rank`.
fn widened(numbers: &[f32], own: usize, rank: usize) -> Vec<f32> {
    if own == rank {
        return numbers.to_vec();
    }
    let mut wide = vec![0.0; numbers.len() / own * rank];
    let pairs = wide.chunks_mut(rank).zip(numbers.chunks(own));
    pairs.for_each(|(wide, row)| wide[..own].copy_from_slice(row));
    wide
}
