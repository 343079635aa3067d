//! The size of a sample's features, by the autocorrelation of its texels.
//!
//! In: a level of a space. Out: twice the lag at which the autocorrelation of the features falls to ½, along the axis
//! where that is longer. ρ(d) = 1 − E‖F(x) − F(x + d)‖² / E‖F(x) − F(y)‖², where x and y are any two texels; the
//! distances of textons come from Φ.

use crate::exemplar::space::{Features, SpaceLevel};

/// Where the autocorrelation is this or less, a feature has ended; a hair more, against rounding.
const HALF: f64 = 0.5 + 1e-6;

/// The size of a level's features in its texels, from 1 to the longer side; 1 where all texels are alike.
pub fn feature_size(level: &SpaceLevel) -> u32 {
    let (height, width) = (level.grid.height, level.grid.width);
    let by_chance = distance_by_chance(level);
    if by_chance <= 0.0 {
        return 1;
    }
    let ends = |[drow, dcol]: [i32; 2], lag: u32| {
        let distance = distance_at(level, drow * lag as i32, dcol * lag as i32);
        1.0 - distance / by_chance <= HALF
    };
    let longest = |step: [i32; 2], side: u32| {
        let lag = (1..=side / 2).find(|&lag| ends(step, lag));
        lag.unwrap_or(side.div_ceil(2))
    };
    let lag = longest([1, 0], height).max(longest([0, 1], width));
    (2 * lag).clamp(1, height.max(width))
}

/// The mean squared distance of two texels so many rows and columns apart, of those that are on the grid.
fn distance_at(level: &SpaceLevel, drow: i32, dcol: i32) -> f64 {
    let grid = level.grid;
    let (mut sum, mut pairs) = (0.0, 0_u32);
    for row in 0..i64::from(grid.height) {
        for col in 0..i64::from(grid.width) {
            let there = grid.texel_at(row + i64::from(drow), col + i64::from(dcol));
            if let Some(there) = there {
                let here = grid.texel(row as u32, col as u32);
                sum += squared_distance(level, here.index(), there.index());
                pairs += 1;
            }
        }
    }
    sum / f64::from(pairs.max(1))
}

fn squared_distance(level: &SpaceLevel, a: usize, b: usize) -> f64 {
    match &level.features {
        Features::Textons { labels, gram } => {
            let [a, b] = [a, b].map(|texel| usize::from(labels[texel]));
            f64::from(gram[(a, a)]) + f64::from(gram[(b, b)]) - 2.0 * f64::from(gram[(a, b)])
        }
        Features::Plain(vectors) => {
            let width = level.grid.width as usize;
            let [a, b] =
                [a, b].map(|texel| vectors.slice(ndarray::s![texel / width, texel % width, ..]));
            let pairs = a.iter().zip(b);
            pairs.map(|(x, y)| f64::from(x - y).powi(2)).sum()
        }
    }
}

/// The mean squared distance of any two texels: twice the variance.
fn distance_by_chance(level: &SpaceLevel) -> f64 {
    let texels = level.grid.len() as f64;
    let (mean_square, square_of_mean) = match &level.features {
        Features::Textons { labels, gram } => {
            let mut shares = vec![0.0; gram.nrows()];
            for &label in labels {
                shares[usize::from(label)] += 1.0 / texels;
            }
            let own = shares.iter().enumerate();
            let own: f64 = own.map(|(i, share)| share * f64::from(gram[(i, i)])).sum();
            let products = gram.indexed_iter();
            let products = products.map(|((i, j), &dot)| shares[i] * shares[j] * f64::from(dot));
            (own, products.sum::<f64>())
        }
        Features::Plain(vectors) => {
            let squares = vectors.iter().map(|&number| f64::from(number).powi(2));
            let dimensions = vectors.dim().2;
            let mut mean = vec![0.0; dimensions];
            for (at, &number) in vectors.iter().enumerate() {
                mean[at % dimensions] += f64::from(number) / texels;
            }
            let of_mean = mean.iter().map(|number| number * number).sum();
            (squares.sum::<f64>() / texels, of_mean)
        }
    };
    // What rounding leaves of a constant sample is nothing.
    let variance = mean_square - square_of_mean;
    match variance > 1e-6 * mean_square {
        true => 2.0 * variance,
        false => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use ndarray::{Array2, Array3};

    use super::*;
    use crate::grid::TexelGrid;

    #[test]
    fn features_are_half_as_wide_as_stripes() {
        // Stripes of 8: at a lag of 2 every fourth texel has changed, of any two every second differs.
        for (tileable, expected) in [(true, 4), (false, 6)] {
            let stripe = |(_, col, _): (usize, usize, usize)| (col / 8 % 2) as f32;
            let level = SpaceLevel {
                grid: TexelGrid {
                    width: 32,
                    height: 1,
                    tileable,
                },
                features: Features::Plain(Array3::from_shape_fn((1, 32, 1), stripe)),
            };
            assert_eq!(feature_size(&level), expected);
        }
    }

    #[test]
    fn textons_are_compared_through_their_products() {
        let grid = TexelGrid {
            width: 16,
            height: 2,
            tileable: true,
        };
        let level = |labels: fn(u32) -> u16| SpaceLevel {
            grid,
            features: Features::Textons {
                labels: (0..32).map(|texel| labels(texel % 16)).collect(),
                gram: Array2::from_shape_fn((3, 3), |(i, j)| f32::from(u8::from(i == j))),
            },
        };
        assert_eq!(feature_size(&level(|col| u16::from(col >= 8))), 4);
        assert_eq!(feature_size(&level(|_| 1)), 1);
    }
}
