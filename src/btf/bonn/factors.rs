//! The matrices of DFMF and FMF files: per channel, factors of the images and eigentextures.
//!
//! value_c(image, texel) = U_c\[image\] · E_c\[texel\], image = view · lights + light, texel = row · width + column.
//! The singular values are in E_c; those that a file lists besides are not needed.

use std::ops::Range;
use std::sync::Arc;

use glam::DVec3;
use ndarray::{Array2, s};
use rayon::prelude::*;

use crate::btf::bonn::body::Body;
use crate::btf::bonn::color::{Color, unlog};
use crate::btf::bonn::matrix::{MatrixRows, to_array};
use crate::error::{Error, Result};
use crate::matrix::product_of;

/// Images expanded together by one thread.
const IMAGES: usize = 8;
/// Texels whose eigentextures stay in a cache.
const TEXELS: usize = 512;

/// The factors of one channel.
#[derive(Clone)]
pub struct Channel {
    /// U: a row per image.
    pub directions: Arc<dyn MatrixRows>,
    /// E: a row per texel.
    pub eigentextures: Arc<dyn MatrixRows>,
}

impl Channel {
    /// Components.
    pub fn rank(&self) -> usize {
        self.directions.columns()
    }

    /// The two matrices of a channel, `left` and `right`, whichever has the rows of the images.
    pub(super) fn of_either(
        place: &str,
        [left, right]: [Arc<dyn MatrixRows>; 2],
        [images, texels]: [usize; 2],
    ) -> Result<Self> {
        let sides = [left.rows(), right.rows()];
        if sides == [images, texels] {
            return Ok(Self {
                directions: left,
                eigentextures: right,
            });
        }
        if sides == [texels, images] {
            return Ok(Self {
                directions: right,
                eigentextures: left,
            });
        }
        Err(Error::data(
            format!("{place}: rows of U and of SxV"),
            format!("{} and {}", sides[0], sides[1]),
        )
        .expected(format!(
            "{images} images and {texels} texels, in either order"
        )))
    }
}

/// All factors of a file.
pub(super) struct Factors {
    /// One per channel, at least 1.
    pub(super) channels: Vec<Channel>,
    /// What the channels stand for.
    pub(super) color: Color,
    /// Whether the colours are logarithms.
    pub(super) logarithmic: bool,
    /// Which channels are red, green and blue, or the model's three.
    pub(super) rgb: [usize; 3],
}

impl Factors {
    /// Whether RGB is linear in the factors.
    pub(super) fn is_linear(&self) -> bool {
        self.color.linear().is_some() && !self.logarithmic
    }

    /// The largest number of components.
    pub(super) fn rank(&self) -> usize {
        self.channels.iter().map(Channel::rank).max().unwrap_or(0)
    }

    /// Whether all channels have the same eigentextures.
    pub(super) fn shares_eigentextures(&self) -> bool {
        let first = &self.channels[0].eigentextures;
        self.channels[1..]
            .iter()
            .all(|channel| Arc::ptr_eq(&channel.eigentextures, first))
    }

    /// Reads all matrices.
    pub(super) fn load(&self) -> Result<LoadedFactors> {
        let mut channels: Vec<[Arc<Array2<f32>>; 2]> = Vec::new();
        for (at, channel) in self.channels.iter().enumerate() {
            let earlier = self.channels[..at]
                .iter()
                .position(|other| Arc::ptr_eq(&other.eigentextures, &channel.eigentextures));
            let eigentextures = match earlier {
                Some(earlier) => Arc::clone(&channels[earlier][1]),
                None => Arc::new(to_array(&*channel.eigentextures)?),
            };
            channels.push([Arc::new(to_array(&*channel.directions)?), eigentextures]);
        }
        Ok(LoadedFactors {
            channels,
            color: self.color,
            logarithmic: self.logarithmic,
            rgb: self.rgb,
        })
    }
}

/// The same in memory, to be expanded.
pub(super) struct LoadedFactors {
    /// U and E of each channel.
    channels: Vec<[Arc<Array2<f32>>; 2]>,
    color: Color,
    logarithmic: bool,
    rgb: [usize; 3],
}

impl LoadedFactors {
    fn color(&self, channels: DVec3) -> [f32; 3] {
        let rgb = self.color.to_rgb(channels);
        let rgb = match self.logarithmic {
            true => DVec3::new(unlog(rgb.x), unlog(rgb.y), unlog(rgb.z)),
            false => rgb,
        };
        rgb.as_vec3().to_array()
    }

    /// Images of one thread, [images, texels, RGB].
    fn multiply(&self, images: Range<usize>, out: &mut [f32]) {
        let texels = self.channels[0][1].nrows();
        for start in (0..texels).step_by(TEXELS) {
            let part = start..texels.min(start + TEXELS);
            let values: Vec<Array2<f32>> = self
                .channels
                .iter()
                .map(|[directions, eigentextures]| {
                    let directions = directions.slice(s![images.clone(), ..]);
                    let eigentextures = eigentextures.slice(s![part.clone(), ..]);
                    product_of(directions, eigentextures.t())
                })
                .collect();
            for (image, out) in out.chunks_mut(texels * 3).enumerate() {
                let (out, _) = out[part.start * 3..part.end * 3].as_chunks_mut::<3>();
                for (texel, out) in out.iter_mut().enumerate() {
                    let channels = self.rgb.map(|at| f64::from(values[at][(image, texel)]));
                    *out = self.color(DVec3::from_array(channels));
                }
            }
        }
    }
}

impl Body for LoadedFactors {
    fn read(&self, images: Range<usize>, out: &mut [f32]) -> Result<()> {
        let image = self.channels[0][1].nrows() * 3;
        out.par_chunks_mut(IMAGES * image)
            .enumerate()
            .for_each(|(group, out)| {
                let first = images.start + group * IMAGES;
                self.multiply(first..first + out.len() / image, out);
            });
        Ok(())
    }
}
