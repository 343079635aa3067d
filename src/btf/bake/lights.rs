//! The lights of a bake, put in order for the rays: those that stand over the same heading share
//! one walk over the surface, those before a point share one evaluation of its reflection.
//!
//! In: light directions. Out: per heading the lights from the lowest up, and the directions
//! coordinate by coordinate. Over a height field a light is shadowed whenever a higher one over the
//! same heading is, so a walk that raises its slope at every obstacle finds how many are.

use glam::{DVec2, DVec3};

use crate::btf::bake::brdf::Columns;
use crate::btf::direction::Direction;

/// Headings closer than this are one, radians.
const SAME_HEADING: f64 = 1e-9;
/// The least horizontal part of a direction: it keeps the slope of a light overhead finite.
const LEAST_HORIZONTAL: f64 = 1e-12;

/// The lights of a bake.
pub(super) struct Lights {
    /// In the order they were given in.
    pub(super) lamps: Vec<Lamp>,
    /// The same, by heading.
    pub(super) headings: Vec<Heading>,
    /// The same, coordinate by coordinate.
    pub(super) directions: Columns,
    /// The least α² of highlights under each; `None`: as the material has them.
    pub(super) least_alpha_squared: Option<Vec<f32>>,
    /// Those by which `--samples auto` decides; none with a fixed number of samples.
    pub(super) pilots: Vec<usize>,
}

/// Lights in one vertical half plane.
pub(super) struct Heading {
    /// Its direction over the mean plane, of unit length.
    pub(super) direction: DVec2,
    /// What the lights' directions rise by along it, ascending.
    pub(super) slopes: Vec<f64>,
    /// Which lights they are.
    pub(super) members: Vec<usize>,
}

/// A light with the frame of its disc.
pub(super) struct Lamp {
    /// Towards the middle of the disc.
    pub(super) direction: DVec3,
    tangent: DVec3,
    bitangent: DVec3,
}

impl Lights {
    pub(super) fn new(directions: &[Direction]) -> Self {
        Self {
            lamps: directions.iter().map(|&light| Lamp::new(light)).collect(),
            headings: headings(directions),
            directions: directions.iter().map(|light| light.0.as_vec3()).collect(),
            least_alpha_squared: None,
            pilots: Vec::new(),
        }
    }
}

fn headings(directions: &[Direction]) -> Vec<Heading> {
    let mut by_slope: Vec<(usize, DVec2, f64)> = directions
        .iter()
        .enumerate()
        .map(|(light, direction)| {
            let along = direction.0.truncate();
            let slope = direction.0.z / along.length().max(LEAST_HORIZONTAL);
            (light, along.normalize_or(DVec2::X), slope)
        })
        .collect();
    by_slope.sort_by(|a, b| a.2.total_cmp(&b.2));
    let mut found: Vec<Heading> = Vec::new();
    for (light, direction, slope) in by_slope {
        let same = |heading: &&mut Heading| {
            heading.direction.distance_squared(direction) < SAME_HEADING * SAME_HEADING
        };
        match found.iter_mut().find(same) {
            Some(heading) => {
                heading.slopes.push(slope);
                heading.members.push(light);
            }
            None => found.push(Heading {
                direction,
                slopes: vec![slope],
                members: vec![light],
            }),
        }
    }
    found
}

impl Lamp {
    fn new(light: Direction) -> Self {
        let (tangent, bitangent) = light.0.any_orthonormal_pair();
        Self {
            direction: light.0,
            tangent,
            bitangent,
        }
    }

    /// The direction to `place` on the disc, and what makes the whole disc's irradiance one at
    /// normal incidence; `radius` is half the angle the disc is seen under, radians.
    #[inline]
    pub(super) fn aim(&self, place: DVec2, radius: f64) -> (DVec3, f32) {
        let cos = (1.0 - place.length_squared()).max(0.0).sqrt();
        let direction = cos * self.direction + place.x * self.tangent + place.y * self.bitangent;
        // The mean cosine over the disc's solid angle.
        (direction, (2.0 / (1.0 + radius.cos())) as f32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::btf::direction_set::DirectionSet;

    #[test]
    fn every_light_stands_over_one_heading_the_lowest_first() {
        let directions = DirectionSet::Tong12x5.directions().unwrap();
        let lights = Lights::new(&directions);
        assert_eq!(lights.headings.len(), 12);
        let mut seen: Vec<usize> = Vec::new();
        for heading in &lights.headings {
            assert!(heading.slopes.is_sorted());
            for (&slope, &member) in heading.slopes.iter().zip(&heading.members) {
                let rebuilt = heading.direction.extend(slope).normalize();
                assert!((rebuilt - directions[member].0).length() < 1e-12);
            }
            seen.extend(&heading.members);
        }
        seen.sort_unstable();
        assert_eq!(seen, (0..60).collect::<Vec<_>>());
        let overhead = Lights::new(&[Direction(DVec3::Z)]);
        assert!(overhead.headings[0].slopes[0].is_finite());
    }
}
