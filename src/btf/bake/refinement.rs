//! What `--samples auto` measures: how bright a sample is before it is baked, and what error is left afterwards.

use std::ops::Range;

use glam::Vec3;
use rayon::prelude::*;

use crate::btf::bake::brdf::Columns;
use crate::btf::bake::directions::{Directions, View};
use crate::btf::bake::lights::Lights;
use crate::btf::bake::sample_plan::SamplePlan;
use crate::btf::bake::samples::AUTO_LEAST;
use crate::btf::bake::shade::BakeScene;
use crate::error::Result;
use crate::progress::Progress;

/// Places, each a texel of a view, that are looked at.
const PLACES: usize = 256;
/// In small samples, one place stands for this many.
const LEAST_SHARE: usize = 16;
/// Samples per texel that stand for the truth.
const REFERENCE: u32 = 1024;

/// Radiance under all pilots together, mean over the sample, channels added.
pub(super) fn typical_radiance(
    scene: &BakeScene,
    directions: &Directions,
    progress: Progress<'_>,
) -> Result<f32> {
    let plan = SamplePlan::fixed(AUTO_LEAST);
    let coarse = BakeScene {
        plan: &plan,
        ..*scene
    };
    let level = |&(view, texel): &(View, usize)| {
        progress.check()?;
        let lights = directions.lights(view, directions.pilots().collect());
        let radiance = radiance_at(&coarse, view, texel, &lights);
        Ok(radiance.into_iter().sum::<Vec3>().element_sum())
    };
    let places = places_of(scene, directions);
    let levels: Vec<f32> = places.par_iter().map(level).collect::<Result<_>>()?;
    Ok(levels.iter().sum::<f32>() / levels.len() as f32)
}

/// The relative error that a scene's plan leaves, Σ |difference| / Σ radiance, against many more samples: at those
/// places spread over the sample that are in some views, under other lights than the plan decides by. `None` without
/// any.
pub(super) fn error_left(
    scene: &BakeScene,
    directions: &Directions,
    views: Range<usize>,
    progress: Progress<'_>,
) -> Result<Option<f64>> {
    let plan = SamplePlan::fixed(REFERENCE);
    let reference = BakeScene {
        plan: &plan,
        seed: scene.seed.wrapping_add(1),
        ..*scene
    };
    let between = directions.between_pilots();
    let sums = |&(view, texel): &(View, usize)| {
        progress.check()?;
        let lights = directions.lights_with_pilots(view, between.clone());
        let found = radiance_at(scene, view, texel, &lights);
        let wanted = radiance_at(&reference, view, texel, &lights);
        let compared = found.iter().zip(&wanted).take(between.len());
        Ok(compared.fold((0.0, 0.0), |(off, all), (found, wanted)| {
            let difference = (*found - *wanted).abs().element_sum();
            (
                off + f64::from(difference),
                all + f64::from(wanted.element_sum()),
            )
        }))
    };
    let mut places = places_of(scene, directions);
    places.retain(|(view, _)| views.contains(&view.index));
    let sums: Vec<(f64, f64)> = places.par_iter().map(sums).collect::<Result<_>>()?;
    let (off, all) = sums.iter().fold((0.0, 0.0), |a, b| (a.0 + b.0, a.1 + b.1));
    let error = if all > 0.0 { off / all } else { 0.0 };
    Ok((!places.is_empty()).then_some(error))
}

/// Texels of views, spread over both.
fn places_of(scene: &BakeScene, directions: &Directions) -> Vec<(View, usize)> {
    let (views, texels) = (directions.views.len(), scene.material.grid.len());
    let count = (views * texels / LEAST_SHARE).clamp(1, PLACES);
    let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
    let place = |index: usize| {
        let texel = (index as f64 * golden).fract() * texels as f64;
        (directions.view(index * views / count), texel as usize)
    };
    (0..count).map(place).collect()
}

/// Mean radiance of one texel under each light.
fn radiance_at(scene: &BakeScene, view: View, texel: usize, lights: &Lights) -> Vec<Vec3> {
    let width = scene.material.grid.width as usize;
    let mut radiance = vec![Vec3::ZERO; lights.directions.len()];
    let buffers = (&mut radiance[..], &mut Columns::default());
    scene.shade_texel(view, (texel / width, texel % width), lights, buffers);
    radiance
}
