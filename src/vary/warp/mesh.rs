//! Warping by a mesh (Gomes 1998): corners of a regular mesh follow the features near them, and pixels follow
//! the corners of their quadrilateral, bilinearly.
//!
//! A corner's way back is the mean of what all features say, weighted by 1/(d² + 1)², d the distance to the
//! feature's centre in pixels: nearly that of the nearest feature, and nothing half way between two that shrink.

use glam::DVec2;
use ndarray::Array2;

use crate::vary::warp::motion::Moved;

/// The side of a quadrilateral, in pixels.
const CELL: usize = 4;

/// The source of every point of an image of (rows, columns).
pub fn sources(moved: &[Moved], (rows, cols): (usize, usize)) -> impl Fn(DVec2) -> DVec2 + use<> {
    let corners = (rows.div_ceil(CELL) + 1, cols.div_ceil(CELL) + 1);
    let ways = Array2::from_shape_fn(corners, |(row, col)| {
        let corner = DVec2::new((col * CELL) as f64, (row * CELL) as f64);
        way_back(moved, corner)
    });
    move |point: DVec2| {
        let place = (point / CELL as f64).max(DVec2::ZERO);
        let (last_row, last_col) = (ways.nrows() - 2, ways.ncols() - 2);
        let (row, col) = (
            (place.y as usize).min(last_row),
            (place.x as usize).min(last_col),
        );
        let (u, v) = (place.x - col as f64, place.y - row as f64);
        let upper = ways[[row, col]].lerp(ways[[row, col + 1]], u);
        let lower = ways[[row + 1, col]].lerp(ways[[row + 1, col + 1]], u);
        point + upper.lerp(lower, v)
    }
}

fn way_back(moved: &[Moved], corner: DVec2) -> DVec2 {
    let (mut sum, mut weights) = (DVec2::ZERO, 0.0);
    for feature in moved {
        let weight = (corner.distance_squared(feature.target) + 1.0).powi(-2);
        sum += weight * (feature.source_of(corner) - corner);
        weights += weight;
    }
    if weights > 0.0 {
        sum / weights
    } else {
        DVec2::ZERO
    }
}
