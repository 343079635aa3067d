//! Highlights that half precision cannot hold, found before a bake or clamped in it.
//!
//! The peak of the GGX distribution is 1/(π α²), and a value at most 1/(2π α³). So only coats of a roughness
//! below 0.117 can exceed the largest half, 65504, and only where a normal lies within 0.0095 rad of the half vector of
//! a view and a light. Half vectors are put in order by their place on the unit disc, and the normals of glossy texels
//! looked up among them. A value that is too large counts where view and light both reach the point.

use std::f32::consts::{PI, TAU};

use glam::{DVec2, Vec3};
use half::f16;
use rayon::prelude::*;

use crate::btf::bake::directions::{Directions, View};
use crate::btf::bake::height_field::ReliefPoint;
use crate::btf::bake::lights::Lights;
use crate::btf::bake::shade::BakeScene;
use crate::error::{Error, Result};
use crate::progress::Progress;

/// The largest half, 65504.
const LARGEST: f32 = f16::MAX.to_f32_const();
/// How far from a half vector a normal's highlight may exceed the largest half, radians: the most, over α, of the angle
/// at which D falls to 2α times it.
const REACH: f32 = 0.0095;
/// Side of a cell of the unit disc.
const CELL: f32 = 0.02;
/// Cells along each side.
const CELLS: usize = 101;
/// Places of a texel that are looked at, at most.
const MOST_PLACES: usize = 16;

/// Refuses a bake in which a highlight seen directly would exceed the largest half.
pub(super) fn check(
    scene: &BakeScene,
    directions: &Directions,
    progress: Progress<'_>,
) -> Result<()> {
    let Some(roughness) = &scene.material.roughness else {
        return Ok(());
    };
    let may_exceed = |texel: &usize| may_exceed(roughness[*texel].powi(4));
    let glossy: Vec<usize> = (0..roughness.len()).filter(may_exceed).collect();
    if glossy.is_empty() || scene.light_radius > 0.0 {
        return Ok(());
    }
    let highlight = (0..directions.views.len())
        .into_par_iter()
        .find_map_first(|view| Search::new(scene, directions, view).run(&glossy, progress));
    progress.check()?;
    highlight.map_or(Ok(()), |highlight| Err(highlight.refusal(directions)))
}

/// Sets what exceeds the largest half to it; returns how many numbers did.
pub(super) fn clamp(image: &mut [Vec3]) -> u64 {
    let numbers: &mut [f32] = bytemuck::cast_slice_mut(image);
    let beyond = numbers.iter_mut().filter(|number| **number > LARGEST);
    beyond.map(|number| *number = LARGEST).count() as u64
}

/// Refuses an image of width `width` that half precision cannot hold: such light may come by several reflections.
pub(super) fn check_image(
    image: &[Vec3],
    width: usize,
    (view, light): (usize, usize),
) -> Result<()> {
    let beyond = |color: &Vec3| color.max_element() > LARGEST;
    let Some(texel) = image.iter().position(beyond) else {
        return Ok(());
    };
    let place = format!(
        "view {view}, light {light}, row {}, column {}",
        texel / width,
        texel % width
    );
    let radiance = image[texel].max_element();
    Err(refusal(place, radiance, "--min-roughness 0.1"))
}

fn refusal(place: String, radiance: f32, rougher: &str) -> Error {
    Error::data(place, format!("radiance {radiance:.3e}"))
        .expected(format!("at most {LARGEST}, the largest half"))
        .advice(format!(
            "{rougher} makes highlights less bright, --dtype f4 holds them, --clamp cuts them off"
        ))
}

/// Whether a coat can reflect more than the largest half at all.
fn may_exceed(alpha_squared: f32) -> bool {
    TAU * alpha_squared.powf(1.5) * LARGEST < 1.0
}

/// A value that half precision cannot hold.
#[derive(Debug)]
struct Highlight {
    view: usize,
    light: usize,
    row: usize,
    col: usize,
    radiance: f32,
}

impl Highlight {
    fn refusal(&self, directions: &Directions) -> Error {
        let Self {
            view,
            light,
            row,
            col,
            radiance,
        } = *self;
        // A mirror direction's value is 1/(4π α² cos θ) at most, α the roughness squared.
        let half = (directions.views[view].0 + directions.lights[light].0).normalize();
        let cos = half.dot(directions.lights[light].0).max(0.01) as f32;
        let enough = (4.0 * PI * cos * LARGEST).recip().powf(0.25);
        let rounded_up = (100.0 * enough).ceil() / 100.0;
        refusal(
            format!("view {view}, light {light}: the highlight at row {row}, column {col}"),
            radiance,
            &format!("--min-roughness {rounded_up}"),
        )
    }
}

/// The half vectors of one view, and what is looked up among them.
struct Search<'a> {
    scene: &'a BakeScene<'a>,
    view: View,
    lights: Lights,
    /// Lights whose half vectors lie within [`REACH`] of each cell, as (cell, light), in order.
    near: Vec<(u32, u32)>,
}

impl<'a> Search<'a> {
    fn new(scene: &'a BakeScene<'a>, directions: &Directions, view: usize) -> Self {
        let view = directions.view(view);
        let lights = directions.lights(view, (0..directions.lights.len()).collect());
        let towards = view.direction.0.as_vec3();
        let mut near = Vec::new();
        for light in 0..lights.directions.len() {
            let widened = lights.least_alpha_squared.as_ref();
            if widened.is_some_and(|least| !may_exceed(least[light])) {
                continue;
            }
            let half = (towards + lights.directions.get(light)).normalize_or_zero();
            let [columns, rows] = [half.x, half.y].map(|at| (cell(at - REACH), cell(at + REACH)));
            for row in rows.0..=rows.1 {
                for column in columns.0..=columns.1 {
                    near.push(((row * CELLS + column) as u32, light as u32));
                }
            }
        }
        near.sort_unstable();
        Self {
            scene,
            view,
            lights,
            near,
        }
    }

    /// The first highlight of these texels that is too bright.
    fn run(&self, texels: &[usize], progress: Progress<'_>) -> Option<Highlight> {
        if self.near.is_empty() {
            return None;
        }
        let width = self.scene.material.grid.width as usize;
        texels.iter().find_map(|&texel| {
            if progress.is_interrupted() {
                return None;
            }
            let (row, col) = (texel / width, texel % width);
            let (light, radiance) = self.beyond_at(row, col)?;
            Some(Highlight {
                view: self.view.index,
                light,
                row,
                col,
                radiance,
            })
        })
    }

    /// The first light under which a texel of the surface is too bright, and how bright it is.
    fn beyond_at(&self, row: usize, col: usize) -> Option<(usize, f32)> {
        let surface = self.scene.surface;
        let towards = self.view.direction.0;
        let places = &self.scene.plan.places;
        let places = &places[..places.len().min(MOST_PLACES)];
        let up = self.scene.material.grid.height as usize - 1 - row;
        let centre = DVec2::new(col as f64, up as f64);
        let points: Vec<(ReliefPoint, Vec3)> = places
            .iter()
            .map(|place| surface.point_above(centre + *place))
            .map(|point| (point, surface.normal(point).as_vec3()))
            .collect();
        let mut lights: Vec<u32> = points
            .iter()
            .flat_map(|(_, n)| self.lights_near(*n))
            .collect();
        lights.sort_unstable();
        lights.dedup();
        lights.into_iter().find_map(|light| {
            let light = light as usize;
            let radiance = |(point, normal): &(ReliefPoint, Vec3)| {
                let least = self.lights.least_alpha_squared.as_ref();
                let least = least.map_or(0.0, |least| least[light]);
                let reflection = self.scene.material.reflection(*point);
                let lobe = reflection.towards(*normal, towards.as_vec3());
                let radiance = lobe.widened_radiance(self.lights.directions.get(light), least);
                // What is hidden or in shadow counts for nothing; rays are shot for bright points alone.
                let is_bright = radiance.max_element() > 1.0 && normal.dot(towards.as_vec3()) > 0.0;
                let is_seen = || !surface.occluded(*point, towards);
                let is_lit = || !surface.occluded(*point, self.lights.lamps[light].direction);
                match is_bright && is_seen() && is_lit() {
                    true => radiance.max_element(),
                    false => 0.0,
                }
            };
            let mean = points.iter().map(radiance).sum::<f32>() / points.len() as f32;
            (mean > LARGEST).then_some((light, mean))
        })
    }

    fn lights_near(&self, normal: Vec3) -> impl Iterator<Item = u32> {
        let wanted = (cell(normal.y) * CELLS + cell(normal.x)) as u32;
        let first = self.near.partition_point(|&(cell, _)| cell < wanted);
        let of_cell = self.near[first..]
            .iter()
            .take_while(move |near| near.0 == wanted);
        of_cell.map(|&(_, light)| light)
    }
}

/// The cell of a coordinate on the unit disc.
fn cell(at: f32) -> usize {
    (((at + 1.0) / CELL).max(0.0) as usize).min(CELLS - 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The reach by trying every α: where D falls to what a value of 65504 needs at least.
    #[test]
    fn highlights_end_within_reach() {
        let mut farthest = 0.0_f64;
        for step in 0..4000 {
            let alpha = 1e-3 * 1.001_f64.powi(step);
            if alpha > 0.1 {
                break;
            }
            let needed = 2.0 * alpha * f64::from(LARGEST);
            // D(θ) = α² / (π cos⁴θ (α² + tan²θ)²), Walter 2007.
            let distribution = |theta: f64| {
                let (cos, tan) = (theta.cos(), theta.tan());
                let squared = alpha * alpha;
                squared / (std::f64::consts::PI * cos.powi(4) * (squared + tan * tan).powi(2))
            };
            let ends = (0..20_000).map(|i| f64::from(i) * 1e-6);
            let end = ends
                .take_while(|&theta| distribution(theta) >= needed)
                .last();
            assert_eq!(end.is_some(), may_exceed((alpha * alpha) as f32), "{alpha}");
            farthest = farthest.max(end.unwrap_or(0.0));
        }
        assert!(farthest < f64::from(REACH), "{farthest}");
        assert!(farthest > 0.9 * f64::from(REACH), "{farthest}");
    }

    #[test]
    fn values_are_clamped_and_counted() {
        let mut image = [
            Vec3::new(1.0, 65_504.0, 7e4),
            Vec3::new(f32::INFINITY, 0.0, 2.0),
        ];
        assert!(
            check_image(&image, 1, (0, 3))
                .unwrap_err()
                .to_string()
                .contains("light 3, row 0")
        );
        assert_eq!(clamp(&mut image), 2);
        assert_eq!(
            image,
            [
                Vec3::new(1.0, LARGEST, LARGEST),
                Vec3::new(LARGEST, 0.0, 2.0)
            ]
        );
        assert!(check_image(&image, 1, (0, 3)).is_ok());
    }
}
