//! The scale and the level at which photometric heights fit the flow.
//!
//! Walls that are seen by nobody, or cut off as too steep, make photometric heights too flat by one factor, more or
//! less. The factor, and the plane from which heights are counted, are those at which views disagree least.

use rayon::prelude::*;

use crate::btf::heights::cost_volume::CostVolume;

/// Scales that are tried: multiples of this, from 0.
const SCALE_STEP: f32 = 0.125;
const SCALES: usize = 49;
/// Levels that are tried, on either side of 0.
const LEVELS: i32 = 8;

/// height = scale · photometric height + level.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Fit {
    pub scale: f32,
    pub level: f32,
}

impl Fit {
    /// The fit of least cost; of equal ones the smaller scale.
    pub fn of(photometric: &[f32], volume: &CostVolume) -> Self {
        let level_step = volume.step();
        let level = |at: i32| at as f32 * level_step;
        let scales = (0..SCALES).flat_map(|at| {
            let scale = at as f32 * SCALE_STEP;
            (-LEVELS..=LEVELS).map(move |at| Self {
                scale,
                level: level(at),
            })
        });
        let tried: Vec<Self> = scales.collect();
        let costs: Vec<f64> = tried
            .par_iter()
            .map(|fit| {
                let heights = photometric.iter().enumerate();
                let cost = |(texel, &h): (usize, &f32)| volume.cost(texel, fit.applied_to(h));
                heights.map(cost).map(f64::from).sum()
            })
            .collect();
        let mut best = 0;
        for (at, cost) in costs.iter().enumerate() {
            if *cost < costs[best] {
                best = at;
            }
        }
        tried[best]
    }

    /// A photometric height, fitted.
    pub fn applied_to(&self, height: f32) -> f32 {
        self.scale * height + self.level
    }
}
