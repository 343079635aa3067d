//! Dilation and erosion of the labels of a mask (Zhang 2003 §4.2 and §4.3), by a radius that may differ from
//! pixel to pixel.
//!
//! In: a mask, the labels that grow or shrink, the radius at each pixel. Out: a mask. A pixel that is gained
//! takes the label of the nearest pixel that has one of the labels; one that is lost takes that of the
//! nearest pixel outside. What lies beyond the image's border is not known and changes nothing.

use std::str::FromStr;

use ndarray::Array2;

use crate::vary::label_set::LabelSet;
use crate::vary::nearest_pixel::{Axis, nearest_pixels};

/// The largest radius, in pixels.
pub const LARGEST_RADIUS: f32 = 4096.0;

/// Whether features grow or shrink.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Operation {
    /// They grow.
    Dilate,
    /// They shrink.
    Erode,
}

/// An operation with its radius, the same at every pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Edit {
    /// What is done.
    pub operation: Operation,
    /// In pixels.
    pub radius: f32,
    /// The labels that grow or shrink.
    pub labels: LabelSet,
}

impl Edit {
    /// The mask after the operation.
    pub fn apply(&self, mask: &Array2<u8>) -> Array2<u8> {
        let radius = |_, _| self.radius;
        morph(mask, self.operation, (self.labels, Axis::Both), radius)
    }
}

impl FromStr for Edit {
    type Err = String;

    /// Reads `dilate:RADIUS` or `erode:RADIUS`, with `:LABELS` behind it for some labels only.
    fn from_str(text: &str) -> Result<Self, String> {
        let mut parts = text.split(':');
        let operation = match parts.next() {
            Some("dilate") => Operation::Dilate,
            Some("erode") => Operation::Erode,
            _ => return Err("expected dilate:RADIUS or erode:RADIUS, as erode:1.5".into()),
        };
        let radius = parts.next().and_then(|number| number.parse::<f32>().ok());
        let in_range = |radius: &f32| *radius >= 0.0 && *radius <= LARGEST_RADIUS;
        let Some(radius) = radius.filter(in_range) else {
            return Err(format!("expected a radius of 0 to {LARGEST_RADIUS} pixels"));
        };
        let labels = parts.next().map_or(Ok(LabelSet::FEATURES), str::parse)?;
        match parts.next() {
            Some(more) => Err(format!("`:{more}` behind the labels")),
            None => Ok(Self {
                operation,
                radius,
                labels,
            }),
        }
    }
}

/// Grows or shrinks labels along axes by the radius at each pixel (row, column).
pub fn morph(
    mask: &Array2<u8>,
    operation: Operation,
    (labels, axis): (LabelSet, Axis),
    radius: impl Fn(usize, usize) -> f32,
) -> Array2<u8> {
    let dilates = operation == Operation::Dilate;
    // What spreads: the features, or what surrounds them.
    let spreading = mask.mapv(|label| labels.has(label) == dilates);
    let nearest = nearest_pixels(&spreading, axis);
    Array2::from_shape_fn(mask.dim(), |(row, col)| match nearest[[row, col]] {
        Some((distance, pixel)) if distance <= radius(row, col) => mask[pixel],
        _ => mask[[row, col]],
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rectangle(rows: std::ops::Range<usize>, cols: std::ops::Range<usize>) -> Array2<u8> {
        Array2::from_shape_fn((20, 24), |(row, col)| {
            u8::from(rows.contains(&row) && cols.contains(&col))
        })
    }

    fn edit(text: &str, mask: &Array2<u8>) -> Array2<u8> {
        text.parse::<Edit>().unwrap().apply(mask)
    }

    #[test]
    fn rectangles_lose_and_gain_a_border() {
        let mask = rectangle(5..15, 6..18);
        assert_eq!(edit("erode:1", &mask), rectangle(6..14, 7..17));
        assert_eq!(edit("erode:2.9", &mask), rectangle(7..13, 8..16));
        assert_eq!(edit("erode:5", &mask), rectangle(0..0, 0..0));
        assert_eq!(edit("erode:0", &mask), mask);
        // Corners are round.
        let grown = edit("dilate:2", &mask);
        assert_eq!((grown[[3, 10]], grown[[2, 10]]), (1, 0));
        assert_eq!((grown[[4, 5]], grown[[3, 4]]), (1, 0));
        assert_eq!(edit("erode:2", &grown), mask);
    }

    #[test]
    fn discs_change_their_radius() {
        let disc = |radius: f64| {
            Array2::from_shape_fn((41, 41), |(row, col)| {
                u8::from((row as f64 - 20.0).hypot(col as f64 - 20.0) <= radius)
            })
        };
        let area = |mask: &Array2<u8>| mask.iter().map(|&label| f64::from(label)).sum::<f64>();
        for (text, expected) in [("dilate:4", 14.0), ("erode:4", 6.0)] {
            let found = (area(&edit(text, &disc(10.0))) / std::f64::consts::PI).sqrt();
            assert!((found - expected).abs() < 0.4, "{text} {found}");
        }
    }

    #[test]
    fn along_an_axis_rows_stay_apart() {
        let mask = rectangle(5..15, 6..18);
        let by_column = |_: usize, col: usize| if col < 12 { 2.0 } else { 0.0 };
        let set = (LabelSet::FEATURES, Axis::Horizontal);
        let thinner = morph(&mask, Operation::Erode, set, by_column);
        assert_eq!(thinner, rectangle(5..15, 8..18));
    }

    #[test]
    fn lost_and_gained_pixels_take_the_nearest_label() {
        let mask = ndarray::arr2(&[[3, 3, 1, 1, 1, 2, 2]]);
        let only = |text: &str| edit(text, &mask).into_raw_vec_and_offset().0;
        assert_eq!(only("erode:1:1"), [3, 3, 3, 1, 2, 2, 2]);
        assert_eq!(only("dilate:1:1"), [3, 1, 1, 1, 1, 1, 2]);
        assert_eq!(only("dilate:9:1+2"), [1, 1, 1, 1, 1, 2, 2]);
    }

    #[test]
    fn edits_that_cannot_be_are_refused() {
        for wrong in [
            "",
            "open:1",
            "erode",
            "erode:-1",
            "erode:nan",
            "erode:1:7",
            "erode:1:1:2",
        ] {
            assert!(wrong.parse::<Edit>().is_err(), "{wrong}");
        }
    }
}
