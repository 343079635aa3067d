//! One image of a sample for any view and light, blended from its images as the renderer blends them.

use glam::DVec3;

use crate::btf::direction::Direction;
use crate::btf::sample::Sample;
use crate::error::Result;
use crate::render::nearest::{DirectionSet, PairSet, Scratch, Weight, Weighting, lifted};

/// Linear radiance for a light of unit irradiance, row-major (height, width, RGB), by `continuous` weights
/// (docs/rendering.md); black for a light below the horizon.
pub fn blended_image(sample: &Sample, view: Direction, light: Direction) -> Result<Vec<f32>> {
    let length = sample.grid().len() * 3;
    let (mut image, mut numbers) = (vec![0.0; length], vec![0.0; length]);
    if light.0.z <= 0.0 {
        return Ok(image);
    }
    for (number, weight) in weights(sample, lifted(view.0), light.0)? {
        sample.image(number)?.copy_to(&mut numbers);
        image
            .iter_mut()
            .zip(&numbers)
            .for_each(|(sum, value)| *sum += weight * value);
    }
    // Below the lowest sampled light, weights may be negative.
    image.iter_mut().for_each(|value| *value = value.max(0.0));
    Ok(image)
}

/// Images and their shares.
fn weights(sample: &Sample, view: DVec3, light: DVec3) -> Result<Vec<(usize, f32)>> {
    let description = sample.description();
    let (views, lights) = (&description.views, &description.lights);
    let weighting = Weighting::Continuous;
    let mut scratch = Scratch::default();
    // Weight the pairs of a scattered sample.
    if let Some(pairs) = &description.pairs {
        let pairs = PairSet::new(views, lights, pairs, weighting)?;
        let mut found = Vec::new();
        pairs.weigh(view, light, &mut scratch, &mut found);
        let image = |weight: &Weight| pairs.kept()[weight.index as usize] as usize;
        return Ok(found.iter().map(|w| (image(w), w.weight)).collect());
    }
    // Weight views and lights apart, and multiply.
    let [views, lights] = [views, lights].map(|set| DirectionSet::new(set, weighting));
    let (mut of_views, mut of_lights) = (Vec::new(), Vec::new());
    views.weigh::<false>(view, &mut scratch, &mut of_views);
    lights.weigh::<true>(light, &mut scratch, &mut of_lights);
    let stride = description.lights.len();
    let image = |v: &Weight, l: &Weight| {
        let [view, light] = [
            views.kept()[v.index as usize],
            lights.kept()[l.index as usize],
        ];
        view as usize * stride + light as usize
    };
    let pairs = of_views
        .iter()
        .flat_map(|v| of_lights.iter().map(move |l| (v, l)));
    Ok(pairs
        .map(|(v, l)| (image(v, l), v.weight * l.weight))
        .collect())
}
