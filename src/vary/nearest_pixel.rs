//! For every pixel the nearest pixel of a set: in the plane, along its row or along its column.
//!
//! In: a set of pixels. Out: the distance between centres, in pixels, and the nearest pixel; of equally near
//! ones that of the smaller flat index.

use image::{GrayImage, Luma};
use imageproc::distance_transform::euclidean_squared_distance_transform;
use ndarray::Array2;

/// Along which axes an operation works.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum Axis {
    /// Along the rows.
    Horizontal,
    /// Along the columns.
    Vertical,
    /// In the plane.
    #[default]
    Both,
}

/// A pixel (row, column) and its distance.
pub type Nearest = (f32, (usize, usize));

/// The nearest pixel of a set; `None` where there is none.
pub fn nearest_pixels(set: &Array2<bool>, axis: Axis) -> Array2<Option<Nearest>> {
    match axis {
        Axis::Horizontal => along_rows(set),
        Axis::Vertical => along_rows(&set.t().to_owned())
            .t()
            .mapv(|near| near.map(|(distance, (row, col))| (distance, (col, row)))),
        Axis::Both => in_the_plane(set),
    }
}

fn along_rows(set: &Array2<bool>) -> Array2<Option<Nearest>> {
    let (height, width) = set.dim();
    let mut nearest = Array2::from_elem((height, width), None);
    for row in 0..height {
        let mut last = None;
        for col in 0..width {
            last = if set[[row, col]] { Some(col) } else { last };
            nearest[[row, col]] = last.map(|at| ((col - at) as f32, (row, at)));
        }
        let mut next = None;
        for col in (0..width).rev() {
            next = if set[[row, col]] { Some(col) } else { next };
            let Some(at) = next else { continue };
            let distance = (at - col) as f32;
            if nearest[[row, col]].is_none_or(|(before, _)| distance < before) {
                nearest[[row, col]] = Some((distance, (row, at)));
            }
        }
    }
    nearest
}

/// The distances are the library's; the pixel is looked for where the distance says it is.
fn in_the_plane(set: &Array2<bool>) -> Array2<Option<Nearest>> {
    let (height, width) = set.dim();
    if !set.iter().any(|&inside| inside) {
        return Array2::from_elem((height, width), None);
    }
    let pixel = |x: u32, y: u32| Luma([u8::from(set[[y as usize, x as usize]]) * 255]);
    let image = GrayImage::from_fn(width as u32, height as u32, pixel);
    let squares = euclidean_squared_distance_transform(&image);
    Array2::from_shape_fn((height, width), |(row, col)| {
        let square = squares.get_pixel(col as u32, row as u32).0[0].round() as usize;
        let pixel = at_distance(set, (row, col), square)?;
        Some(((square as f32).sqrt(), pixel))
    })
}

/// The first pixel of the set at a squared distance from another.
fn at_distance(
    set: &Array2<bool>,
    (row, col): (usize, usize),
    square: usize,
) -> Option<(usize, usize)> {
    let (height, width) = set.dim();
    let reach = square.isqrt();
    for other in row.saturating_sub(reach)..(row + reach + 1).min(height) {
        let down = row.abs_diff(other);
        let across = square - down * down;
        let side = across.isqrt();
        if side * side != across {
            continue;
        }
        let columns = [col.checked_sub(side), Some(col + side)];
        let mut inside = columns.into_iter().flatten().filter(|&at| at < width);
        if let Some(at) = inside.find(|&at| set[[other, at]]) {
            return Some((other, at));
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random;
    use rand::Rng;

    /// Every pixel of the set is tried.
    fn slow(set: &Array2<bool>, axis: Axis, at: (usize, usize)) -> Option<Nearest> {
        let mut best: Option<Nearest> = None;
        for (other, _) in set.indexed_iter().filter(|(_, inside)| **inside) {
            let on_axis = match axis {
                Axis::Horizontal => other.0 == at.0,
                Axis::Vertical => other.1 == at.1,
                Axis::Both => true,
            };
            let (down, across) = (other.0.abs_diff(at.0), other.1.abs_diff(at.1));
            let distance = ((down * down + across * across) as f32).sqrt();
            if on_axis && best.is_none_or(|(least, _)| distance < least) {
                best = Some((distance, other));
            }
        }
        best
    }

    #[test]
    fn the_nearest_pixel_is_that_of_a_slow_search() {
        let mut stream = random::stream(5, "set", 0, 0);
        let set = Array2::from_shape_fn((9, 13), |_| stream.gen_range(0..12) == 0);
        for axis in [Axis::Horizontal, Axis::Vertical, Axis::Both] {
            for (at, found) in nearest_pixels(&set, axis).indexed_iter() {
                assert_eq!(*found, slow(&set, axis, at), "{axis:?} {at:?}");
            }
        }
    }

    #[test]
    fn of_an_empty_set_nothing_is_near() {
        let none = Array2::from_elem((3, 4), false);
        for axis in [Axis::Horizontal, Axis::Vertical, Axis::Both] {
            assert!(nearest_pixels(&none, axis).iter().all(Option::is_none));
        }
    }
}
