//! Missing images, interpolated from those of the nearest directions.
//!
//! The weights are the nearness of scattered samples' rendering, without its fit: over the pairs within R, 1.05 times
//! the distance √(d_view² + d_light²) to the 17th nearest, weight ((R − d) / (R d))². Each image counts with
//! min(cos θ / cos θᵢ, 2), θᵢ its light's angle from the normal.

use std::f64::consts::PI;

use crate::btf::direction::Direction;
use crate::btf::import::image_list::MeasuredImage;

/// The pair whose distance sets how far weights reach.
const REACH: usize = 17;
/// How much further than that pair they reach.
const BEYOND: f64 = 1.05;
/// The most that a light's angle brightens an image.
const BRIGHTEST: f64 = 2.0;
/// Distances are at least this, in radians.
const LEAST: f64 = 1e-6;

/// Images of the list, and what each counts.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Blend(pub(super) Vec<(usize, f32)>);

/// The images from which that of a view and a light is interpolated, nearest first.
pub(super) fn nearest<'a>(
    images: &[MeasuredImage],
    present: impl Iterator<Item = &'a usize>,
    view: Direction,
    light: Direction,
) -> Blend {
    let mut all: Vec<(f64, usize)> = present
        .map(|&image| {
            let to_view = images[image].view.angle_to(view);
            let to_light = images[image].light.angle_to(light);
            (to_view.hypot(to_light).max(LEAST), image)
        })
        .collect();
    all.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let reach = all
        .get(REACH - 1)
        .map_or(PI, |(distance, _)| BEYOND * distance);
    let weight = |distance: f64| ((reach - distance) / (reach * distance)).powi(2);
    all.retain(|(distance, _)| *distance < reach);
    let sum: f64 = all.iter().map(|(distance, _)| weight(*distance)).sum();
    let share = |(distance, image): (f64, usize)| {
        let brighter = cosine_ratio(light, images[image].light);
        (image, (weight(distance) / sum * brighter) as f32)
    };
    Blend(all.into_iter().map(share).collect())
}

fn cosine_ratio(wanted: Direction, found: Direction) -> f64 {
    let (wanted, found) = (wanted.cos_theta().max(0.0), found.cos_theta().max(0.0));
    match wanted < BRIGHTEST * found {
        true => wanted / found,
        false => BRIGHTEST,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(view: f64, light: f64) -> MeasuredImage {
        MeasuredImage {
            path: "a.png".into(),
            view: Direction::from_angles(view, 0.0),
            light: Direction::from_angles(light, 0.0),
        }
    }

    #[test]
    fn a_lambertian_set_is_filled_exactly() {
        let images: Vec<MeasuredImage> = [0.2, 0.4, 0.8]
            .iter()
            .flat_map(|&light| [0.0, 0.5].map(|view| image(view, light)))
            .collect();
        let present: Vec<usize> = (0..images.len()).collect();
        let (view, light) = (
            Direction::from_angles(0.2, 0.0),
            Direction::from_angles(0.6, 0.0),
        );
        let Blend(blend) = nearest(&images, present.iter(), view, light);
        let value: f64 = blend
            .iter()
            .map(|&(at, weight)| f64::from(weight) * images[at].light.cos_theta())
            .sum();
        assert!((value - 0.6_f64.cos()).abs() < 1e-6, "{value}");
        assert_eq!(blend.len(), 6);
        // The nearest counts most.
        let first = images[blend[0].0].light.theta();
        assert!((first - 0.4).abs() < 1e-9 || (first - 0.8).abs() < 1e-9);
    }

    #[test]
    fn far_images_do_not_count() {
        let images: Vec<MeasuredImage> = (0..40).map(|k| image(0.0, 0.03 * f64::from(k))).collect();
        let present: Vec<usize> = (1..images.len()).collect();
        let at = Direction::from_angles(0.0, 0.0);
        let Blend(blend) = nearest(&images, present.iter(), at, at);
        assert_eq!(blend.len(), 17);
        assert!(blend[0].1 > blend[1].1 && blend[16].1 < 1e-3);
    }
}
