//! The mask of a blend texture (Zhang 2003 §4.3): between the masks of two textures, as the transition goes.
//!
//! In: two masks of one size and the transition. Out: a mask that is the first's where the transition is 0 and
//! the second's where it is 1. M = F·M₁ + (1 − F)·M₀ is a diagonal slice through the masks laid over each other;
//! it is blurred and cut at a threshold.
//!
//! Deviation: the blur narrows towards both ends, by 4F(1 − F), so that the blend meets both textures; the
//! paper blurs alike everywhere. Masks of more than two labels are blended label by label, and the greatest
//! share decides; the paper has binary masks.

use ndarray::Array2;
use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::exemplar::controls::MASK_LABELS;

/// The widest blur, in pixels.
pub const WIDEST_BLUR: f64 = 64.0;
/// How far a Gaussian is summed, in deviations.
const REACH: f64 = 3.0;

/// How the masks are joined.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum Joining {
    /// The diagonal slice
    #[default]
    Slice,
    /// Their mean, the same everywhere (fig. 7, bottom row): for comparison
    Average,
}

/// The options of a blend of masks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BlendOptions {
    /// How the masks are joined.
    pub joining: Joining,
    /// The deviation of the Gaussian, in pixels.
    pub blur: f64,
    /// The share of the greater label from which on a pixel has it, with two labels.
    pub threshold: f64,
}

impl Default for BlendOptions {
    fn default() -> Self {
        Self {
            joining: Joining::Slice,
            blur: 2.0,
            threshold: 0.5,
        }
    }
}

impl BlendOptions {
    /// Checks every field by itself.
    pub fn validate(&self) -> Result<()> {
        if !(0.0..=WIDEST_BLUR).contains(&self.blur) {
            let expected = format!("0 to {WIDEST_BLUR} pixels");
            return Err(Error::option("blur", self.blur.to_string(), expected));
        }
        if !(self.threshold > 0.0 && self.threshold < 1.0) {
            let found = self.threshold.to_string();
            return Err(Error::option("threshold", found, "a share between 0 and 1"));
        }
        Ok(())
    }
}

/// The mask between two. Errors: sizes that differ, and options out of range.
pub fn blended_mask(
    masks: [&Array2<u8>; 2],
    transition: &Array2<f32>,
    options: &BlendOptions,
) -> Result<Array2<u8>> {
    options.validate()?;
    let (rows, cols) = transition.dim();
    // Check the sizes.
    for mask in masks {
        if mask.dim() != transition.dim() {
            let (height, width) = mask.dim();
            return Err(Error::data("mask", format!("{width}×{height}"))
                .expected(format!("{cols}×{rows}, the transition's size")));
        }
    }
    // Join the masks, label by label.
    let labels = labels_of(masks);
    let shares: Vec<Array2<f32>> = labels
        .iter()
        .map(|&label| joined(masks, transition, (label, options.joining)))
        .collect();
    // Blur each, and take the label of the largest share.
    let deviation = |row: usize, col: usize| match options.joining {
        Joining::Average => options.blur,
        Joining::Slice => {
            let share = f64::from(transition[[row, col]]);
            options.blur * 4.0 * share * (1.0 - share)
        }
    };
    let of_row = |row: usize| -> Vec<u8> {
        let pixel = |col: usize| {
            let blurred = |share: &Array2<f32>| blurred(share, (row, col), deviation(row, col));
            match labels[..] {
                [only] => only,
                [less, greater] => match f64::from(blurred(&shares[1])) > options.threshold {
                    true => greater,
                    false => less,
                },
                _ => labels[greatest(shares.iter().map(blurred))],
            }
        };
        (0..cols).map(pixel).collect()
    };
    let labels: Vec<u8> = (0..rows).into_par_iter().flat_map_iter(of_row).collect();
    Ok(Array2::from_shape_fn((rows, cols), |(row, col)| {
        labels[row * cols + col]
    }))
}

fn labels_of(masks: [&Array2<u8>; 2]) -> Vec<u8> {
    let there = |label: &u8| {
        masks
            .iter()
            .any(|mask| mask.iter().any(|other| other == label))
    };
    (0..MASK_LABELS).filter(there).collect()
}

/// The share of a label at each pixel.
fn joined(
    [first, second]: [&Array2<u8>; 2],
    transition: &Array2<f32>,
    (label, joining): (u8, Joining),
) -> Array2<f32> {
    Array2::from_shape_fn(transition.dim(), |at| {
        let weight = match joining {
            Joining::Slice => transition[at],
            Joining::Average => 0.5,
        };
        let has = |mask: &Array2<u8>| f32::from(u8::from(mask[at] == label));
        (1.0 - weight) * has(first) + weight * has(second)
    })
}

/// The mean round a pixel, weighted by a Gaussian; beyond the border nothing counts.
fn blurred(values: &Array2<f32>, (row, col): (usize, usize), deviation: f64) -> f32 {
    let reach = (REACH * deviation).floor() as usize;
    if reach == 0 {
        return values[[row, col]];
    }
    let (rows, cols) = values.dim();
    let weight = |away: usize| (-((away * away) as f64) / (2.0 * deviation * deviation)).exp();
    let weights: Vec<f64> = (0..=reach).map(weight).collect();
    let (mut sum, mut total) = (0.0, 0.0);
    for other in row.saturating_sub(reach)..(row + reach + 1).min(rows) {
        for at in col.saturating_sub(reach)..(col + reach + 1).min(cols) {
            let weight = weights[other.abs_diff(row)] * weights[at.abs_diff(col)];
            sum += weight * f64::from(values[[other, at]]);
            total += weight;
        }
    }
    (sum / total) as f32
}

/// The place of the greatest number; of equals the first.
fn greatest(numbers: impl Iterator<Item = f32>) -> usize {
    let mut best = (f32::NEG_INFINITY, 0);
    for (place, number) in numbers.enumerate() {
        if number > best.0 {
            best = (number, place);
        }
    }
    best.1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vary::key_values::ramp;

    fn checks(side: usize, labels: [u8; 2]) -> Array2<u8> {
        Array2::from_shape_fn((24, 64), |(row, col)| labels[(row / side + col / side) % 2])
    }

    #[test]
    fn both_ends_are_the_two_masks() {
        for labels in [[0, 1], [2, 3]] {
            let masks = [&checks(4, [0, 1]), &checks(6, labels)];
            for (at, mask) in [(0.0, masks[0]), (1.0, masks[1])] {
                let constant = Array2::from_elem((24, 64), at);
                let found = blended_mask(masks, &constant, &BlendOptions::default()).unwrap();
                assert_eq!(&found, mask);
            }
            let found = blended_mask(
                masks,
                &ramp((24, 64), 0.0, (0.25, 0.75)),
                &BlendOptions::default(),
            );
            let found = found.unwrap();
            for row in 0..24 {
                assert!((0..16).all(|col| found[[row, col]] == masks[0][[row, col]]));
                assert!((48..64).all(|col| found[[row, col]] == masks[1][[row, col]]));
            }
        }
    }

    #[test]
    fn without_blur_the_nearer_end_decides() {
        let masks = [&checks(4, [0, 1]), &checks(6, [0, 1])];
        let transition = ramp((24, 64), 0.0, (0.0, 1.0));
        let options = BlendOptions {
            blur: 0.0,
            ..BlendOptions::default()
        };
        let found = blended_mask(masks, &transition, &options).unwrap();
        for ((row, col), label) in found.indexed_iter() {
            let nearer = masks[usize::from(transition[[row, col]] > 0.5)];
            assert_eq!(*label, nearer[[row, col]]);
        }
        // The mean is the same everywhere: both labels where either has them.
        let mean = BlendOptions {
            joining: Joining::Average,
            threshold: 0.4,
            ..options
        };
        let found = blended_mask(masks, &transition, &mean).unwrap();
        for (at, label) in found.indexed_iter() {
            assert_eq!(*label, masks[0][at].max(masks[1][at]));
        }
    }

    #[test]
    fn what_cannot_be_is_refused() {
        let small = Array2::zeros((4, 4));
        let masks = [&checks(4, [0, 1]), &small];
        let transition = ramp((24, 64), 0.0, (0.0, 1.0));
        let said = |options: BlendOptions| {
            blended_mask(masks, &transition, &options)
                .unwrap_err()
                .to_string()
        };
        let default = BlendOptions::default();
        assert!(said(default).contains("mask: 4×4; expected 64×24"));
        assert!(
            said(BlendOptions {
                blur: -1.0,
                ..default
            })
            .contains("--blur")
        );
        assert!(
            said(BlendOptions {
                threshold: 1.0,
                ..default
            })
            .contains("--threshold")
        );
    }
}
