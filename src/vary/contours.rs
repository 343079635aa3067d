//! The features of a mask: their contours (Suzuki and Abe 1985), by which warps know them, and their centres.
//!
//! In: a mask and the labels that count as features. Out: 8-connected features, each with the border that
//! encloses it, the borders of its holes, and the mean of its pixels.

use image::{GrayImage, Luma};
use imageproc::contours::{BorderType, find_contours};
use ndarray::Array2;

use crate::vary::label_set::LabelSet;

/// One connected feature.
#[derive(Clone, Debug, PartialEq)]
pub struct Feature {
    /// Its outer border, (row, column), clockwise from its first pixel.
    pub contour: Vec<[u32; 2]>,
    /// The borders of its holes.
    pub holes: Vec<Vec<[u32; 2]>>,
    /// The mean (row, column) of its pixels' centres, in pixels from the first pixel's centre.
    pub centre: [f64; 2],
    /// Its pixels.
    pub area: u32,
    /// The label most of its border has; of equally common ones the smallest.
    pub label: u8,
}

/// All features of a mask.
#[derive(Clone, Debug, PartialEq)]
pub struct MaskFeatures {
    /// Row by row, by their first pixels.
    pub list: Vec<Feature>,
    /// The feature that each pixel belongs to.
    pub owner: Array2<Option<u32>>,
}

impl MaskFeatures {
    /// The features of some labels, whatever their labels among each other.
    pub fn of(mask: &Array2<u8>, labels: LabelSet) -> Self {
        let owner = connected(&mask.mapv(|label| labels.has(label)));
        let count = owner.iter().flatten().max().map_or(0, |&last| last + 1);
        let mut sums = vec![([0.0, 0.0], 0_u32); count as usize];
        for ((row, col), owner) in owner.indexed_iter() {
            if let Some(owner) = owner {
                let (place, area) = &mut sums[*owner as usize];
                place[0] += row as f64;
                place[1] += col as f64;
                *area += 1;
            }
        }
        let feature = |(place, area): ([f64; 2], u32)| Feature {
            contour: Vec::new(),
            holes: Vec::new(),
            centre: place.map(|sum| sum / f64::from(area)),
            area,
            label: 0,
        };
        let mut list: Vec<Feature> = sums.into_iter().map(feature).collect();
        for (border, points) in borders(&owner) {
            let Some(Some(of)) = points.first().map(|at| owner[at.map(|at| at as usize)]) else {
                continue;
            };
            let feature = &mut list[of as usize];
            match border {
                BorderType::Outer => {
                    feature.label =
                        commonest(points.iter().map(|at| mask[at.map(|at| at as usize)]));
                    feature.contour = points;
                }
                BorderType::Hole => feature.holes.push(points),
            }
        }
        Self { list, owner }
    }
}

/// The borders of all features. The library does not see a border on the image's own: a row and a column
/// more are laid round.
fn borders(owner: &Array2<Option<u32>>) -> Vec<(BorderType, Vec<[u32; 2]>)> {
    let (height, width) = owner.dim();
    let mut image = GrayImage::new(width as u32 + 2, height as u32 + 2);
    for ((row, col), owner) in owner.indexed_iter() {
        if owner.is_some() {
            image.put_pixel(col as u32 + 1, row as u32 + 1, Luma([255]));
        }
    }
    let contours = find_contours::<u32>(&image).into_iter();
    let inside = |contour: imageproc::contours::Contour<u32>| {
        let points = contour.points.iter().map(|at| [at.y - 1, at.x - 1]);
        (contour.border_type, points.collect())
    };
    contours.map(inside).collect()
}

/// The 8-connected parts of a set, numbered by their first pixels.
fn connected(set: &Array2<bool>) -> Array2<Option<u32>> {
    let (height, width) = set.dim();
    let mut owner = Array2::from_elem((height, width), None);
    let (mut count, mut open) = (0, Vec::new());
    for (first, _) in set.indexed_iter().filter(|(_, inside)| **inside) {
        if owner[first].is_some() {
            continue;
        }
        owner[first] = Some(count);
        open.push(first);
        while let Some((row, col)) = open.pop() {
            for near_row in row.saturating_sub(1)..(row + 2).min(height) {
                for near_col in col.saturating_sub(1)..(col + 2).min(width) {
                    let near = (near_row, near_col);
                    if set[near] && owner[near].is_none() {
                        owner[near] = Some(count);
                        open.push(near);
                    }
                }
            }
        }
        count += 1;
    }
    owner
}

fn commonest(labels: impl Iterator<Item = u8>) -> u8 {
    let mut counts = [0_u32; 256];
    labels.for_each(|label| counts[usize::from(label)] += 1);
    let most = counts.iter().max().copied().unwrap_or(0);
    counts.iter().position(|&count| count == most).unwrap_or(0) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rectangles_have_their_border_centre_and_area() {
        // One touches the image's corner, one has a hole.
        let within = |at: usize, from: usize, to: usize| at >= from && at < to;
        let mask = Array2::from_shape_fn((12, 16), |(row, col)| {
            let in_ring = within(row, 4, 9) && within(col, 7, 12) && (row, col) != (6, 9);
            u8::from(row < 3 && col < 4) + 2 * u8::from(in_ring)
        });
        let MaskFeatures { list, owner } = MaskFeatures::of(&mask, LabelSet::FEATURES);
        assert_eq!(list.len(), 2);
        let [corner, ring] = [&list[0], &list[1]];
        assert_eq!(
            (corner.area, corner.label, corner.contour.len()),
            (12, 1, 10)
        );
        assert_eq!(corner.centre, [1.0, 1.5]);
        assert!(corner.holes.is_empty());
        assert_eq!((ring.area, ring.label, ring.contour.len()), (24, 2, 16));
        assert_eq!(ring.centre, [6.0, 9.0]);
        assert_eq!(ring.holes.len(), 1);
        assert_eq!(ring.holes[0].len(), 4);
        assert_eq!(
            (owner[[2, 3]], owner[[6, 9]], owner[[8, 11]]),
            (Some(0), None, Some(1))
        );
        let second = MaskFeatures::of(&mask, LabelSet::of(2));
        assert_eq!(second.list.len(), 1);
        assert!(MaskFeatures::of(&mask, LabelSet::of(3)).list.is_empty());
    }

    #[test]
    fn a_disc_has_a_round_contour() {
        let mask = Array2::from_shape_fn((31, 31), |(row, col)| {
            u8::from((row as f64 - 15.0).hypot(col as f64 - 14.0) <= 9.0)
        });
        let MaskFeatures { list, .. } = MaskFeatures::of(&mask, LabelSet::FEATURES);
        assert_eq!((list.len(), list[0].centre), (1, [15.0, 14.0]));
        for [row, col] in &list[0].contour {
            let radius = (f64::from(*row) - 15.0).hypot(f64::from(*col) - 14.0);
            assert!(radius > 7.9 && radius <= 9.0, "{radius}");
        }
        // Corner to corner is connected.
        let stairs = Array2::from_shape_fn((4, 4), |(row, col)| u8::from(row == col));
        assert_eq!(MaskFeatures::of(&stairs, LabelSet::FEATURES).list.len(), 1);
    }
}
