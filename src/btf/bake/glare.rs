//! Whether the light of a sample sits in a few of its values.
//!
//! A highlight narrower than the steps between the lights is met by few texels for few pairs of view and
//! light, and there it is very bright: images averaged from such a sample sparkle, and its mean says nothing.
//! Before a bake, some texels are shaded for some views under all lights to find that out.

use glam::Vec3;
use rayon::prelude::*;

use crate::btf::bake::brdf::Columns;
use crate::btf::bake::directions::{Directions, View};
use crate::btf::bake::lights::Lights;
use crate::btf::bake::shade::BakeScene;
use crate::progress::Progress;

/// Views that are tried at most, spread over all.
const VIEWS: usize = 6;
/// Texels that are tried at most, spread over all.
const TEXELS: usize = 1024;
/// The share of the values that is held against the rest.
const BRIGHTEST: f64 = 0.01;
/// Fewer values than this say nothing about a hundredth of them.
const LEAST_VALUES: usize = 1000;
/// When they carry more than this share of the light, the sample is warned of.
const MOST: f64 = 0.8;

/// How unevenly the light of a sample is spread.
pub(super) struct Glare {
    /// Share of all light in the brightest hundredth of the values.
    pub(super) share: f64,
    /// Values that were looked at.
    values: usize,
}

impl Glare {
    /// Shades the texels that are tried.
    pub(super) fn of(scene: &BakeScene, directions: &Directions, progress: Progress<'_>) -> Self {
        let all_lights = |view: usize| {
            let view = directions.view(view);
            let all = (0..directions.lights.len()).collect();
            (view, directions.lights(view, all))
        };
        let views: Vec<(View, Lights)> = spread(directions.views.len(), VIEWS)
            .map(all_lights)
            .collect();
        let texels = spread(scene.material.grid.len(), TEXELS);
        let tries: Vec<(&(View, Lights), usize)> = views
            .iter()
            .flat_map(|view| texels.clone().map(move |texel| (view, texel)))
            .collect();
        let width = scene.material.grid.width as usize;
        let shaded = |&((view, lights), texel): &(&(View, Lights), usize)| {
            let (mut radiance, mut scratch) = (
                vec![Vec3::ZERO; directions.lights.len()],
                Columns::default(),
            );
            if !progress.is_interrupted() {
                let place = (texel / width, texel % width);
                scene.shade_texel(*view, place, lights, (&mut radiance, &mut scratch));
            }
            radiance.into_iter().map(|color| color.element_sum())
        };
        let values: Vec<f32> = tries.par_iter().flat_map_iter(shaded).collect();
        Self {
            values: values.len(),
            share: share_of_brightest(values),
        }
    }

    /// What a user should know before the bake.
    pub(super) fn objection(&self) -> Option<String> {
        (self.share > MOST && self.values >= LEAST_VALUES).then(|| {
            format!(
                "{:.0} % of the light is in 1 % of the values: highlights are narrower than the steps \
                 between the lights and will sparkle; --angular-filter on or --min-roughness 0.2 widens them \
                 (or more lights, or --light-diameter with --samples)",
                100.0 * self.share
            )
        })
    }
}

/// At most `most` of `count` places, spread evenly.
fn spread(count: usize, most: usize) -> impl Iterator<Item = usize> + Clone {
    let taken = count.min(most);
    (0..taken).map(move |index| index * count / taken)
}

fn share_of_brightest(mut values: Vec<f32>) -> f64 {
    values.sort_unstable_by(|a, b| b.total_cmp(a));
    let sum = |values: &[f32]| values.iter().map(|&value| f64::from(value)).sum::<f64>();
    let brightest = (values.len() as f64 * BRIGHTEST).ceil() as usize;
    let all = sum(&values);
    match all > 0.0 {
        true => sum(&values[..brightest]) / all,
        false => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_share_of_the_brightest_is_counted() {
        let mut values = vec![1.0; 198];
        values.extend([99.0, 99.0]);
        assert!((share_of_brightest(values) - 0.5).abs() < 1e-9);
        assert!((share_of_brightest(vec![1.0; 100]) - 0.01).abs() < 1e-9);
        assert_eq!(share_of_brightest(vec![0.0; 10]), 0.0);
    }

    #[test]
    fn places_are_spread_over_all() {
        assert_eq!(spread(10, 4).collect::<Vec<_>>(), [0, 2, 5, 7]);
        assert_eq!(spread(2, 4).collect::<Vec<_>>(), [0, 1]);
    }
}
