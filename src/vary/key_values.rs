//! Fields from key values (Zhang 2003 §4.1): a transition function and an orientation field of which the user
//! states a few values, interpolated by radial basis functions.
//!
//! Places are (column, row) of pixels from the upper left; a pixel's centre is its whole number.

use glam::DVec2;
use ndarray::{Array2, Array3};

use crate::error::{Error, Result};
use crate::vary::planar_basis::{PlanarBasis, usual_radius};

/// Interpolated vectors shorter than this have no direction.
const NO_DIRECTION: f64 = 1e-3;

/// A value that the user states.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Key {
    /// Column and row.
    pub place: DVec2,
    /// A transition, 0 to 1; or an angle in degrees, counter-clockwise from s.
    pub value: f64,
}

/// The transition that key values say, of (rows, columns) pixels; clamped to 0 to 1 between them. Without a
/// radius the mean way to the nearest key is taken. Errors: fewer than two keys, values outside 0 to 1,
/// different values at one place.
pub fn transition_of_keys(
    (rows, cols): (usize, usize),
    keys: &[Key],
    radius: Option<f64>,
) -> Result<Array2<f32>> {
    const OPTION: &str = "transition-key";
    let keys = different(OPTION, keys, (rows, cols))?;
    if let Some(key) = keys.iter().find(|key| !(0.0..=1.0).contains(&key.value)) {
        return Err(Error::option(
            OPTION,
            described(key),
            "a transition of 0 to 1",
        ));
    }
    if keys.len() < 2 {
        let found = format!("{} place with a value", keys.len());
        return Err(Error::option(
            OPTION,
            found,
            "two or more: one alone means no change",
        ));
    }
    let values: Vec<[f64; 1]> = keys.iter().map(|key| [key.value]).collect();
    let field = interpolant(&keys, &values, radius, cols)?;
    Ok(Array2::from_shape_fn((rows, cols), |(row, col)| {
        let [value] = field.at(DVec2::new(col as f64, row as f64));
        value.clamp(0.0, 1.0) as f32
    }))
}

/// The orientation that key angles say, unit vectors (s, t); one key turns everything. Where interpolated
/// vectors cancel, the nearest key decides.
pub fn orientation_of_keys(
    (rows, cols): (usize, usize),
    keys: &[Key],
    radius: Option<f64>,
) -> Result<Array3<f32>> {
    const OPTION: &str = "orientation-key";
    let keys = different(OPTION, keys, (rows, cols))?;
    if keys.is_empty() {
        return Err(Error::option(OPTION, "none", "one or more"));
    }
    let directions: Vec<[f64; 2]> = keys.iter().map(|key| direction(key.value)).collect();
    let field = interpolant(&keys, &directions, radius, cols)?;
    let mut orientation = Array3::zeros((rows, cols, 2));
    for (pixel, mut slot) in orientation.rows_mut().into_iter().enumerate() {
        let place = DVec2::new((pixel % cols) as f64, (pixel / cols) as f64);
        let [s, t] = field.at(place);
        let length = s.hypot(t);
        let [s, t] = match length < NO_DIRECTION {
            true => nearest(&keys, place).map_or([1.0, 0.0], |key| direction(key.value)),
            false => [s / length, t / length],
        };
        (slot[0], slot[1]) = (s as f32, t as f32);
    }
    Ok(orientation)
}

/// The same direction everywhere: s.
pub fn straight_orientation((rows, cols): (usize, usize)) -> Array3<f32> {
    Array3::from_shape_fn(
        (rows, cols, 2),
        |(_, _, axis)| if axis == 0 { 1.0 } else { 0.0 },
    )
}

/// A transition that grows evenly in a direction, in degrees counter-clockwise from s: 0 up to the share
/// `begin` of the way across the image, 1 from the share `end` on.
pub fn ramp((rows, cols): (usize, usize), degrees: f64, (begin, end): (f64, f64)) -> Array2<f32> {
    let [s, t] = direction(degrees);
    // Rows run against t. The way across is that of the corners' projections.
    let along = |row: f64, col: f64| s * col - t * row;
    let (bottom, right) = (rows as f64 - 1.0, cols as f64 - 1.0);
    let corners = [
        along(0.0, 0.0),
        along(0.0, right),
        along(bottom, 0.0),
        along(bottom, right),
    ];
    let least = corners.into_iter().fold(f64::INFINITY, f64::min);
    let most = corners.into_iter().fold(f64::NEG_INFINITY, f64::max);
    let way = (most - least).max(f64::MIN_POSITIVE);
    Array2::from_shape_fn((rows, cols), |(row, col)| {
        let share = (along(row as f64, col as f64) - least) / way;
        ((share - begin) / (end - begin)).clamp(0.0, 1.0) as f32
    })
}

/// Refuses a transition that says hardly any change: less than the tolerance of its use.
pub fn check_covers(transition: &Array2<f32>, tolerance: f64) -> Result<()> {
    let least = transition.iter().copied().fold(f32::INFINITY, f32::min);
    let most = transition.iter().copied().fold(f32::NEG_INFINITY, f32::max);
    match f64::from(most - least) >= tolerance {
        true => Ok(()),
        false => Err(Error::data("transition", format!("{least} to {most}"))
            .expected(format!(
                "a range of {tolerance} or more, the tolerance of a match"
            ))
            .advice("a transition from 0 to 1 shows the whole change")),
    }
}

fn direction(degrees: f64) -> [f64; 2] {
    let angle = degrees.to_radians();
    [angle.cos(), angle.sin()]
}

fn interpolant<const N: usize>(
    keys: &[Key],
    values: &[[f64; N]],
    radius: Option<f64>,
    alone: usize,
) -> Result<PlanarBasis<N>> {
    let places: Vec<DVec2> = keys.iter().map(|key| key.place).collect();
    let radius = radius.unwrap_or_else(|| usual_radius(&places, alone as f64));
    PlanarBasis::new(places, values, radius)
}

/// The keys without repetitions, each on the image. Errors: one that is not, and two at a place.
fn different(option: &str, keys: &[Key], (rows, cols): (usize, usize)) -> Result<Vec<Key>> {
    let mut kept: Vec<Key> = Vec::new();
    for key in keys {
        let DVec2 { x, y } = key.place;
        let on_image = (0.0..cols as f64).contains(&x) && (0.0..rows as f64).contains(&y);
        if !on_image || !key.value.is_finite() {
            let expected = format!("a place on the image of {cols}×{rows}, and a number");
            return Err(Error::option(option, described(key), expected));
        }
        match kept.iter().find(|other| other.place == key.place) {
            None => kept.push(*key),
            Some(other) if other.value == key.value => {}
            Some(other) => {
                return Err(Error::option(
                    option,
                    format!("{} and {}", described(other), described(key)),
                    "one value at a place",
                ));
            }
        }
    }
    Ok(kept)
}

fn described(key: &Key) -> String {
    format!("{} at {},{}", key.value, key.place.x, key.place.y)
}

fn nearest(keys: &[Key], place: DVec2) -> Option<&Key> {
    let way = |key: &&Key| key.place.distance(place);
    keys.iter().min_by(|a, b| way(a).total_cmp(&way(b)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn key(x: f64, y: f64, value: f64) -> Key {
        Key {
            place: DVec2::new(x, y),
            value,
        }
    }

    #[test]
    fn fields_meet_their_keys() {
        let keys = [
            key(2.0, 3.0, 0.0),
            key(20.0, 4.0, 1.0),
            key(9.0, 11.0, 0.25),
        ];
        let field = transition_of_keys((14, 24), &keys, None).unwrap();
        for key in keys {
            let found = field[[key.place.y as usize, key.place.x as usize]];
            assert!(
                (f64::from(found) - key.value).abs() < 1e-5,
                "{found} {key:?}"
            );
        }
        let turns = [key(2.0, 3.0, 30.0), key(20.0, 4.0, 120.0)];
        let field = orientation_of_keys((14, 24), &turns, Some(9.0)).unwrap();
        for key in turns {
            let at = |axis| field[[key.place.y as usize, key.place.x as usize, axis]];
            let degrees = f64::from(f32::atan2(at(1), at(0))).to_degrees();
            assert!((degrees - key.value).abs() < 1e-3, "{degrees}");
        }
        assert!(
            field
                .rows()
                .into_iter()
                .all(|v| (v[0].hypot(v[1]) - 1.0).abs() < 1e-5)
        );
        let one = orientation_of_keys((3, 3), &[key(1.0, 1.0, 90.0)], None).unwrap();
        assert!((one[[2, 0, 1]] - 1.0).abs() < 1e-6);
    }

    #[test]
    fn a_ramp_is_even() {
        let right = ramp((2, 5), 0.0, (0.0, 1.0));
        assert_eq!(right.row(1).to_vec(), [0.0, 0.25, 0.5, 0.75, 1.0]);
        let up = ramp((5, 2), 90.0, (0.25, 0.75));
        assert_eq!(up.column(0).to_vec(), [1.0, 1.0, 0.5, 0.0, 0.0]);
    }

    #[test]
    fn keys_that_contradict_are_refused() {
        let said = |keys: &[Key]| {
            let refused = transition_of_keys((8, 8), keys, None);
            refused.unwrap_err().to_string()
        };
        assert!(said(&[key(1.0, 1.0, 0.5)]).contains("two or more"));
        assert!(said(&[key(1.0, 1.0, 0.5); 2]).contains("1 place with a value"));
        assert!(said(&[key(1.0, 1.0, 0.5), key(2.0, 2.0, 1.5)]).contains("1.5 at 2,2"));
        assert!(
            said(&[key(1.0, 1.0, 0.5), key(1.0, 1.0, 0.6)]).contains("0.5 at 1,1 and 0.6 at 1,1")
        );
        assert!(said(&[key(1.0, 1.0, 0.5), key(8.0, 2.0, 0.0)]).contains("image of 8×8"));
        assert!(said(&[key(1.0, 1.0, 0.5), key(f64::NAN, 2.0, 0.0)]).contains("NaN,2"));
        assert!(orientation_of_keys((8, 8), &[], None).is_err());
    }

    #[test]
    fn a_transition_must_cover_the_tolerance() {
        assert!(check_covers(&ramp((2, 5), 0.0, (0.0, 1.0)), 0.1).is_ok());
        let flat = Array2::from_elem((3, 3), 0.5);
        let said = check_covers(&flat, 0.1).unwrap_err().to_string();
        assert!(
            said.contains("0.5 to 0.5; expected a range of 0.1"),
            "{said}"
        );
    }
}
