//! A picture of a baked sample: the relief beside the flat texture, and a sheet of views × lights.
//!
//! Above: twice the tile seen at 55° under one light, left as a flat texture (albedo · cos θ), right as
//! the height field traced by rays. Below: images of the sample, a row per view, a column per light, both
//! from low to high index; radiance times π, so that white under a frontal light is white, in sRGB.

use std::path::Path;

use glam::{DVec2, Vec3};
use rayon::prelude::*;

use crate::btf::bake::directions::View;
use crate::btf::bake::lights::Lights;
use crate::btf::bake::material::Material;
use crate::btf::bake::sample_plan::SamplePlan;
use crate::btf::bake::shade::BakeScene;
use crate::btf::direction::Direction;
use crate::btf::sample::Sample;
use crate::error::Result;
use crate::format::image::{encode_srgb8, write_png};

/// Views and lights on the sheet, at most.
const MOST: usize = 6;
/// Between pictures, in pixels.
const GAP: usize = 4;
/// Polar angle of the view of the panels.
const TILT_DEG: f64 = 55.0;
/// View rays per pixel of the panels.
const SAMPLES: u32 = 4;

/// Linear pictures on a grey ground, put together.
struct Canvas {
    width: usize,
    height: usize,
    pixels: Vec<Vec3>,
}

impl Canvas {
    fn new(width: usize, height: usize) -> Self {
        Self {
            width,
            height,
            pixels: vec![Vec3::splat(0.18); width * height],
        }
    }

    fn put(&mut self, picture: &Self, left: usize, top: usize) {
        for (row, line) in picture.pixels.chunks_exact(picture.width).enumerate() {
            let start = (top + row) * self.width + left;
            self.pixels[start..start + picture.width].copy_from_slice(line);
        }
    }

    fn write(&self, path: &Path) -> Result<()> {
        let bytes: Vec<u8> = self
            .pixels
            .iter()
            .flat_map(|color| color.to_array().map(encode_srgb8))
            .collect();
        write_png(path, self.width as u32, self.height as u32, &bytes)
    }
}

/// Writes the picture of `sample`, which was baked from `material`.
pub fn write_preview(material: &Material, sample: &Sample, path: &Path) -> Result<()> {
    let sheet = contact_sheet(sample)?;
    let panels = [panel(material, false), panel(material, true)];
    let panels_width = 2 * panels[0].width + GAP;
    let width = sheet.width.max(panels_width);
    let height = panels[0].height + GAP + sheet.height;
    let mut canvas = Canvas::new(width, height);
    canvas.put(&panels[0], 0, 0);
    canvas.put(&panels[1], panels[0].width + GAP, 0);
    canvas.put(&sheet, 0, panels[0].height + GAP);
    canvas.write(path)
}

fn contact_sheet(sample: &Sample) -> Result<Canvas> {
    let description = sample.description();
    let (columns, rows) = (description.width as usize, description.height as usize);
    let views = spread(description.views.len());
    let lights = spread(description.lights.len());
    let mut sheet = Canvas::new(
        lights.len() * (columns + GAP) - GAP,
        views.len() * (rows + GAP) - GAP,
    );
    for (y, view) in views.iter().enumerate() {
        for (x, light) in lights.iter().enumerate() {
            let stored = sample.image(view * description.lights.len() + light)?;
            let mut picture = Canvas::new(columns, rows);
            for (texel, pixel) in picture.pixels.iter_mut().enumerate() {
                let channel = |c: usize| stored.get(3 * texel + c) * std::f32::consts::PI;
                *pixel = Vec3::new(channel(0), channel(1), channel(2));
            }
            sheet.put(&picture, x * (columns + GAP), y * (rows + GAP));
        }
    }
    Ok(sheet)
}

/// At most [`MOST`] indices below `count`, first and last among them.
fn spread(count: usize) -> Vec<usize> {
    let shown = count.min(MOST);
    let last = (shown - 1).max(1);
    (0..shown).map(|i| i * (count - 1) / last).collect()
}

/// Two by two tiles seen from below their middle, as relief or as flat texture.
fn panel(material: &Material, relief: bool) -> Canvas {
    let direction = Direction::from_angles(TILT_DEG.to_radians(), -std::f64::consts::FRAC_PI_2);
    let light = Direction::from_angles(50_f64.to_radians(), 0.75 * std::f64::consts::PI);
    let light = Lights::new(&[light]);
    let flat = Material {
        heights: vec![0.0; material.grid.len()],
        roughness: None,
        metallic: None,
        ..material.clone()
    };
    let material = if relief { material } else { &flat };
    let scene = BakeScene {
        material,
        surface: &material.surface(),
        plan: &SamplePlan::fixed(SAMPLES),
        bounces: 0,
        light_radius: 0.0,
        seed: 0,
    };
    let view = View {
        index: 0,
        direction,
    };
    // The plane is foreshortened by cos θ along y; a pixel covers half a texel across.
    let (columns, rows) = (material.grid.width, material.grid.height);
    let scale = 0.5;
    let width = (2.0 * f64::from(columns) / scale) as usize;
    let height = (2.0 * f64::from(rows) * direction.cos_theta() / scale) as usize;
    let mut canvas = Canvas::new(width, height);
    canvas
        .pixels
        .par_iter_mut()
        .enumerate()
        .for_each(|(pixel, color)| {
            let (row, col) = (pixel / width, pixel % width);
            let up = (height - 1 - row) as f64;
            let on_plane = DVec2::new(col as f64, up / direction.cos_theta()) * scale;
            let footprint = DVec2::new(1.0, 1.0 / direction.cos_theta()) * scale;
            *color = scene.seen_color(view, on_plane, footprint, &light) * std::f32::consts::PI;
        });
    canvas
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::btf::bake::presets::Preset;
    use crate::progress::Progress;

    #[test]
    fn sheets_show_the_first_and_the_last() {
        assert_eq!(spread(1), [0]);
        assert_eq!(spread(2), [0, 1]);
        assert_eq!(spread(60), [0, 11, 23, 35, 47, 59]);
    }

    #[test]
    fn the_flat_panel_is_albedo_times_cosine_and_the_relief_is_not() {
        let mut material = Preset::Cobbles
            .material(32, 1, &Progress::silent())
            .unwrap();
        material.albedo.fill(Vec3::splat(0.5));
        let (flat, relief) = (panel(&material, false), panel(&material, true));
        let wanted = 0.5 * 50_f32.to_radians().cos();
        assert!(flat.pixels.iter().all(|p| (p.x - wanted).abs() < 1e-4));
        let dark = relief.pixels.iter().filter(|p| p.x == 0.0).count();
        assert!(dark > relief.pixels.len() / 50, "shadows: {dark}");
    }
}
