//! Where the samples of a texel look through, and when it has enough of them.
//!
//! With `--samples auto` each texel of each view takes samples until its mean settles. The mean is looked at after 2,
//! 4, 8 … samples, under a few lights spread over the set (the pilots). The mean of half of the samples against that of
//! all says how far it still moves; what is left is about half of that. A texel is done when it is at most the wanted
//! error times the average of its own radiance and that of the whole sample: dark texels need not be exact for
//! themselves, and the sum of all errors keeps to the wanted share of the sum of all radiance. The decision depends on
//! view and texel alone, not on how images are grouped, nor on threads.

use glam::{DVec2, Vec3};

use crate::btf::bake::directions::MOST_PILOTS;
use crate::btf::bake::lights::Lights;
use crate::btf::bake::samples::{AUTO_LEAST, Samples};

/// Where samples look through, and when a texel has enough of them.
pub(super) struct SamplePlan {
    /// The most that a texel takes, in order, relative to its centre.
    pub(super) places: Vec<DVec2>,
    refinement: Option<Refinement>,
}

/// When a texel has enough samples.
#[derive(Clone, Copy, Debug)]
struct Refinement {
    /// The relative error that is wanted.
    error: f32,
    /// Radiance under all pilots together, mean over the sample, channels added.
    typical: f32,
}

impl SamplePlan {
    /// The same number everywhere.
    pub(super) fn fixed(count: u32) -> Self {
        Self {
            places: Samples::Fixed(count).places(),
            refinement: None,
        }
    }

    /// As many as each texel needs for a relative error; `typical` is the radiance under all pilots together, mean over
    /// the sample, channels added.
    pub(super) fn refined(error: f64, typical: f32) -> Self {
        Self {
            places: Samples::Auto.places(),
            refinement: Some(Refinement {
                error: error as f32,
                typical,
            }),
        }
    }

    /// Whether texels take as many samples as they need.
    pub(super) fn is_refined(&self) -> bool {
        self.refinement.is_some()
    }

    /// The course of one texel's samples.
    pub(super) fn course(&self) -> Option<Course> {
        self.refinement.map(|refinement| Course {
            refinement,
            means: [Vec3::ZERO; MOST_PILOTS],
            change: 0.0,
        })
    }
}

/// How a texel's mean under the pilots has moved so far.
pub(super) struct Course {
    refinement: Refinement,
    means: [Vec3; MOST_PILOTS],
    change: f32,
}

impl Course {
    /// Whether a texel that took so many samples, with these sums of radiance, has enough.
    pub(super) fn is_done(&mut self, taken: u32, sums: &[Vec3], lights: &Lights) -> bool {
        if !taken.is_power_of_two() {
            return false;
        }
        let (mut change, mut level) = (0.0, 0.0);
        for (mean, &pilot) in self.means.iter_mut().zip(&lights.pilots) {
            let new = sums[pilot] / taken as f32;
            change += (new - *mean).abs().element_sum();
            level += new.element_sum();
            *mean = new;
        }
        // Two halves may agree by chance. So the change before counts too, halved as it should have been.
        let left = 0.5 * change.max(0.5 * self.change);
        self.change = change;
        let Refinement { error, typical } = self.refinement;
        taken >= AUTO_LEAST && left <= 0.5 * error * (level + typical)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::btf::direction::Direction;

    /// How many samples of these values a texel takes, with an error of 0.1 and a typical radiance of 3.
    fn taken(value: impl Fn(u32) -> f32) -> u32 {
        let mut lights = Lights::new(&[Direction(glam::DVec3::Z)]);
        lights.pilots = vec![0];
        let plan = SamplePlan::refined(0.1, 3.0);
        let mut course = plan.course().unwrap();
        let mut sum = Vec3::ZERO;
        for index in 0..plan.places.len() as u32 {
            sum += Vec3::splat(value(index));
            if course.is_done(index + 1, &[sum], &lights) {
                return index + 1;
            }
        }
        plan.places.len() as u32
    }

    #[test]
    fn texels_take_samples_until_their_mean_settles() {
        assert_eq!(taken(|_| 1.0), 4);
        // What is dark beside the rest need not settle by itself.
        assert_eq!(taken(|index| 0.05 * f32::from(u8::from(index % 4 == 0))), 4);
        // Halves that differ at 4 samples and agree at 8: once more, lest they agree by chance.
        assert_eq!(taken(|index| f32::from(u8::from((index / 2) % 2 == 0))), 16);
        // A single bright sample among many is averaged down.
        let spark = |index| if index == 2 { 10.0 } else { 1.0 };
        let count = taken(spark);
        assert!((64..=256).contains(&count), "{count}");
        // What never settles ends all the same.
        assert_eq!(taken(|index| (index * index) as f32), 256);
    }

    #[test]
    fn fixed_plans_have_no_course() {
        let plan = SamplePlan::fixed(5);
        assert_eq!((plan.places.len(), plan.is_refined()), (5, false));
        assert!(plan.course().is_none());
    }
}
