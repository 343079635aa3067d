//! Warping by radial basis functions (Gomes 1998): the way back of every pixel interpolates those of feature
//! points, the centres and points of the contours.

use glam::DVec2;

use crate::error::{Error, Result};
use crate::radial_basis::MOST_PLACES;
use crate::vary::planar_basis::{PlanarBasis, usual_radius};
use crate::vary::warp::motion::Moved;

/// Contour points of a feature.
const POINTS: usize = 12;
/// The radius of the functions over the way from a point to the nearest: pixels round a feature follow it.
const RADII: f64 = 2.0;
/// Points nearer to another than this are left out, in pixels.
const NEAR: f64 = 1.0;

/// The source of every point. Errors: more features than the system can be solved for.
pub fn sources(moved: &[Moved]) -> Result<impl Fn(DVec2) -> DVec2 + use<>> {
    if moved.len() > MOST_PLACES {
        return Err(Error::data("mask", format!("{} features", moved.len()))
            .expected(format!(
                "at most {MOST_PLACES} for a warp by radial basis functions"
            ))
            .advice("erode the mask, or warp by `mesh` or `field`"));
    }
    let of_each = (MOST_PLACES / moved.len().max(1))
        .saturating_sub(1)
        .min(POINTS);
    let (mut places, mut ways): (Vec<DVec2>, Vec<[f64; 2]>) = (Vec::new(), Vec::new());
    for feature in moved {
        let points = std::iter::once(feature.centre).chain(feature.contour_points(of_each));
        for point in points {
            let target = feature.target_of(point);
            if places.iter().all(|other| other.distance(target) >= NEAR) {
                places.push(target);
                ways.push((point - target).to_array());
            }
        }
    }
    let radius = RADII * usual_radius(&places, NEAR).max(NEAR);
    let field = PlanarBasis::new(places, &ways, radius)?;
    Ok(move |point: DVec2| point + DVec2::from_array(field.at(point)))
}
