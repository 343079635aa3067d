//! A channel of the sample in the numbers that are mixed: colours in linear light, normals as unit vectors in
//! the texels' frame, all else as it stands.
//!
//! In: the channels of a space, or an image of the sample's size or a multiple of it. Out: numbers on the
//! sample's grid, and their value at any texture coordinate. A larger image is reduced by means over blocks:
//! what is asked for is a value per texel.

use crate::error::{Error, Result};
use crate::exemplar::channels::{Channel, ChannelKind};
use crate::exemplar::plain_images::range_of_image;
use crate::exemplar::space::Space;
use crate::format::image::{Encoding, FloatImage, Precision, decode_srgb};
use crate::grid::{TexCoord, TexelGrid};

/// A channel, ready to be carried onto a surface.
#[derive(Clone, Debug)]
pub struct SampleChannel {
    /// The channel's name.
    pub name: String,
    /// What its numbers are.
    pub kind: ChannelKind,
    /// Numbers per texel: 1 or 3.
    pub count: usize,
    /// The least number, colours by the sRGB curve.
    pub low: f64,
    /// The greatest number, colours by the sRGB curve.
    pub high: f64,
    /// What the file of the channel stored.
    pub precision: Precision,
    /// The sample's texels.
    pub grid: TexelGrid,
    /// How many texels of the channel stand for the side of one of the sample.
    detail: u32,
    /// [`detail`](Self::detail)² · [`grid`](Self::grid) · [`count`](Self::count) numbers.
    numbers: Vec<f32>,
}

/// How many numbers per texel a normal has.
const NORMAL: usize = 3;

impl SampleChannel {
    /// The channels of a space of plain images; none of a space of textons.
    pub fn of_space(space: &Space) -> Vec<Self> {
        let channels = space.channels.list().iter();
        let channel = |channel: &Channel| {
            let numbers: Vec<f32> = space.channel_numbers(0, channel)?.iter().copied().collect();
            Some(Self::new(
                channel.name.clone(),
                channel.kind,
                (channel.low, channel.high),
                precision_of(&numbers),
                space.levels[0].grid,
                Stored {
                    count: channel.count as usize,
                    encoding: match channel.kind {
                        ChannelKind::Color => Encoding::Srgb,
                        _ => Encoding::Data,
                    },
                    numbers,
                },
            ))
        };
        channels.filter_map(channel).collect()
    }

    /// A channel from an image of the sample's size or a multiple of it; `name` is the channel's. Where the image
    /// has more than `detail` texels for the side of one of the sample, which is 1 or more, it is reduced to
    /// as few as that, or the next more that divide it.
    pub fn of_image(
        name: String,
        kind: ChannelKind,
        image: FloatImage,
        grid: TexelGrid,
        detail: u32,
    ) -> Result<Self> {
        // Check image and kind.
        image.check_finite()?;
        let factor = factor_of(&image, grid)?;
        if !kind.counts().contains(&image.channels) {
            return Err(
                Error::data("channels", image.channels.to_string()).expected(format!(
                    "{:?} for kind {}",
                    kind.counts(),
                    kind.name()
                )),
            );
        }
        // Store its numbers.
        let range = range_of_image(kind, &image);
        let (width, count) = (image.width as usize, image.channels as usize);
        let (precision, encoding) = (image.precision, image.encoding);
        let stored = Stored {
            count,
            encoding,
            numbers: image.data,
        };
        let mut channel = Self::new(name, kind, range, precision, grid, stored);
        channel.detail = kept_detail(factor, detail);
        // Reduce it to the detail that is kept.
        let block = (factor / channel.detail) as usize;
        if block > 1 {
            channel.numbers = block_means(&channel.numbers, width, channel.count, block);
            channel.renormalize();
        }
        Ok(channel)
    }

    fn new(
        name: String,
        kind: ChannelKind,
        (low, high): (f64, f64),
        precision: Precision,
        grid: TexelGrid,
        stored: Stored,
    ) -> Self {
        let (count, numbers) = match kind {
            ChannelKind::Color => (stored.count, stored.linear()),
            ChannelKind::Normal => (NORMAL, stored.unit_vectors(low as f32, high as f32)),
            _ => (stored.count, stored.numbers),
        };
        Self {
            name,
            kind,
            count,
            low,
            high,
            precision,
            grid,
            detail: 1,
            numbers,
        }
    }

    fn renormalize(&mut self) {
        if self.kind == ChannelKind::Normal {
            let vectors = self.numbers.chunks_exact_mut(NORMAL);
            vectors.for_each(|vector| {
                let unit = unit_vector([vector[0], vector[1], vector[2]]);
                vector.copy_from_slice(&unit);
            });
        }
    }

    /// Whether every number is 1 or more.
    pub fn is_one(&self) -> bool {
        self.numbers.iter().all(|&number| number >= 1.0)
    }

    /// The value at a coordinate, mixed from the four texels round it: at a texel's centre that of the texel.
    /// Beyond the sample's border its other side follows where it is tileable, else the border is repeated.
    /// Normals come out of any length; unused entries are 0.
    pub fn at(&self, coord: TexCoord) -> [f32; 3] {
        let scale = self.detail as f32;
        let column = coord.s * scale - 0.5;
        let row = (self.grid.height as f32 - coord.t) * scale - 0.5;
        let (left, top) = (column.floor(), row.floor());
        let (right, down) = (column - left, row - top);
        let mut value = [0.0; 3];
        for (i, j) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            let share =
                if i == 0 { 1.0 - down } else { down } * if j == 0 { 1.0 - right } else { right };
            if share > 0.0 {
                let numbers = self.texel(top as i64 + i, left as i64 + j);
                value
                    .iter_mut()
                    .zip(numbers)
                    .for_each(|(value, number)| *value += share * number);
            }
        }
        value
    }

    fn texel(&self, row: i64, col: i64) -> &[f32] {
        let [width, height] =
            [self.grid.width, self.grid.height].map(|side| i64::from(side * self.detail));
        let side = |at: i64, side: i64| match self.grid.tileable {
            true => at.rem_euclid(side),
            false => at.clamp(0, side - 1),
        };
        let texel = (side(row, height) * width + side(col, width)) as usize;
        &self.numbers[texel * self.count..][..self.count]
    }
}

/// Numbers as a file or a space holds them.
struct Stored {
    count: usize,
    encoding: Encoding,
    numbers: Vec<f32>,
}

impl Stored {
    fn linear(mut self) -> Vec<f32> {
        if self.encoding == Encoding::Srgb {
            for value in &mut self.numbers {
                *value = decode_srgb(value.abs()).copysign(*value);
            }
        }
        self.numbers
    }

    /// Normals of length 1, `low` to `high` standing for −1 to 1; z from x and y where it is missing.
    fn unit_vectors(&self, low: f32, high: f32) -> Vec<f32> {
        let signed = |number: f32| 2.0 * (number - low) / (high - low) - 1.0;
        let texels = self.numbers.chunks_exact(self.count);
        let vector = |texel: &[f32]| {
            let (x, y) = (signed(texel[0]), signed(texel[1]));
            unit_vector(match texel.get(2) {
                Some(&z) => [x, y, signed(z)],
                None => [x, y, (1.0 - x * x - y * y).max(0.0).sqrt()],
            })
        };
        texels.flat_map(vector).collect()
    }
}

/// A vector at length 1; upright where it has none.
pub(super) fn unit_vector([x, y, z]: [f32; 3]) -> [f32; 3] {
    glam::Vec3::new(x, y, z)
        .try_normalize()
        .unwrap_or(glam::Vec3::Z)
        .to_array()
}

/// The least divisor of `factor` that is not below `detail`; `factor` where that is less.
fn kept_detail(factor: u32, detail: u32) -> u32 {
    let mut divisors = (detail.max(1)..factor).filter(|divisor| factor.is_multiple_of(*divisor));
    divisors.next().unwrap_or(factor)
}

/// How many texels of an image stand for the side of one of the sample's.
fn factor_of(image: &FloatImage, grid: TexelGrid) -> Result<u32> {
    let factor = image.width / grid.width;
    if factor > 0 && image.width == factor * grid.width && image.height == factor * grid.height {
        return Ok(factor);
    }
    Err(
        Error::data("size", format!("{}×{}", image.width, image.height))
            .expected(format!(
                "{}×{}, as the sample has, or a multiple of both sides",
                grid.width, grid.height
            ))
            .advice("maps are aligned with the sample: cut and scale them as its images were"),
    )
}

/// Means over blocks of `factor` × `factor` texels.
fn block_means(numbers: &[f32], width: usize, count: usize, factor: usize) -> Vec<f32> {
    let (columns, row_length) = (width / factor, width * count);
    let share = 1.0 / (factor * factor) as f32;
    let mut means = Vec::with_capacity(numbers.len() / (factor * factor));
    for rows in numbers.chunks_exact(row_length * factor) {
        let first = means.len();
        means.resize(first + columns * count, 0.0);
        for row in rows.chunks_exact(row_length) {
            let texels = row.chunks_exact(count).enumerate();
            for (col, texel) in texels {
                let mean = &mut means[first + col / factor * count..][..count];
                mean.iter_mut()
                    .zip(texel)
                    .for_each(|(mean, number)| *mean += share * number);
            }
        }
    }
    means
}

/// The fewest bits that hold numbers of which nothing else is known.
fn precision_of(numbers: &[f32]) -> Precision {
    let are_steps_of = |most: f32| {
        numbers.iter().all(|&number| {
            let step = number * most;
            (0.0..=1.0).contains(&number) && (step - step.round()).abs() < 1e-3
        })
    };
    if are_steps_of(255.0) {
        Precision::Bits8
    } else if are_steps_of(65535.0) {
        Precision::Bits16
    } else {
        Precision::Float
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GRID: TexelGrid = TexelGrid {
        width: 3,
        height: 2,
        tileable: false,
    };

    fn image(width: u32, height: u32, channels: u32, data: Vec<f32>) -> FloatImage {
        let (encoding, precision) = (Encoding::Data, Precision::Bits8);
        FloatImage {
            width,
            height,
            channels,
            data,
            encoding,
            precision,
        }
    }

    fn heights(grid: TexelGrid) -> SampleChannel {
        let image = image(3, 2, 1, vec![0.0, 0.25, 0.5, 0.75, 1.0, 0.125]);
        SampleChannel::of_image("height".into(), ChannelKind::Height, image, grid, 1).unwrap()
    }

    #[test]
    fn at_centres_the_texels_stand() {
        let channel = heights(GRID);
        for (texel, &number) in channel.numbers.iter().enumerate() {
            let coord = GRID.centre(crate::index::TexelIndex(texel as u32));
            assert_eq!(channel.at(coord), [number, 0.0, 0.0]);
        }
        // Half-way between (0, 0), (0, 1), (1, 0) and (1, 1).
        assert_eq!(channel.at(TexCoord { s: 1.0, t: 1.0 })[0], 0.5);
    }

    #[test]
    fn borders_are_repeated_or_continue_each_other() {
        let left = TexCoord { s: 0.0, t: 1.5 };
        assert_eq!(heights(GRID).at(left)[0], 0.0);
        let tile = TexelGrid {
            tileable: true,
            ..GRID
        };
        assert_eq!(heights(tile).at(left)[0], 0.25);
    }

    #[test]
    fn colours_are_mixed_in_linear_light() {
        let mut two = image(2, 1, 1, vec![0.0, 1.0]);
        two.encoding = Encoding::Srgb;
        let grid = TexelGrid {
            width: 2,
            height: 1,
            tileable: false,
        };
        let channel =
            SampleChannel::of_image("c".into(), ChannelKind::Color, two, grid, 1).unwrap();
        assert_eq!(channel.at(TexCoord { s: 1.0, t: 0.5 })[0], 0.5);
    }

    #[test]
    fn larger_images_are_reduced_and_others_refused() {
        let data = (0..24).map(|at| (at % 6) as f32).collect();
        let large = image(6, 4, 1, data);
        let made = |image| SampleChannel::of_image("m".into(), ChannelKind::Mask, image, GRID, 1);
        assert_eq!(made(large).unwrap().numbers, [0.5, 2.5, 4.5, 0.5, 2.5, 4.5]);
        for (width, height) in [(6, 2), (4, 4), (2, 1)] {
            let other = image(width, height, 1, vec![0.5; (width * height) as usize]);
            let text = made(other).unwrap_err().to_string();
            assert!(text.contains("3×2") && text.contains("multiple"), "{text}");
        }
    }

    #[test]
    fn as_much_detail_is_kept_as_asked_for() {
        let kept = |detail| kept_detail(12, detail);
        assert_eq!([1, 2, 3, 5, 7, 12, 13].map(kept), [1, 2, 3, 6, 12, 12, 12]);
        let large = image(6, 4, 1, (0..24).map(|at| at as f32).collect());
        let made = SampleChannel::of_image("m".into(), ChannelKind::Mask, large, GRID, 2).unwrap();
        // The centre of the image's texel in row 1, column 2.
        assert_eq!(made.at(TexCoord { s: 1.25, t: 1.25 })[0], 8.0);
    }

    #[test]
    fn normals_are_unit_vectors() {
        let grid = TexelGrid {
            width: 1,
            height: 1,
            tileable: false,
        };
        let at = |channels, data: Vec<f32>| {
            let image = image(1, 1, channels, data);
            let made = SampleChannel::of_image("n".into(), ChannelKind::Normal, image, grid, 1);
            made.unwrap().at(TexCoord { s: 0.5, t: 0.5 })
        };
        assert_eq!(at(3, vec![0.5, 0.5, 1.0]), [0.0, 0.0, 1.0]);
        let [x, y, z] = at(2, vec![0.8, 0.5]);
        assert!((x - 0.6).abs() < 1e-6 && y.abs() < 1e-6 && (z - 0.8).abs() < 1e-6);
        assert_eq!(at(3, vec![0.5, 0.5, 0.5]), [0.0, 0.0, 1.0]);
    }

    #[test]
    fn precision_is_told_by_the_numbers() {
        assert_eq!(precision_of(&[0.0, 1.0, 7.0 / 255.0]), Precision::Bits8);
        assert_eq!(precision_of(&[7.0 / 65535.0]), Precision::Bits16);
        assert_eq!(precision_of(&[0.123_456]), Precision::Float);
        assert_eq!(precision_of(&[2.0]), Precision::Float);
    }
}
