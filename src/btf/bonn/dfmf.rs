//! DFMF: the channels of a colour model, each with factors of its own.
//!
//! Body: u32 components, i32 colour model, f32\[3\] mean, f32\[9\] matrix; per channel u8 scalar size, u32 components,
//! u32 rows of U, u32 rows of SxV, then S, U and SxV, row-major. The rows of U are the images and those of SxV the
//! texels, or the other way round.

use std::sync::Arc;

use crate::btf::bonn::color::{Color, ColorModel};
use crate::btf::bonn::factors::{Channel, Factors};
use crate::btf::bonn::fields::Fields;
use crate::btf::bonn::header::Header;
use crate::btf::bonn::matrix::{MatrixRows, Sides, StoredMatrix};
use crate::btf::bonn::output::Output;
use crate::btf::bonn::scalar::Scalar;
use crate::btf::bonn::singular_values::singular_values;
use crate::error::{Error, Result};

/// Reads what follows the header; the matrices stay in the file.
pub(super) fn read(fields: &mut Fields, header: &Header) -> Result<Factors> {
    let rgb = header.meta.rgb_channels()?;
    fields.u32("number of components")?;
    let color = Color {
        model: ColorModel::of_number(fields.i32("color model")?)?,
        mean: fields.float_array("color mean")?,
        transform: fields.float_array("color transformation")?,
    };
    if rgb == [0; 3] && color.model != ColorModel::Rgb {
        return Err(Error::data("channels", "1")
            .expected(format!("3 for the colour model {}", color.model.name())));
    }
    let sides = [header.sampling.images(), header.texels()];
    let channel = |channel| read_channel(fields, channel, sides);
    let channels = (0..header.meta.channels.len())
        .map(channel)
        .collect::<Result<_>>()?;
    fields.end()?;
    Ok(Factors {
        channels,
        color,
        logarithmic: false,
        rgb,
    })
}

fn read_channel(fields: &mut Fields, channel: usize, sides: [usize; 2]) -> Result<Channel> {
    let place = format!("channel {channel}");
    let scalar = Scalar::of_size(&place, fields.u8(&place)?)?;
    let matrices = read_matrices(fields, &place, scalar, u32::MAX)?;
    Channel::of_either(&place, matrices.map(|m| m as Arc<dyn MatrixRows>), sides)
}

/// The matrices U and SxV, after the number of their components, at most `most` of which count, and their rows.
pub(super) fn read_matrices(
    fields: &mut Fields,
    place: &str,
    scalar: Scalar,
    most: u32,
) -> Result<[Arc<StoredMatrix>; 2]> {
    let stored = fields.u32(&format!("{place}: components"))?;
    let columns = stored.min(most);
    if columns == 0 {
        return Err(Error::data(format!("{place}: components"), "0").expected("at least 1"));
    }
    let rows = [
        fields.u32(&format!("{place}: rows of U"))?,
        fields.u32(&format!("{place}: rows of SxV"))?,
    ];
    let values = format!("{place}: S");
    fields.pass(&values, Some(stored.into()), scalar.size() as u64)?;
    let mut next = |name: &str, rows| {
        let sides = Sides {
            rows,
            stored,
            columns,
            scalar,
        };
        StoredMatrix::next(fields, format!("{place}: {name}"), sides).map(Arc::new)
    };
    Ok([next("U", rows[0])?, next("SxV", rows[1])?])
}

/// What a DFMF file is written from.
pub struct DfmfContent<'a> {
    /// All that precedes the body.
    pub header: &'a Header,
    /// What the channels stand for.
    pub color: Color,
    /// The factors of each channel.
    pub channels: &'a [Channel],
    /// The number type of the factors.
    pub scalar: Scalar,
    /// Whether the eigentextures come first, as U.
    pub transposed: bool,
}

impl DfmfContent<'_> {
    pub(super) fn write(&self, output: &mut Output<'_>) -> Result<()> {
        let rank = self.channels.iter().map(Channel::rank).max();
        output.u32(rank.unwrap_or(0))?;
        output.bytes(&self.color.model.number().to_le_bytes())?;
        output.floats(&self.color.mean)?;
        output.floats(&self.color.transform)?;
        for (at, channel) in self.channels.iter().enumerate() {
            output.u8(self.scalar.size() as u8)?;
            let place = format!("channel {at}");
            write_matrices(output, &place, channel, self.scalar, self.transposed)?;
        }
        Ok(())
    }
}

/// Writes the number of components, the rows and the three matrices of a channel.
pub(super) fn write_matrices(
    output: &mut Output<'_>,
    place: &str,
    channel: &Channel,
    scalar: Scalar,
    transposed: bool,
) -> Result<()> {
    let mut matrices = [&*channel.directions, &*channel.eigentextures];
    if transposed {
        matrices.reverse();
    }
    output.u32(channel.rank())?;
    for matrix in matrices {
        output.u32(matrix.rows())?;
    }
    let values = singular_values(&*channel.eigentextures)?;
    output.scalars(scalar, &format!("{place}: S"), &values)?;
    for (matrix, name) in matrices.into_iter().zip(["U", "SxV"]) {
        output.matrix(scalar, &format!("{place}: {name}"), matrix)?;
    }
    Ok(())
}
