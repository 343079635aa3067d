//! Highlights no narrower than the spacing of the directions.
//!
//! A sample has images for some directions only. A highlight narrower than the steps between them is caught by one
//! image or by none: interpolated, it shows as patches with straight borders and as ghosts. So the microfacet
//! distribution is widened for each pair of view and light, as a texture is filtered before it is sampled (Kaplanyan,
//! Hill, Patney, Lefohn 2016, "Filtering distributions of normals for shading antialiasing"): all half vectors that
//! the cells of the two directions give rise to lie within the widened lobe. Shadows and the diffuse base stay as they
//! are.

mod cells;

use clap::ValueEnum;
use glam::DMat3;

use crate::btf::bake::angular::cells::{LEAST_DIRECTIONS, second_moments};
use crate::btf::bake::material::Material;
use crate::btf::direction::Direction;
use crate::error::{Error, Result};

/// The least α² of a lobe, over the variance of the half vectors in the cells.
const WIDTH: f64 = 1.0;
/// Half vectors spread without bound as view and light come to lie opposite each other at the horizon; they are taken
/// to spread no more than at 60° from the half vector.
const LEAST_COSINE: f64 = 0.5;
/// `auto` widens when at least this share of the texels is too glossy.
const GLOSSY_SHARE: f64 = 0.01;
/// Views, and lights, that are looked at to tell how wide highlights have to be.
const LOOKED_AT: usize = 64;

/// Whether highlights are widened to the spacing of the directions.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum AngularFilter {
    /// Only if the material is glossier than the sets of directions can represent.
    Auto,
    /// Wherever a lobe is narrower than the spacing.
    On,
    /// Never: every image is exact for its own directions.
    Off,
}

/// How wide highlights have to be for each pair of view and light.
#[derive(Clone, Debug)]
pub(super) struct Widening {
    views: Vec<Cell>,
    lights: Vec<Cell>,
}

/// A direction and the second moments of its cell, in square radians.
type Cell = (Direction, DMat3);

impl Widening {
    /// The widening that is asked for, or that `auto` finds needed; `None`: none at all.
    pub(super) fn choose(
        choice: AngularFilter,
        material: &Material,
        views: &[Direction],
        lights: &[Direction],
    ) -> Result<Option<Self>> {
        let refused = |found: &str, expected: &str| {
            let error = Error::option("angular-filter", found, expected);
            match choice {
                AngularFilter::On => Err(error),
                _ => Ok(None),
            }
        };
        if choice == AngularFilter::Off {
            return Ok(None);
        }
        let Some(roughness) = &material.roughness else {
            return refused("on, for a matte material", "a material with roughness");
        };
        if views.len().max(lights.len()) < LEAST_DIRECTIONS {
            let needed = format!("at least {LEAST_DIRECTIONS} views or lights, or off");
            return refused("on, for few directions", &needed);
        }
        let widening = Self::over(views, lights);
        let least = widening.typical_roughness();
        let glossy = roughness.iter().filter(|&&r| f64::from(r) < least).count();
        let is_needed = glossy as f64 >= GLOSSY_SHARE * roughness.len() as f64;
        Ok((choice == AngularFilter::On || is_needed).then_some(widening))
    }

    fn over(views: &[Direction], lights: &[Direction]) -> Self {
        let cells = |directions: &[Direction]| {
            let moments = second_moments(directions);
            directions.iter().copied().zip(moments).collect()
        };
        Self {
            views: cells(views),
            lights: cells(lights),
        }
    }

    /// The least α² of highlights in the image of a view and a light.
    pub(super) fn least_alpha_squared(&self, view: usize, light: usize) -> f64 {
        let ((view, view_moment), (light, light_moment)) = (self.views[view], self.lights[light]);
        let moment = view_moment + light_moment;
        let half = (view.0 + light.0).normalize_or_zero();
        // h = (v + l)/|v + l|, so dh is what of dv + dl lies across h, over 2 h·l.
        let trace = moment.x_axis.x + moment.y_axis.y + moment.z_axis.z;
        let across = trace - half.dot(moment * half);
        let cos = half.dot(light.0).max(LEAST_COSINE);
        // The slopes of GGX's facets vary by α²/2 along each of two axes, those of the half vectors by across/2.
        WIDTH * across / (4.0 * cos * cos)
    }

    /// The median over pairs of the roughness that highlights have at least.
    pub(super) fn typical_roughness(&self) -> f64 {
        let spread = |count: usize| {
            let step = count.div_ceil(LOOKED_AT);
            (0..count).step_by(step.max(1))
        };
        let mut least: Vec<f64> = spread(self.views.len())
            .flat_map(|view| spread(self.lights.len()).map(move |light| (view, light)))
            .map(|(view, light)| self.least_alpha_squared(view, light))
            .collect();
        let middle = least.len() / 2;
        let (_, median, _) = least.select_nth_unstable_by(middle, f64::total_cmp);
        // α is the roughness squared.
        median.powf(0.25)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::btf::bake::presets::Preset;
    use crate::btf::direction_set::DirectionSet;
    use crate::progress::Progress;

    fn directions(set: &str) -> Vec<Direction> {
        set.parse::<DirectionSet>().unwrap().directions().unwrap()
    }

    /// The slow way: half vectors of directions drawn from both cells.
    fn variance_of_half_vectors(set: &[Direction], view: usize, light: usize) -> f64 {
        use glam::DVec3;
        use rand::Rng;
        let mut random = crate::random::stream(4, "cells", 0, 0);
        let mut draw = |index: usize| loop {
            let mut number = || random.gen_range(-1.0..1.0);
            let place = DVec3::new(number(), number(), number());
            if place.z < 0.0 || place.length() > 1.0 || place.length() < 0.1 {
                continue;
            }
            let place = place.normalize();
            let nearer = |other: &Direction| other.0.dot(place) > set[index].0.dot(place);
            if !set.iter().any(nearer) {
                return place;
            }
        };
        let centre = (set[view].0 + set[light].0).normalize();
        let count = 2000;
        let mut sum = 0.0;
        for _ in 0..count {
            let half = (draw(view) + draw(light)).normalize();
            sum += half.angle_between(centre).powi(2);
        }
        sum / f64::from(count)
    }

    #[test]
    fn lobes_are_as_wide_as_the_half_vectors_spread() {
        let set = directions("fibonacci:60");
        let widening = Widening::over(&set, &set);
        for (view, light) in [(3, 5), (10, 20), (7, 40)] {
            let found = widening.least_alpha_squared(view, light) / WIDTH;
            let wanted = variance_of_half_vectors(&set, view, light);
            let ratio = found / wanted;
            assert!(
                (0.8..1.25).contains(&ratio),
                "{view} {light}: {found} {wanted}"
            );
        }
    }

    #[test]
    fn denser_directions_hold_glossier_materials() {
        let roughness = |set: &str| {
            let set = directions(set);
            Widening::over(&set, &set).typical_roughness()
        };
        let (few, many) = (roughness("fibonacci:40"), roughness("fibonacci:640"));
        // Four times finer spacing: α a quarter, roughness a half.
        assert!((few / many - 2.0).abs() < 0.1, "{few} {many}");
    }

    #[test]
    fn auto_widens_what_is_too_glossy_alone() {
        let set = directions("12x5");
        let chosen = |preset: Preset, choice| {
            let material = preset.material(16, 1, Progress::silent()).unwrap();
            Widening::choose(choice, &material, &set, &set)
        };
        assert!(
            chosen(Preset::Scales, AngularFilter::Auto)
                .unwrap()
                .is_some()
        );
        assert!(
            chosen(Preset::Scales, AngularFilter::Off)
                .unwrap()
                .is_none()
        );
        assert!(chosen(Preset::Bark, AngularFilter::Auto).unwrap().is_none());
        assert!(chosen(Preset::Bark, AngularFilter::On).unwrap().is_some());
    }

    #[test]
    fn few_directions_and_matte_materials_are_left_alone() {
        let (few, many) = (directions("rings:30:5"), directions("12x5"));
        let mut material = Preset::Scales.material(16, 1, Progress::silent()).unwrap();
        let refused = |material: &Material, views: &[Direction]| {
            let chosen = |choice| Widening::choose(choice, material, views, &few);
            assert!(chosen(AngularFilter::Auto).unwrap().is_none());
            chosen(AngularFilter::On).unwrap_err().to_string()
        };
        assert!(refused(&material, &few).contains("at least 6"));
        material.roughness = None;
        assert!(refused(&material, &many).contains("roughness"));
    }
}
