//! FMF: one pair of factors for red, green and blue together.
//!
//! Body: with an extra header u8 version; from 1 on u32 dynamic range reduction; from 2 on u32 width, u32 height and
//! as many halves of a height map. Then u32 components, u8 scalar size, u32 components, u32 rows of U, u32 rows of
//! SxV, S, U and SxV, row-major. The rows of U are (image, channel), channel fastest, and those of SxV the texels; or
//! those of U are (texel, channel) and those of SxV the images.

use std::sync::Arc;

use ndarray::Array2;

use crate::btf::bonn::color::{Color, ColorModel};
use crate::btf::bonn::dfmf::read_matrices;
use crate::btf::bonn::factors::{Channel, Factors};
use crate::btf::bonn::fields::Fields;
use crate::btf::bonn::header::Header;
use crate::btf::bonn::matrix::{EveryNth, MatrixRows};
use crate::btf::bonn::output::Output;
use crate::btf::bonn::scalar::Scalar;
use crate::btf::bonn::singular_values::singular_values;
use crate::error::{Error, Result};

/// What an extra header may say.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ExtraHeader {
    /// 0: values as they are; any other: their logarithms.
    pub dynamic_range_reduction: u32,
    /// Heights in millimetres above their mean, row-major, and the number of columns.
    pub height_map: Option<(Vec<f32>, u32)>,
}

/// Reads what follows the header; the matrices stay in the file.
pub(super) fn read(
    fields: &mut Fields,
    header: &Header,
    has_extra_header: bool,
) -> Result<(Factors, ExtraHeader)> {
    let rgb = header.meta.rgb_channels()?;
    let extra = match has_extra_header {
        true => read_extra(fields)?,
        false => ExtraHeader::default(),
    };
    let most = fields.u32("number of components")?;
    let scalar = Scalar::of_size("factors", fields.u8("scalar size")?)?;
    let matrices = read_matrices(fields, "factors", scalar, most)?;
    fields.end()?;
    let channels = channels_of(matrices, header)?;
    let factors = Factors {
        channels,
        color: Color::of(ColorModel::Rgb),
        logarithmic: extra.dynamic_range_reduction != 0,
        rgb,
    };
    Ok((factors, extra))
}

fn read_extra(fields: &mut Fields) -> Result<ExtraHeader> {
    let version = fields.u8("version of the extra header")?;
    if version > 2 {
        return Err(
            Error::data("version of the extra header", version.to_string()).expected("0, 1 or 2"),
        );
    }
    let mut extra = ExtraHeader::default();
    if version >= 1 {
        extra.dynamic_range_reduction = fields.u32("dynamic range reduction")?;
    }
    if version >= 2 {
        let sides = [
            fields.u32("width of the height map")?,
            fields.u32("height of the height map")?,
        ];
        let texels = u64::from(sides[0]) * u64::from(sides[1]);
        if texels > 0 {
            let bytes = fields.bytes("height map", texels.saturating_mul(2))?;
            let mut heights = vec![0.0; texels as usize];
            Scalar::Half.decode(&bytes, &mut heights);
            check_heights(&heights)?;
            level(&mut heights);
            extra.height_map = Some((heights, sides[0]));
        }
    }
    Ok(extra)
}

/// Moves heights so that their mean is 0: images are rectified on the plane of the mean height.
fn level(heights: &mut [f32]) {
    let sum: f64 = heights.iter().map(|&height| f64::from(height)).sum();
    let mean = sum / heights.len() as f64;
    for height in heights {
        *height = (f64::from(*height) - mean) as f32;
    }
}

fn check_heights(heights: &[f32]) -> Result<()> {
    match heights.iter().position(|height| !height.is_finite()) {
        None => Ok(()),
        Some(at) => Err(
            Error::data(format!("height map, number {at}"), heights[at].to_string())
                .expected("a finite number"),
        ),
    }
}

/// One channel for each colour, taken from the interleaved rows of U.
fn channels_of(
    [left, right]: [Arc<crate::btf::bonn::matrix::StoredMatrix>; 2],
    header: &Header,
) -> Result<Vec<Channel>> {
    let count = header.meta.channels.len();
    let (images, texels) = (header.sampling.images(), header.texels());
    let rows = [left.rows(), right.rows()];
    // Tell by the rows which factor holds the directions.
    let transposed = match rows {
        [l, r] if Some(l) == images.checked_mul(count) && r == texels => false,
        [l, r] if Some(l) == texels.checked_mul(count) && r == images => true,
        [l, r] => {
            return Err(
                Error::data("factors: rows of U and of SxV", format!("{l} and {r}")).expected(
                    format!(
                        "{count} × {images} and {texels}, or {count} × {texels} and {images} ({count} channels, \
                         {images} images, {texels} texels)"
                    ),
                ),
            );
        }
    };
    let shared: Arc<dyn MatrixRows> = right;
    // Take every n-th row of the interleaved factor per channel; all share the other.
    let channel = |first| {
        let own = Arc::new(EveryNth {
            matrix: Arc::clone(&left),
            step: count,
            first,
        });
        match transposed {
            false => Channel {
                directions: own,
                eigentextures: Arc::clone(&shared),
            },
            true => Channel {
                directions: Arc::clone(&shared),
                eigentextures: own,
            },
        }
    };
    Ok((0..count).map(channel).collect())
}

/// What an FMF file is written from.
pub struct FmfContent<'a> {
    /// All that precedes the body.
    pub header: &'a Header,
    /// The extra header, and its version from 0 to 2, where the signature has one.
    pub extra: Option<(u8, &'a ExtraHeader)>,
    /// U: rows (image, channel), or (texel, channel).
    pub left: &'a Array2<f32>,
    /// SxV: rows of texels, or images.
    pub right: &'a dyn MatrixRows,
    /// The number type of the factors.
    pub scalar: Scalar,
}

impl FmfContent<'_> {
    pub(super) fn write(&self, output: &mut Output<'_>) -> Result<()> {
        if let Some((version, extra)) = self.extra {
            write_extra(output, version, extra)?;
        }
        let rank = self.left.ncols();
        output.u32(rank)?;
        output.u8(self.scalar.size() as u8)?;
        output.u32(rank)?;
        output.u32(self.left.nrows())?;
        output.u32(self.right.rows())?;
        let values = singular_values(self.right)?;
        output.scalars(self.scalar, "S", &values)?;
        output.matrix(self.scalar, "U", self.left)?;
        output.matrix(self.scalar, "SxV", self.right)
    }
}

fn write_extra(output: &mut Output<'_>, version: u8, extra: &ExtraHeader) -> Result<()> {
    output.u8(version)?;
    if version >= 1 {
        output.u32(extra.dynamic_range_reduction as usize)?;
    }
    if version >= 2 {
        let (heights, width) = match &extra.height_map {
            Some((heights, width)) => (&heights[..], *width as usize),
            None => (&[][..], 0),
        };
        output.u32(width)?;
        output.u32(heights.len() / width.max(1))?;
        output.scalars(Scalar::Half, "height map", heights)?;
    }
    Ok(())
}
