//! The heights of least cost, with few steps between neighbours: semi-global matching (Hirschmüller 2008).
//!
//! Costs are summed along lines of texels in four directions. From one texel to the next a change by one step of the
//! list costs a little, any other change costs more. Each texel takes the height whose four sums are least.

use rayon::prelude::*;

use crate::btf::heights::cost_volume::CostVolume;

/// What a change by one step costs, in medians of all costs.
const SMALL_CHANGE: f32 = 0.05;
/// What any other change costs.
const LARGE_CHANGE: f32 = 0.2;
/// What a texel of height beside the expected one costs.
const UNEXPECTED: f32 = 0.3;

/// The best heights of all texels by the images alone.
pub(super) fn without_prior(volume: &CostVolume) -> Vec<f32> {
    best_heights(volume, None)
}

/// The best heights of all texels; those near the `expected` ones are favoured.
pub(super) fn best_heights(volume: &CostVolume, expected: Option<&[f32]>) -> Vec<f32> {
    let costs = match expected {
        None => volume.costs.clone(),
        Some(expected) => favoured(volume, expected),
    };
    let summed = summed_along_lines(volume, &costs);
    let count = volume.heights.len();
    let texels = summed.par_chunks(count);
    texels.map(|sums| least(sums, volume)).collect()
}

fn favoured(volume: &CostVolume, expected: &[f32]) -> Vec<f32> {
    let mut costs = volume.costs.clone();
    let each = costs.par_chunks_mut(volume.heights.len()).zip(expected);
    each.for_each(|(costs, expected)| {
        for (cost, height) in costs.iter_mut().zip(&volume.heights) {
            *cost += UNEXPECTED * volume.median * (height - expected).abs();
        }
    });
    costs
}

/// A way through the texels of a grid.
#[derive(Clone, Copy)]
struct Line {
    first: usize,
    step: isize,
    length: usize,
}

impl Line {
    fn texels(self) -> impl Iterator<Item = usize> {
        let texel = move |at: usize| self.first.wrapping_add_signed(self.step * at as isize);
        (0..self.length).map(texel)
    }
}

fn summed_along_lines(volume: &CostVolume, costs: &[f32]) -> Vec<f32> {
    let [width, height] = [volume.grid.width, volume.grid.height].map(|side| side as usize);
    // Lay out the lines of all four directions.
    let right = |row: usize| (row * width, 1, width);
    let left = |row: usize| (row * width + width - 1, -1, width);
    let down = |col: usize| (col, width as isize, height);
    let up = |col: usize| (col + (height - 1) * width, -(width as isize), height);
    let line = |(first, step, length)| Line {
        first,
        step,
        length,
    };
    let directions: [Vec<Line>; 4] = [
        (0..height).map(right).map(line).collect(),
        (0..height).map(left).map(line).collect(),
        (0..width).map(down).map(line).collect(),
        (0..width).map(up).map(line).collect(),
    ];
    // Sum along lines in parallel, and add them up in a fixed order.
    let count = volume.heights.len();
    let mut sums = vec![0.0; costs.len()];
    for lines in &directions {
        let along: Vec<Vec<f32>> = lines
            .par_iter()
            .map(|&line| along_line(volume, costs, line))
            .collect();
        for (line, along) in lines.iter().zip(&along) {
            for (texel, part) in line.texels().zip(along.chunks_exact(count)) {
                let sums = &mut sums[texel * count..][..count];
                sums.iter_mut()
                    .zip(part)
                    .for_each(|(sum, part)| *sum += part);
            }
        }
    }
    sums
}

/// The costs summed along a line, texel after texel. A line of a tileable sample runs twice round.
fn along_line(volume: &CostVolume, costs: &[f32], line: Line) -> Vec<f32> {
    let count = volume.heights.len();
    let (small, large) = (SMALL_CHANGE * volume.median, LARGE_CHANGE * volume.median);
    let mut last = vec![0.0; count];
    let mut next = vec![0.0; count];
    let mut all = Vec::with_capacity(line.length * count);
    let rounds = if volume.grid.tileable { 2 } else { 1 };
    for round in 1..=rounds {
        for texel in line.texels() {
            let own = &costs[texel * count..][..count];
            let least = last.iter().copied().fold(f32::INFINITY, f32::min);
            for (at, (next, own)) in next.iter_mut().zip(own).enumerate() {
                let beside = |at: Option<usize>| {
                    at.and_then(|at| last.get(at))
                        .map_or(f32::INFINITY, |cost| cost + small)
                };
                let cheapest = last[at]
                    .min(beside(at.checked_sub(1)))
                    .min(beside(Some(at + 1)))
                    .min(least + large);
                *next = own + cheapest - least;
            }
            std::mem::swap(&mut last, &mut next);
            if round == rounds {
                all.extend_from_slice(&last);
            }
        }
    }
    all
}

/// The height of the least sum, by a parabola through it and its neighbours.
fn least(sums: &[f32], volume: &CostVolume) -> f32 {
    let mut best = 0;
    for (at, sum) in sums.iter().enumerate() {
        if *sum < sums[best] {
            best = at;
        }
    }
    if best == 0 || best + 1 == sums.len() {
        return volume.heights[best];
    }
    let (before, here, after) = (sums[best - 1], sums[best], sums[best + 1]);
    let bend = before - 2.0 * here + after;
    let aside = match bend > 0.0 {
        true => (0.5 * (before - after) / bend).clamp(-0.5, 0.5),
        false => 0.0,
    };
    volume.heights[best] + aside * volume.step()
}
