//! The images that are compared, as planes of luminance.

use glam::DVec3;
use rayon::prelude::*;

use crate::btf::description::Description;
use crate::btf::direction::{Direction, SAME_DIRECTION};
use crate::btf::sample::Sample;
use crate::error::{Error, Result};
use crate::progress::Progress;

/// Views that are compared, at most.
const MOST_VIEWS: usize = 32;
/// Lights under which they are compared, at most.
const MOST_LIGHTS: usize = 4;
/// Views lower than this from the normal see too little of what others see.
const LOWEST_VIEW: f64 = 61.0;
/// Lights between these angles from the normal show relief and cast short shadows.
const USEFUL_LIGHTS: [f64; 2] = [10.0, 50.0];
/// Views that lie as high as the highest to within this many degrees stand for the view from above.
const AS_HIGH: f64 = 1.0;
/// Fewer views say nothing of heights, fewer lights nothing of normals.
const FEWEST: usize = 3;

/// Which images are compared.
pub(super) struct Planes {
    /// Views near the zenith, by which lights are compared.
    top: Vec<usize>,
    /// Views and lights by which heights are found.
    pub views: Vec<usize>,
    pub lights: Vec<usize>,
}

/// Luminance under a light.
pub(super) struct LitPlane {
    /// Towards the light.
    pub light: DVec3,
    /// A number per texel.
    pub luminance: Vec<f32>,
}

impl Planes {
    /// Chooses images of a sample of every view with every light.
    pub fn choose(description: &Description) -> Result<Self> {
        // Check that there are enough directions.
        if description.pairs.is_some() {
            return Err(Error::data("layout", "a list of (view, light) pairs")
                .expected("every view with every light"));
        }
        let (views, lights) = (&description.views, &description.lights);
        for (field, directions) in [("views", views), ("lights", lights)] {
            let count = distinct(directions);
            if count < FEWEST {
                return Err(Error::data(field, format!("{count} distinct directions")).expected(
                    format!("at least {FEWEST}: heights are found by how texels change with the light, and how they move with the view"),
                ));
            }
        }
        // Take the views near the normal and the lights that shade well; without any, all.
        let degrees = |direction: &Direction| direction.theta().to_degrees();
        let highest = views.iter().map(degrees).fold(f64::INFINITY, f64::min);
        let all = |of: &[Direction], from: f64, to: f64| -> Vec<usize> {
            let within = |&at: &usize| (from..=to).contains(&degrees(&of[at]));
            (0..of.len()).filter(within).collect()
        };
        let mut high = all(views, 0.0, LOWEST_VIEW);
        if high.len() < FEWEST {
            high = (0..views.len()).collect();
        }
        let mut useful = all(lights, USEFUL_LIGHTS[0], USEFUL_LIGHTS[1]);
        if useful.is_empty() {
            useful = (0..lights.len()).collect();
        }
        Ok(Self {
            top: all(views, 0.0, highest + AS_HIGH),
            views: spread(&high, MOST_VIEWS),
            lights: spread(&useful, MOST_LIGHTS),
        })
    }

    /// The mean of the views near the zenith under every light: their parallax is small, and that of opposite ones
    /// cancels.
    pub fn under_all_lights(
        &self,
        sample: &Sample,
        progress: Progress<'_>,
    ) -> Result<Vec<LitPlane>> {
        let lights = &sample.description().lights;
        progress.begin("reading images", lights.len() as u64);
        let planes = lights.par_iter().enumerate().map(|(light, direction)| {
            let mut luminance = vec![0.0; sample.grid().len()];
            for &view in &self.top {
                let plane = read(sample, view, light)?;
                let share = 1.0 / self.top.len() as f32;
                luminance
                    .iter_mut()
                    .zip(plane)
                    .for_each(|(sum, value)| *sum += share * value);
            }
            progress.advance(1)?;
            Ok(LitPlane {
                light: direction.0,
                luminance,
            })
        });
        let planes = planes.collect::<Result<Vec<_>>>()?;
        progress.end();
        Ok(planes)
    }
}

/// The luminance of an image, a number per texel.
pub(super) fn read(sample: &Sample, view: usize, light: usize) -> Result<Vec<f32>> {
    let image = view * sample.description().lights.len() + light;
    let pixels = sample.image(image)?;
    let mut values = vec![0.0; pixels.len()];
    pixels.copy_to(&mut values);
    sample.check_image(image, &values)?;
    let (texels, _) = values.as_chunks::<3>();
    let luminance = |[r, g, b]: &[f32; 3]| 0.2126 * r + 0.7152 * g + 0.0722 * b;
    Ok(texels.iter().map(luminance).collect())
}

fn distinct(directions: &[Direction]) -> usize {
    let mut kept: Vec<Direction> = Vec::new();
    for direction in directions {
        if kept
            .iter()
            .all(|other| other.angle_to(*direction) >= SAME_DIRECTION)
        {
            kept.push(*direction);
        }
        if kept.len() == FEWEST {
            break;
        }
    }
    kept.len()
}

/// At most this many of a list, evenly spread over it.
fn spread(list: &[usize], most: usize) -> Vec<usize> {
    let count = most.min(list.len());
    (0..count).map(|at| list[at * list.len() / count]).collect()
}
