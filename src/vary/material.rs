//! What is varied: a plain image, or a BTF sample with a few of its images that stand for all in comparisons.
//!
//! In: an image or a sample. Out: numbers that filtering compares, and the same of what was made. A sample is
//! compared by its mean image and by images whose directions are as far from each other as can be; what is
//! made takes all images, direction by direction.

use std::f32::consts::PI;

use ndarray::Array3;

use crate::btf::height_map::HeightMap;
use crate::btf::sample::{Description, Pixels, Sample};
use crate::error::{Error, Result};
use crate::exemplar::channels::ChannelKind;
use crate::exemplar::plain_images::ChannelImage;
use crate::format::image::{Encoding, FloatImage, Precision, encode_srgb};
use crate::grid::TexelGrid;
use crate::progress::Progress;

/// Images of a sample that are compared at most, beside the mean.
pub const MOST_IMAGES: usize = 16;

/// What is varied.
#[derive(Debug)]
pub struct Material {
    /// The images that are compared: of a plain image itself, of a sample the mean first.
    pub images: Vec<ChannelImage>,
    /// Whether opposite borders continue each other.
    pub tileable: bool,
    /// The sample; none for a plain image.
    pub sample: Option<Sample>,
}

impl Material {
    /// A plain image.
    pub fn of_image(image: FloatImage, tileable: bool) -> Self {
        Self {
            images: vec![ChannelImage::new(ChannelKind::Color, image)],
            tileable,
            sample: None,
        }
    }

    /// A sample, compared by its mean and `count` of its images.
    pub fn of_sample(sample: Sample, count: usize, progress: Progress<'_>) -> Result<Self> {
        if count > MOST_IMAGES {
            let expected = format!("0 to {MOST_IMAGES}");
            return Err(Error::option("compare-images", count.to_string(), expected));
        }
        let description = sample.description();
        // Choose the images that are compared.
        let chosen = far_apart(description, count);
        let (numbers, all) = (description.grid().len() * 3, sample.image_count());
        let mut sums = vec![0.0_f64; numbers];
        let mut values = vec![0.0; numbers];
        let mut pictures = vec![Vec::new(); chosen.len()];
        // Read all once, for the mean.
        progress.begin("reading the sample", all as u64);
        for image in 0..all {
            sample.image(image)?.copy_to(&mut values);
            sample.check_image(image, &values)?;
            sums.iter_mut()
                .zip(&values)
                .for_each(|(sum, &value)| *sum += f64::from(value));
            if let Some(place) = chosen.iter().position(|&other| other == image) {
                pictures[place].clone_from(&values);
            }
            progress.advance(1)?;
        }
        progress.end();
        // Make channels of mean and images.
        let mean = sums.iter().map(|sum| (sum / all as f64) as f32).collect();
        let images = std::iter::once(mean).chain(pictures).enumerate();
        let images = images.map(|(number, data)| channel(number, data, description));
        Ok(Self {
            images: images.collect(),
            tileable: description.tileable,
            sample: Some(sample),
        })
    }

    /// Its pixels.
    pub fn grid(&self) -> TexelGrid {
        let image = &self.images[0].image;
        TexelGrid {
            width: image.width,
            height: image.height,
            tileable: self.tileable,
        }
    }

    /// What is compared of each pixel: colours by the sRGB curve, cut to 0 to 1.
    pub fn numbers(&self) -> Array3<f32> {
        let grid = self.grid();
        let depth: usize = self
            .images
            .iter()
            .map(|of| of.image.channels as usize)
            .sum();
        let mut numbers = Array3::zeros((grid.height as usize, grid.width as usize, depth));
        for (texel, mut slots) in numbers.rows_mut().into_iter().enumerate() {
            let mut at = 0;
            for ChannelImage { image, .. } in &self.images {
                let channels = image.channels as usize;
                for &value in &image.data[texel * channels..][..channels] {
                    let stored = match image.encoding {
                        Encoding::Linear => encode_srgb(value),
                        Encoding::Srgb | Encoding::Data => value,
                    };
                    slots[at] = stored.clamp(0.0, 1.0);
                    at += 1;
                }
            }
        }
        numbers
    }

    /// Refuses a partner of another size, kind, or other directions.
    pub fn check_partner(&self, other: &Self) -> Result<()> {
        let size = |material: &Self| {
            let grid = material.grid();
            format!("{}×{}", grid.width, grid.height)
        };
        if size(self) != size(other) {
            return Err(Error::data("size of the second texture", size(other))
                .expected(format!("{}, as the first", size(self)))
                .advice("scale or cut one of them"));
        }
        let channels = |material: &Self| material.images[0].image.channels;
        match (&self.sample, &other.sample) {
            (None, None) if channels(self) != channels(other) => Err(Error::data(
                "second texture",
                format!("{} channels", channels(other)),
            )
            .expected(format!("{}, as the first", channels(self)))),
            (None, None) => Ok(()),
            (Some(own), Some(other)) => check_directions(own.description(), other.description()),
            _ => Err(Error::data("textures", "an image and a sample")
                .expected("two images, or two samples of one set of directions")),
        }
    }
}

/// An image of a sample, or the mean of all; radiance is shown under the irradiance that makes white 1.
fn channel(number: usize, data: Vec<f32>, description: &Description) -> ChannelImage {
    let image = FloatImage {
        width: description.width,
        height: description.height,
        channels: 3,
        data: data.into_iter().map(|value| PI * value).collect(),
        encoding: Encoding::Linear,
        precision: Precision::Float,
    };
    let mut channel = ChannelImage::new(ChannelKind::Color, image);
    if number > 0 {
        channel.name = format!("{}-{}", ChannelKind::Color.name(), number + 1);
    }
    channel
}

/// So many images whose views and lights are far from each other: the first has both nearest to the normal,
/// each next one is the farthest from all before it.
fn far_apart(description: &Description, count: usize) -> Vec<usize> {
    let directions = |image: usize| {
        let (view, light) = description.view_and_light(image);
        (description.views[view].0, description.lights[light].0)
    };
    let all = description.image_count();
    let apart = |a: usize, b: usize| {
        let ((view, light), (other_view, other_light)) = (directions(a), directions(b));
        view.distance_squared(other_view) + light.distance_squared(other_light)
    };
    let height = |image: usize| {
        let (view, light) = directions(image);
        view.z + light.z
    };
    let mut chosen: Vec<usize> = Vec::new();
    let mut nearest = vec![f64::INFINITY; all];
    while chosen.len() < count.min(all) {
        let next = match chosen.is_empty() {
            true => first_greatest((0..all).map(height)),
            false => first_greatest(nearest.iter().copied()),
        };
        chosen.push(next);
        for (image, nearest) in nearest.iter_mut().enumerate() {
            *nearest = nearest.min(apart(image, next));
        }
    }
    chosen.sort_unstable();
    chosen.dedup();
    chosen
}

fn first_greatest(numbers: impl Iterator<Item = f64>) -> usize {
    let mut best = (f64::NEG_INFINITY, 0);
    for (at, number) in numbers.enumerate() {
        if number > best.0 {
            best = (number, at);
        }
    }
    best.1
}

/// How far directions of one set may be apart.
const SAME_DIRECTION: f64 = 1e-4;

fn check_directions(own: &Description, other: &Description) -> Result<()> {
    let layout = |description: &Description| match description.pairs {
        None => "product",
        Some(_) => "pairs",
    };
    let summary = |description: &Description| {
        let (views, lights) = (description.views.len(), description.lights.len());
        format!(
            "{views} views, {lights} lights, layout {}",
            layout(description)
        )
    };
    let same = |a: &[crate::btf::Direction], b: &[crate::btf::Direction]| {
        let near = a
            .iter()
            .zip(b)
            .all(|(a, b)| a.0.distance(b.0) <= SAME_DIRECTION);
        a.len() == b.len() && near
    };
    let fits = same(&own.views, &other.views)
        && same(&own.lights, &other.lights)
        && own.pairs == other.pairs;
    match fits {
        true => Ok(()),
        false => Err(
            Error::data("directions of the second sample", summary(other))
                .expected(format!(
                    "the set of the first, in its order: {}",
                    summary(own)
                ))
                .advice("bake or import both with one set of directions"),
        ),
    }
}

/// What every pixel of an output is made of.
#[derive(Clone, Debug, PartialEq)]
pub struct Picks {
    /// Rows and columns.
    pub output: (usize, usize),
    /// The texel of the first material, and of the second where two are blended.
    pub texels: Vec<Vec<u32>>,
    /// The second material's share; empty where there is one.
    pub shares: Vec<f32>,
}

impl Picks {
    /// The numbers of an image made of one per material, `channels` per pixel.
    pub fn gather(&self, images: &[&[f32]], channels: usize) -> Vec<f32> {
        let pixels = self.output.0 * self.output.1;
        let mut numbers = Vec::with_capacity(pixels * channels);
        for pixel in 0..pixels {
            let texel =
                |of: usize| &images[of][self.texels[of][pixel] as usize * channels..][..channels];
            match self.shares.get(pixel) {
                None => numbers.extend_from_slice(texel(0)),
                Some(share) => {
                    let pairs = texel(0).iter().zip(texel(1));
                    numbers.extend(pairs.map(|(a, b)| (1.0 - share) * a + share * b));
                }
            }
        }
        numbers
    }

    /// The compared images of what was made.
    pub fn images(&self, materials: &[&Material]) -> Vec<ChannelImage> {
        let first = &materials[0].images;
        let made = first.iter().enumerate().map(|(number, of)| {
            let read: Vec<&[f32]> = materials
                .iter()
                .map(|material| &material.images[number].image.data[..])
                .collect();
            ChannelImage {
                image: FloatImage {
                    width: self.output.1 as u32,
                    height: self.output.0 as u32,
                    data: self.gather(&read, of.image.channels as usize),
                    ..of.image.clone()
                },
                ..of.clone()
            }
        });
        made.collect()
    }

    /// The heights of a sample made of one per material; none where one has none.
    pub fn sample_heights(&self, samples: &[&Sample]) -> Result<Option<HeightMap>> {
        let heights = samples.iter().map(|sample| sample.heights());
        let Some(heights) = heights.collect::<Result<Option<Vec<_>>>>()? else {
            return Ok(None);
        };
        let numbers: Vec<&[f32]> = heights.iter().map(HeightMap::heights).collect();
        let grid = TexelGrid {
            width: self.output.1 as u32,
            height: self.output.0 as u32,
            tileable: false,
        };
        HeightMap::new(grid, self.gather(&numbers, 1)).map(Some)
    }

    /// One image of a sample made of one per material.
    pub fn sample_image(&self, pixels: &[Pixels]) -> Vec<f32> {
        let values: Vec<Vec<f32>> = pixels
            .iter()
            .map(|pixels| {
                let mut values = vec![0.0; pixels.len()];
                pixels.copy_to(&mut values);
                values
            })
            .collect();
        let views: Vec<&[f32]> = values.iter().map(Vec::as_slice).collect();
        self.gather(&views, 3)
    }
}

#[cfg(test)]
mod tests;
