//! The directions of a `.btf` file: per view its angles and all its lights, in radians.

use std::f64::consts::FRAC_PI_2;

use crate::btf::bonn::fields::Fields;
use crate::btf::bonn::output::Output;
use crate::btf::direction::Direction;
use crate::btf::direction_set::first_repeated;
use crate::error::{Error, Result};

/// How far beyond the horizon rounding may put a direction, in radians.
const SLACK: f64 = 1e-3;
/// How far the lights of one view may be from those of the first, in radians, without a note.
const SAME_LIGHT: f64 = 1e-3;

/// Directions that are compared with each other at most.
const MOST_COMPARED: usize = 4096;

/// Every view with every light.
#[derive(Clone, Debug, PartialEq)]
pub struct Sampling {
    /// Views.
    pub views: Vec<Direction>,
    /// Lights.
    pub lights: Vec<Direction>,
}

impl Sampling {
    /// Images in all.
    pub fn images(&self) -> usize {
        self.views.len() * self.lights.len()
    }

    /// Reads the directions. The lights of the first view count, as in other readers; a note says where later ones
    /// differ.
    pub(super) fn read(fields: &mut Fields, notes: &mut Vec<String>) -> Result<Self> {
        let count = fields.u32("number of views")?;
        check_count("number of views", count, fields.left() / 12)?;
        let mut sampling = Self {
            views: Vec::with_capacity(count as usize),
            lights: Vec::new(),
        };
        let mut differing = None;
        // Read the directions view by view.
        for view in 0..count as usize {
            let place = format!("view {view}");
            let angles = fields.float_array::<2>(&place)?;
            sampling.views.push(direction(&place, angles)?);
            let angles = read_lights(fields, &place)?;
            if view == 0 {
                let lights = angles.iter().enumerate();
                sampling.lights = lights
                    .map(|(light, &angles)| direction(&format!("light {light}"), angles))
                    .collect::<Result<_>>()?;
            }
            // Require as many lights of every view.
            let (found, wanted) = (angles.len(), sampling.lights.len());
            if found != wanted {
                return Err(
                    Error::data(format!("{place}: number of lights"), found.to_string()).expected(
                        format!("{wanted}, as view 0 has: one set of lights for all views"),
                    ),
                );
            }
            if differing.is_none() && !same(&sampling.lights, &angles) {
                differing = Some(view);
            }
        }
        // Tell what is read otherwise than it stands.
        if let Some(view) = differing {
            notes.push(format!(
                "the lights of view {view} differ from those of view 0; those of view 0 are taken for all views"
            ));
        }
        for (kind, set) in [("view", &sampling.views), ("light", &sampling.lights)] {
            let repeated = (set.len() <= MOST_COMPARED).then(|| first_repeated(set));
            if let Some(at) = repeated.flatten() {
                notes.push(format!(
                    "{kind} {at} repeats an earlier one, which counts in its place"
                ));
            }
        }
        Ok(sampling)
    }

    /// Writes the directions, the lights once per view.
    pub(super) fn write(&self, output: &mut Output<'_>) -> Result<()> {
        output.u32(self.views.len())?;
        let lights: Vec<f32> = self.lights.iter().copied().flat_map(angles).collect();
        for &view in &self.views {
            output.floats(&angles(view))?;
            output.u32(self.lights.len())?;
            output.floats(&lights)?;
        }
        Ok(())
    }
}

/// The angles of the lights of one view.
fn read_lights(fields: &mut Fields, place: &str) -> Result<Vec<[f32; 2]>> {
    let field = format!("{place}: number of lights");
    let count = fields.u32(&field)?;
    check_count(&field, count, fields.left() / 8)?;
    let angles = fields.floats(&format!("{place}: lights"), u64::from(count) * 2)?;
    Ok(angles.as_chunks::<2>().0.to_vec())
}

fn check_count(field: &str, count: u32, most: u64) -> Result<()> {
    match u64::from(count) {
        0 => Err(Error::data(field, "0").expected("at least 1")),
        count if count > most => Err(Error::data(field, count.to_string())
            .expected(format!("at most {most}: the file is no longer"))),
        _ => Ok(()),
    }
}

fn direction(place: &str, [theta, phi]: [f32; 2]) -> Result<Direction> {
    let theta = f64::from(theta);
    if !(-SLACK..=FRAC_PI_2 + SLACK).contains(&theta) {
        return Err(
            Error::data(format!("{place}: polar angle"), format!("{theta} radians"))
                .expected("0 to π/2: directions point away from the surface"),
        );
    }
    Ok(Direction::from_angles(
        theta.clamp(0.0, FRAC_PI_2),
        f64::from(phi),
    ))
}

fn angles(direction: Direction) -> [f32; 2] {
    [direction.theta() as f32, direction.phi() as f32]
}

fn same(lights: &[Direction], angles: &[[f32; 2]]) -> bool {
    lights.iter().zip(angles).all(|(light, &[theta, phi])| {
        let other = Direction::from_angles(f64::from(theta), f64::from(phi));
        light.angle_to(other) <= SAME_LIGHT
    })
}
