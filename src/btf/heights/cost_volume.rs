//! How much views disagree for each assumed height of a texel (plane sweep: Collins 1996).
//!
//! A point of the surface over the texel at x, of height h, is shown by the view v at x − h·(v_x, v_y)/v_z. For every
//! height of a list the images are read there, under a few lights. The cost is the mean difference from the median, of
//! the half of the views that agree best: others may not see the point.

use glam::Vec2;
use rayon::prelude::*;

use crate::btf::heights::planes::{Planes, read};
use crate::btf::sample::Sample;
use crate::error::Result;
use crate::grid::TexelGrid;
use crate::progress::Progress;

/// Heights on either side of 0.
const STEPS: usize = 32;
/// The median counts for no less than this share of the mean luminance: where all is dark, noise agrees with nothing.
const FLOOR: f32 = 0.2;

/// Costs of heights.
pub(super) struct CostVolume {
    pub grid: TexelGrid,
    /// From the lowest up.
    pub heights: Vec<f32>,
    /// Texel after texel, a cost per height.
    pub costs: Vec<f32>,
    /// The median of all costs.
    pub median: f32,
}

/// Images of all views under one light.
struct Lit {
    planes: Vec<Vec<f32>>,
}

impl CostVolume {
    /// The costs of heights from −`range` to `range`.
    pub fn of(
        sample: &Sample,
        planes: &Planes,
        range: f64,
        progress: Progress<'_>,
    ) -> Result<Self> {
        // List the heights, and the slope of every view.
        let grid = sample.grid();
        let step = range / STEPS as f64;
        let heights: Vec<f32> = (0..=2 * STEPS)
            .map(|at| (at as f64 * step - range) as f32)
            .collect();
        let slopes: Vec<Vec2> = planes
            .views
            .iter()
            .map(|&view| {
                let view = sample.description().views[view].0.as_vec3();
                Vec2::new(view.x, view.y) / view.z.max(1e-3)
            })
            .collect();
        // Compare the views under each light.
        let mut costs = vec![0.0; grid.len() * heights.len()];
        progress.begin("comparing views", planes.lights.len() as u64);
        for &light in &planes.lights {
            let lit = Lit {
                planes: planes
                    .views
                    .par_iter()
                    .map(|&view| read(sample, view, light))
                    .collect::<Result<_>>()?,
            };
            lit.add_costs(grid, &heights, &slopes, &mut costs, progress);
            progress.advance(1)?;
        }
        progress.end();
        // Find the median cost.
        let mut sorted = costs.clone();
        let middle = sorted.len() / 2;
        let (_, median, _) = sorted.select_nth_unstable_by(middle, f32::total_cmp);
        Ok(Self {
            grid,
            median: *median,
            heights,
            costs,
        })
    }

    /// The costs of a texel, a number per height.
    pub fn of_texel(&self, texel: usize) -> &[f32] {
        &self.costs[texel * self.heights.len()..][..self.heights.len()]
    }

    /// The difference between neighbouring heights.
    pub fn step(&self) -> f32 {
        self.heights[1] - self.heights[0]
    }

    /// The cost of any height, linear between those of the list; beyond them, that of the nearest.
    pub fn cost(&self, texel: usize, height: f32) -> f32 {
        let costs = self.of_texel(texel);
        let last = (self.heights.len() - 1) as f32;
        let place = ((height - self.heights[0]) / self.step()).clamp(0.0, last);
        let below = (place as usize).min(self.heights.len() - 2);
        let mix = place - below as f32;
        costs[below] + (costs[below + 1] - costs[below]) * mix
    }
}

impl Lit {
    fn add_costs(
        &self,
        grid: TexelGrid,
        heights: &[f32],
        slopes: &[Vec2],
        costs: &mut [f32],
        progress: Progress<'_>,
    ) {
        let total: f32 = self.planes.iter().flatten().sum();
        let floor = FLOOR * total / (self.planes.len() * grid.len()) as f32 + 1e-9;
        let values = || vec![0.0; slopes.len()];
        costs
            .par_chunks_mut(heights.len())
            .enumerate()
            .for_each_init(values, |values, (texel, costs)| {
                if progress.is_interrupted() {
                    return;
                }
                let (row, col) = (texel / grid.width as usize, texel % grid.width as usize);
                for (cost, &height) in costs.iter_mut().zip(heights) {
                    for ((value, plane), slope) in values.iter_mut().zip(&self.planes).zip(slopes) {
                        let at = Vec2::new(col as f32, row as f32)
                            + height * Vec2::new(-slope.x, slope.y);
                        *value = bilinear(plane, grid, at);
                    }
                    *cost += disagreement(values, floor);
                }
            });
    }
}

/// The mean difference from the median, of the half that agrees best, over the median; `values` are reordered.
fn disagreement(values: &mut [f32], floor: f32) -> f32 {
    let middle = values.len() / 2;
    let (_, &mut median, _) = values.select_nth_unstable_by(middle, f32::total_cmp);
    values
        .iter_mut()
        .for_each(|value| *value = (*value - median).abs());
    let kept = middle.max(2).min(values.len());
    if kept < values.len() {
        values.select_nth_unstable_by(kept - 1, f32::total_cmp);
    }
    let sum: f32 = values[..kept].iter().sum();
    sum / kept as f32 / (median + floor)
}

/// A plane between texel centres, at (column, row); wrapped where it is tileable, else the border is repeated.
fn bilinear(plane: &[f32], grid: TexelGrid, at: Vec2) -> f32 {
    let side = |index: f32, count: u32| -> usize {
        let (index, count) = (index as i64, i64::from(count));
        match grid.tileable {
            true => index.rem_euclid(count) as usize,
            false => index.clamp(0, count - 1) as usize,
        }
    };
    let (left, top) = (at.x.floor(), at.y.floor());
    let mix = at - Vec2::new(left, top);
    let columns = [side(left, grid.width), side(left + 1.0, grid.width)];
    let rows = [side(top, grid.height), side(top + 1.0, grid.height)];
    let row = |row: usize| {
        let [a, b] = columns.map(|column| plane[row * grid.width as usize + column]);
        a + (b - a) * mix.x
    };
    let [above, below] = rows.map(row);
    above + (below - above) * mix.y
}
