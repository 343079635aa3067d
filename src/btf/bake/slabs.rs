//! Rendering image after image: a view and a run of lights at a time, each written while the next is rendered.

use std::ops::Range;

use glam::Vec3;
use rayon::prelude::*;

use crate::btf::bake::brdf::Columns;
use crate::btf::bake::directions::{Directions, View};
use crate::btf::bake::half_range;
use crate::btf::bake::lights::Lights;
use crate::btf::bake::shade::{BakeScene, Work};
use crate::btf::sample::DType;
use crate::btf::writer::SampleWriter;
use crate::error::Result;
use crate::progress::Progress;

/// Memory for images under way, in bytes.
const SLAB: usize = 64 << 20;

/// One view and a run of lights: what is rendered at once.
#[derive(Clone)]
struct Slab {
    view: View,
    lights: Range<usize>,
}

/// Images of one slab: row after row, in it light after light, (width) RGB each.
struct Rendered {
    slab: Slab,
    rows: Vec<Vec3>,
    work: Work,
}

/// What rendering took, and what it met.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Tally {
    pub(super) work: Work,
    /// Texels of views that were rendered.
    pub(super) texels: u64,
    /// Numbers that were clamped.
    pub(super) clamped: u64,
}

/// Renders some views slab after slab, writing each while the next is rendered. Numbers that half precision cannot hold
/// are an error, or clamped.
pub(super) fn write_images(
    scene: &BakeScene,
    (directions, views): (&Directions, Range<usize>),
    writer: &mut SampleWriter,
    clamp: bool,
    progress: Progress<'_>,
) -> Result<Tally> {
    progress.begin("bake", writer.description().image_count() as u64);
    let done = writer.images_written();
    progress.advance(done as u64)?;
    let texels = scene.material.grid.len();
    let mut tally = Tally::default();
    let mut finished: Option<Rendered> = None;
    for slab in slabs(directions, views, texels, done) {
        progress.check()?;
        let (written, rendered) = rayon::join(
            || write(finished.as_ref(), writer, clamp, progress),
            || render(scene, directions, slab, progress),
        );
        tally.clamped += written?;
        progress.check()?;
        tally.work += rendered.work;
        tally.texels += texels as u64;
        finished = Some(rendered);
    }
    tally.clamped += write(finished.as_ref(), writer, clamp, progress)?;
    progress.end();
    Ok(tally)
}

/// The images of some views, from `done` on in the order of the file, cut so that a slab fits the memory for it.
fn slabs(directions: &Directions, views: Range<usize>, texels: usize, done: usize) -> Vec<Slab> {
    let at_once = (SLAB / (texels * size_of::<Vec3>())).max(1);
    let lights = directions.lights.len();
    let first = views.start;
    let cut = |index: usize| {
        let view = directions.view(index);
        let first_left = done.saturating_sub((index - first) * lights).min(lights);
        (first_left..lights)
            .step_by(at_once)
            .map(move |first| Slab {
                view,
                lights: first..lights.min(first + at_once),
            })
    };
    views.flat_map(cut).collect()
}

/// Renders a slab; what comes back of an interrupted one is worth nothing.
fn render(
    scene: &BakeScene,
    directions: &Directions,
    slab: Slab,
    progress: Progress<'_>,
) -> Rendered {
    let width = scene.material.grid.width as usize;
    let height = scene.material.grid.height as usize;
    let chosen: Vec<usize> = slab.lights.clone().collect();
    let lights = match scene.plan.is_refined() {
        true => directions.lights_with_pilots(slab.view, chosen),
        false => directions.lights(slab.view, chosen),
    };
    let count = slab.lights.len();
    let mut rows = vec![Vec3::ZERO; height * count * width];
    let work = rows
        .par_chunks_mut(count * width)
        .enumerate()
        .map(|(row, images)| render_row(scene, (slab.view, row), &lights, images, progress))
        .sum();
    Rendered { slab, rows, work }
}

/// One row of every image of a slab.
fn render_row(
    scene: &BakeScene,
    (view, row): (View, usize),
    lights: &Lights,
    images: &mut [Vec3],
    progress: Progress<'_>,
) -> Work {
    let width = scene.material.grid.width as usize;
    let mut radiance = vec![Vec3::ZERO; lights.directions.len()];
    let mut scratch = Columns::default();
    let mut work = Work::default();
    for col in 0..width {
        if progress.is_interrupted() {
            break;
        }
        work += scene.shade_texel(view, (row, col), lights, (&mut radiance, &mut scratch));
        let of_texel = images.iter_mut().skip(col).step_by(width);
        for (pixel, color) in of_texel.zip(&radiance) {
            *pixel = *color;
        }
    }
    work
}

/// Hands the images of a slab to the writer; returns how many numbers were clamped.
fn write(
    rendered: Option<&Rendered>,
    writer: &mut SampleWriter,
    clamp: bool,
    progress: Progress<'_>,
) -> Result<u64> {
    let Some(Rendered { slab, rows, .. }) = rendered else {
        return Ok(0);
    };
    let width = writer.description().width as usize;
    let is_half = writer.description().dtype == DType::F2;
    let count = slab.lights.len();
    let mut clamped = 0;
    for (index, light) in slab.lights.clone().enumerate() {
        let mut image: Vec<Vec3> = rows
            .chunks_exact(count * width)
            .flat_map(|row| &row[index * width..(index + 1) * width])
            .copied()
            .collect();
        if clamp {
            clamped += half_range::clamp(&mut image);
        } else if is_half {
            half_range::check_image(&image, width, (slab.view.index, light))?;
        }
        writer.push(bytemuck::cast_slice(&image))?;
        progress.advance(1)?;
    }
    Ok(clamped)
}
