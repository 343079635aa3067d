//! Cameras and lamps at a stated place: how far directions differ over the patch.
//!
//! A sample has one direction for all texels of an image: that at the patch's centre. From a camera or a lamp
//! that is near, the corners of the patch see it under others.

use glam::DVec3;
use serde_json::{Value, json};

use crate::btf::direction::Direction;
use crate::btf::import::image_table::ImageTable;
use crate::btf::import::list_options::{Handedness, PatchSize};
use crate::error::{Error, Result};

/// From this on, the spread is worth a warning of its own, in degrees.
const WIDE_DEG: f64 = 5.0;

/// What the user is told where images are resampled.
pub(super) const RESAMPLED: &str =
    "images are resampled to the directions at the patch's centre (--near-field)";

/// The largest angles between the direction at the centre and that at a corner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Spread {
    patch: PatchSize,
    view_deg: f64,
    light_deg: f64,
}

impl Spread {
    /// The spread as a field of `btf.json`.
    pub(super) fn fact(&self) -> (String, Value) {
        let fact = json!({ "view": self.view_deg, "light": self.light_deg });
        ("spread_deg".into(), fact)
    }
}

/// The spread over a patch; `None` where its size is not said.
pub(super) fn spread(table: &ImageTable, patch: Option<PatchSize>) -> Result<Option<Spread>> {
    let Some(patch) = patch else {
        return Ok(None);
    };
    if table.cameras.is_none() && table.lights.is_none() {
        return Err(without_positions("patch-mm"));
    }
    let of = |positions: &Option<Vec<DVec3>>| {
        let positions = positions.iter().flatten();
        positions
            .map(|&from| from_corners(from, patch))
            .fold(0.0, f64::max)
    };
    Ok(Some(Spread {
        patch,
        view_deg: of(&table.cameras),
        light_deg: of(&table.lights),
    }))
}

/// Says that an option for positions is of no use.
pub(super) fn without_positions(option: &str) -> Error {
    Error::option(
        option,
        "the list has no positions in mm",
        "a table with camera_x_mm or light_x_mm, or no size of the patch",
    )
}

/// Whether images are to be resampled: the user asks for it beyond a limit in degrees, and the spread is larger.
pub(super) fn is_beyond(spread: &Option<Spread>, limit_deg: Option<f64>) -> Result<bool> {
    match (spread, limit_deg) {
        (_, None) => Ok(false),
        (_, Some(limit)) if !(0.0..=90.0).contains(&limit) => Err(Error::option(
            "near-field",
            limit.to_string(),
            "0 to 90 degrees",
        )),
        (None, Some(_)) => {
            let found = "given without the size of the patch";
            Err(Error::option("near-field", found, "--patch-mm WxH too"))
        }
        (Some(spread), Some(limit)) => Ok(spread.view_deg.max(spread.light_deg) > limit),
    }
}

/// Where cameras and lamps stood, for resampling.
#[derive(Clone, Debug, PartialEq)]
pub struct NearPositions {
    /// The sides of the patch.
    pub patch: PatchSize,
    /// Per image of the list, in millimetres from the patch's centre; `None` where all are far away.
    pub cameras: Option<Vec<DVec3>>,
    /// The same of the lamps.
    pub lamps: Option<Vec<DVec3>>,
}

impl NearPositions {
    /// The positions of a table over a patch, in the sample's frame.
    pub(super) fn of(table: &ImageTable, patch: PatchSize, handedness: Handedness) -> Self {
        let turned = |positions: &Option<Vec<DVec3>>| {
            let turn = |at: &DVec3| handedness.applied_to(Direction(*at)).0;
            positions.as_ref().map(|all| all.iter().map(turn).collect())
        };
        Self {
            patch,
            cameras: turned(&table.cameras),
            lamps: turned(&table.lights),
        }
    }
}

/// What the user should know of positions.
pub(super) fn note(table: &ImageTable, spread: &Option<Spread>) -> Option<String> {
    if table.cameras.is_none() && table.lights.is_none() {
        return None;
    }
    Some(match spread {
        None => "directions are those at the patch's centre; --patch-mm WxH reports how much they differ over it".into(),
        Some(Spread { patch, view_deg, light_deg }) => {
            let wide = match view_deg.max(*light_deg) > WIDE_DEG {
                true => {
                    ": one direction per image is coarse for this patch; --near-field resamples the images"
                }
                false => "",
            };
            format!(
                "directions are those at the patch's centre; over {patch} mm views differ from it by up to \
                 {view_deg:.2}°, lights by up to {light_deg:.2}°{wide}"
            )
        }
    })
}

/// The largest angle, in degrees, between the way to a place from the centre and that from a corner.
fn from_corners(place: DVec3, patch: PatchSize) -> f64 {
    let toward = |from: DVec3| Direction((place - from).normalize());
    let corners = [(-0.5, -0.5), (0.5, -0.5), (-0.5, 0.5), (0.5, 0.5)];
    let angle = |(x, y): (f64, f64)| {
        let corner = DVec3::new(x * patch.width, y * patch.height, 0.0);
        toward(DVec3::ZERO).angle_to(toward(corner)).to_degrees()
    };
    corners.into_iter().map(angle).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::btf::import::image_table::parse;

    #[test]
    fn the_spread_is_that_of_the_farthest_corner() {
        let text = "file,camera_x_mm,camera_y_mm,camera_z_mm,light_theta_deg,light_phi_deg\na,0,0,500,0,0\n";
        let table = parse(text).unwrap();
        let patch: PatchSize = "60x80".parse().unwrap();
        let found = spread(&table, Some(patch)).unwrap();
        let expected = (50.0_f64 / 500.0).atan().to_degrees();
        assert!((found.unwrap().view_deg - expected).abs() < 1e-9);
        assert_eq!(found.unwrap().light_deg, 0.0);
        let told = note(&table, &found).unwrap();
        assert!(
            told.contains("60x80 mm") && told.contains("coarse"),
            "{told}"
        );
        assert!(note(&table, &None).unwrap().contains("--patch-mm"));
    }

    #[test]
    fn resampling_is_asked_for_beyond_a_limit() {
        let text = "file,camera_x_mm,camera_y_mm,camera_z_mm,light_theta_deg,light_phi_deg\na,0,5,500,0,0\n";
        let table = parse(text).unwrap();
        let patch: PatchSize = "60x80".parse().unwrap();
        let found = spread(&table, Some(patch)).unwrap();
        assert!(!is_beyond(&found, None).unwrap() && !is_beyond(&found, Some(8.0)).unwrap());
        assert!(is_beyond(&found, Some(2.0)).unwrap());
        assert!(
            is_beyond(&None, Some(2.0))
                .unwrap_err()
                .to_string()
                .contains("--patch-mm")
        );
        assert!(is_beyond(&found, Some(-1.0)).is_err());
        let positions = NearPositions::of(&table, patch, Handedness::Left);
        assert_eq!(positions.cameras, Some(vec![DVec3::new(0.0, -5.0, 500.0)]));
        assert_eq!(positions.lamps, None);
    }

    #[test]
    fn a_patch_without_positions_is_refused() {
        let text = "file,view_theta_deg,view_phi_deg,light_theta_deg,light_phi_deg\na,0,0,0,0\n";
        let table = parse(text).unwrap();
        assert_eq!(note(&table, &None), None);
        let error = spread(&table, Some("6x8".parse().unwrap())).unwrap_err();
        assert!(error.to_string().contains("--patch-mm"));
    }
}
