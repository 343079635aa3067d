//! The range in which a channel's numbers are drawn and exported, `low` to `high`.
//!
//! In: the kind of a channel, its numbers, and what its file stored. Out: two bounds that hold all
//! numbers. Colours, masks, alphas and all integers keep 0 to 1, widened where numbers lie outside;
//! heights in floats keep their least and greatest; normals keep the range that stands for −1 to 1.

use crate::exemplar::channels::ChannelKind;
use crate::format::image::Precision;

/// `low` and `high` of a channel's `numbers`, `count` per texel.
pub(super) fn value_range(
    kind: ChannelKind,
    numbers: &[f32],
    count: usize,
    precision: Precision,
) -> (f64, f64) {
    let (least, most) = bounds(numbers);
    match (kind, precision) {
        (ChannelKind::Height, Precision::Float) if least < most => (least, most),
        (ChannelKind::Height, Precision::Float) => (least, next_above(least)),
        (ChannelKind::Normal, Precision::Float) if is_signed(numbers, count) => {
            let largest = most.max(-least).max(1.0);
            (-largest, largest)
        }
        _ => (least.min(0.0), most.max(1.0)),
    }
}

fn bounds(numbers: &[f32]) -> (f64, f64) {
    let numbers = numbers.iter().map(|&number| f64::from(number));
    numbers.fold(
        (f64::INFINITY, f64::NEG_INFINITY),
        |(least, most), number| (least.min(number), most.max(number)),
    )
}

/// The upper bound of numbers that are all `value`.
fn next_above(value: f64) -> f64 {
    value + value.abs().max(1.0)
}

/// Whether normals stand in −1 to 1 rather than in 0 to 1: any number is negative, or their lengths are
/// nearer to 1 as they stand.
fn is_signed(numbers: &[f32], count: usize) -> bool {
    if numbers.iter().any(|&number| number < 0.0) {
        return true;
    }
    // Two numbers leave the length open: 0 to 1 is what most files hold.
    if count < 3 {
        return false;
    }
    let off = |decode: &dyn Fn(f32) -> f32| -> f64 {
        let vectors = numbers.chunks_exact(count);
        let squared = vectors.map(|v| v.iter().map(|&n| decode(n) * decode(n)).sum::<f32>());
        squared
            .map(|squared| f64::from(squared.sqrt() - 1.0).abs())
            .sum()
    };
    off(&|number| number) < off(&|number| 2.0 * number - 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(kind: ChannelKind, numbers: &[f32], precision: Precision) -> (f64, f64) {
        let count = if kind == ChannelKind::Normal { 3 } else { 1 };
        value_range(kind, numbers, count, precision)
    }

    #[test]
    fn shares_keep_0_to_1_and_heights_their_own_range() {
        use ChannelKind::{Alpha, Color, Height};
        assert_eq!(of(Color, &[0.25, 0.5], Precision::Float), (0.0, 1.0));
        assert_eq!(of(Color, &[-0.25, 2.5], Precision::Float), (-0.25, 2.5));
        assert_eq!(of(Alpha, &[0.25], Precision::Bits8), (0.0, 1.0));
        assert_eq!(of(Height, &[0.25, 0.5], Precision::Bits16), (0.0, 1.0));
        assert_eq!(of(Height, &[-3.0, 0.5], Precision::Float), (-3.0, 0.5));
        // A flat height still has a range.
        assert_eq!(of(Height, &[0.25, 0.25], Precision::Float), (0.25, 1.25));
        assert_eq!(of(Height, &[-8.0], Precision::Float), (-8.0, 0.0));
    }

    #[test]
    fn normals_keep_what_stands_for_minus_1_to_1() {
        let normal = |numbers: &[f32], precision| of(ChannelKind::Normal, numbers, precision);
        assert_eq!(normal(&[0.5, 0.5, 1.0], Precision::Bits8), (0.0, 1.0));
        assert_eq!(normal(&[0.5, 0.5, 1.0], Precision::Float), (0.0, 1.0));
        assert_eq!(normal(&[-0.6, 0.0, 0.8], Precision::Float), (-1.0, 1.0));
        assert_eq!(normal(&[0.6, 0.0, 0.8], Precision::Float), (-1.0, 1.0));
        assert_eq!(normal(&[-0.5, 0.0, 1.25], Precision::Float), (-1.25, 1.25));
    }
}
