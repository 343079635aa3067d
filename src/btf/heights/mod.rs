//! Heights of a sample, estimated from its images in two independent ways.
//!
//! *Photometrically*: how a texel's brightness changes with the light gives its normal, and normals are integrated to
//! heights. These are fine in detail; where walls are too steep to be seen, they are too flat. *By flow*: the images
//! are rectified on z = 0, so a point of height z stands at different texels in the images of two views. The height at
//! which all views agree is that of the point. It needs texture, and knows how high walls are.
//!
//! The photometric heights are scaled and moved to fit the flow; then each texel takes the height at which views agree
//! best, the photometric one being favoured.
//!
//! | file | what it does |
//! | --- | --- |
//! | [`planes`] | the images that are compared, as luminance |
//! | [`photometric`] | normals by robust least squares over lights, integrated |
//! | [`cost_volume`] | how much views disagree when a texel is taken to be so high |
//! | [`fit`] | the scale and level at which photometric heights fit the flow |
//! | [`matching`] | the heights of least disagreement, with few steps between neighbours |

mod cost_volume;
mod fit;
mod matching;
mod photometric;
mod planes;

use serde::Serialize;

use crate::btf::height_map::HeightMap;
use crate::btf::heights::cost_volume::CostVolume;
use crate::btf::heights::fit::Fit;
use crate::btf::heights::matching::{best_heights, without_prior};
use crate::btf::heights::planes::Planes;
use crate::btf::sample::Sample;
use crate::error::{Error, Result};
use crate::progress::Progress;

/// How heights are estimated.
#[derive(Clone, Debug, PartialEq, Serialize, clap::Args)]
#[serde(rename_all = "kebab-case")]
pub struct HeightOptions {
    /// Range of heights: from −N to N texels.
    #[arg(long, value_name = "N", default_value_t = HeightOptions::default().range)]
    pub range: f64,
}

impl Default for HeightOptions {
    fn default() -> Self {
        Self { range: 8.0 }
    }
}

impl HeightOptions {
    /// Refuses ranges in which nothing can be found.
    pub fn validate(&self) -> Result<()> {
        match (0.5..=64.0).contains(&self.range) {
            true => Ok(()),
            false => Err(Error::option(
                "range",
                self.range.to_string(),
                "0.5 to 64 texels",
            )),
        }
    }
}

/// How well the two ways agree.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Agreement {
    /// Correlation of the photometric heights with those by flow alone, −1 to 1.
    pub correlation: f64,
    /// The root mean square of their difference, scale and level fitted, in texels.
    pub difference: f64,
    /// What the photometric heights were multiplied by to fit the flow.
    pub scale: f64,
    /// The level that was added to them, in texels.
    pub level: f64,
    /// Deviation of the photometric heights, not scaled, in texels.
    pub photometric_deviation: f64,
    /// Deviation of the heights by flow alone, in texels.
    pub flow_deviation: f64,
}

/// Estimated heights.
#[derive(Clone, Debug)]
pub struct Estimate {
    /// In texels above z = 0.
    pub heights: HeightMap,
    /// How well the two ways agree.
    pub agreement: Agreement,
}

/// Estimates the heights of a sample.
pub fn estimate(
    sample: &Sample,
    options: &HeightOptions,
    progress: Progress<'_>,
) -> Result<Estimate> {
    options.validate()?;
    let planes = Planes::choose(sample.description())?;
    let lit = planes.under_all_lights(sample, progress)?;
    let photometric = photometric::heights(&lit, sample.grid());
    progress.check()?;
    let volume = CostVolume::of(sample, &planes, options.range, progress)?;
    let fit = Fit::of(&photometric, &volume);
    let flow = without_prior(&volume);
    progress.check()?;
    let fitted: Vec<f32> = photometric.iter().map(|&h| fit.applied_to(h)).collect();
    let heights = best_heights(&volume, Some(&fitted));
    Ok(Estimate {
        agreement: agreement(&photometric, &fitted, &flow, &fit),
        heights: HeightMap::new(sample.grid(), heights)?,
    })
}

fn agreement(photometric: &[f32], fitted: &[f32], flow: &[f32], fit: &Fit) -> Agreement {
    let (photometric_deviation, flow_deviation) = (deviation(photometric), deviation(flow));
    let (mean_photometric, mean_flow) = (mean(photometric), mean(flow));
    let products = photometric
        .iter()
        .zip(flow)
        .map(|(&a, &b)| (f64::from(a) - mean_photometric) * (f64::from(b) - mean_flow));
    let covariance = products.sum::<f64>() / flow.len() as f64;
    let both = photometric_deviation * flow_deviation;
    let squares = fitted
        .iter()
        .zip(flow)
        .map(|(&a, &b)| f64::from(a - b).powi(2));
    Agreement {
        correlation: if both > 0.0 { covariance / both } else { 0.0 },
        difference: (squares.sum::<f64>() / flow.len() as f64).sqrt(),
        scale: f64::from(fit.scale),
        level: f64::from(fit.level),
        photometric_deviation,
        flow_deviation,
    }
}

fn mean(numbers: &[f32]) -> f64 {
    numbers.iter().map(|&n| f64::from(n)).sum::<f64>() / numbers.len() as f64
}

fn deviation(numbers: &[f32]) -> f64 {
    let mean = mean(numbers);
    let squares = numbers.iter().map(|&n| (f64::from(n) - mean).powi(2));
    (squares.sum::<f64>() / numbers.len() as f64).sqrt()
}

#[cfg(test)]
mod tests;
