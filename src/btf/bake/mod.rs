//! Baking: a BTF sample ray-traced from height, colour and roughness.
//!
//! In: a [`Material`] (from maps, a folder, or a [preset](presets)) and [`BakeOptions`]. Out: a
//! sample folder whose texel (row, col) in the image of view v and light l is the radiance of what
//! the ray through the mean-plane point (row, col) towards v meets first: parallax, masking, shadows and
//! interreflections are in the value. Written image by image, so a sample may be larger than memory.
//! Not handled: transmission, translucency, overhangs (a height field has none).

pub mod brdf;
pub(crate) mod export;
mod glare;
pub mod height_field;
mod lights;
pub mod maps;
pub mod material;
pub mod presets;
pub(crate) mod preview;
mod shade;
pub(crate) mod steepness;
mod trace;

pub use presets::Preset;

use std::path::Path;

use glam::{DVec2, Vec3};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use serde_json::json;

use crate::btf::bake::brdf::Columns;
use crate::btf::bake::glare::Glare;
use crate::btf::bake::height_field::SurfacePoint;
use crate::btf::bake::lights::Lights;
use crate::btf::bake::material::Material;
use crate::btf::bake::shade::{Scene, View};
use crate::btf::direction::Direction;
use crate::btf::direction_set::DirectionSet;
use crate::btf::height_map::HeightMap;
use crate::btf::sample::{DType, Description, FORMAT, Layout, VERSION};
use crate::btf::writer::SampleWriter;
use crate::error::{Error, Result};
use crate::format::id::ContentId;
use crate::progress::Progress;

/// Memory for images under way, in bytes.
const SLAB: usize = 64 << 20;
/// A surface of which more than this share sees no light at all is warned of.
const DARK: f64 = 0.1;
/// Images of a sample at most: 440 times those of the largest measured ones.
const MOST_IMAGES: usize = 10_000_000;
/// Views closer to the horizon see the surface from the side only.
const LEAST_VIEW_COSINE: f64 = 1e-3;

/// From which directions, how finely, and with which light a material is baked.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, clap::Args)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct BakeOptions {
    /// View directions: 12x5, bonn81, bonn151, fibonacci:N, `rings:THETA:COUNT[:OFFSET],…` or FILE.csv
    #[arg(long, value_name = "SET", default_value_t = BakeOptions::default().views)]
    pub views: DirectionSet,
    /// Light directions, as for --views.
    #[arg(long, value_name = "SET", default_value_t = BakeOptions::default().lights)]
    pub lights: DirectionSet,
    /// Number type of the sample.
    #[arg(long, value_enum, default_value_t = BakeOptions::default().dtype)]
    pub dtype: DType,
    /// View rays a texel, 1 to 65536: one through its centre, more spread over its area.
    #[arg(long, default_value_t = BakeOptions::default().samples)]
    pub samples: u32,
    /// How often light may be reflected within the surface before it reaches the eye's first point, 0 to
    /// 1000; 0 is direct light only. Drawn at random: raise --samples with it.
    #[arg(long, default_value_t = BakeOptions::default().bounces)]
    pub bounces: u32,
    /// Angle the light's disc is seen under, in degrees, 0 to 90; 0 gives hard shadows, more soft ones
    /// (raise --samples with it).
    #[arg(long, value_name = "DEGREES", default_value_t = BakeOptions::default().light_diameter)]
    pub light_diameter: f64,
    /// Least roughness of the coat, above 0 to 1: smoother texels are made as rough. Highlights narrower
    /// than the steps between the lights fall between them; 0.2 is a start.
    #[arg(long, value_name = "ROUGHNESS")]
    pub min_roughness: Option<f64>,
    /// Seed of what is drawn at random.
    #[arg(skip)]
    pub seed: u64,
}

impl Default for BakeOptions {
    fn default() -> Self {
        Self {
            views: DirectionSet::Tong12x5,
            lights: DirectionSet::Tong12x5,
            dtype: DType::F2,
            samples: 1,
            bounces: 0,
            light_diameter: 0.0,
            min_roughness: None,
            seed: 0,
        }
    }
}

impl BakeOptions {
    /// Refuses what cannot be baked.
    pub fn validate(&self) -> Result<()> {
        let range = |option: &str, value: u32, low: u32, high: u32| {
            if (low..=high).contains(&value) {
                return Ok(());
            }
            Err(Error::option(
                option,
                value.to_string(),
                format!("{low} to {high}"),
            ))
        };
        range("samples", self.samples, 1, 65_536)?;
        range("bounces", self.bounces, 0, 1000)?;
        if !(0.0..=90.0).contains(&self.light_diameter) {
            return Err(Error::option(
                "light-diameter",
                self.light_diameter.to_string(),
                "0 to 90 degrees",
            ));
        }
        match self.min_roughness {
            Some(least) if !(least > 0.0 && least <= 1.0) => Err(Error::option(
                "min-roughness",
                least.to_string(),
                "a roughness above 0, at most 1",
            )),
            _ => Ok(()),
        }
    }

    /// The material as these options bake it: no smoother than `min_roughness`.
    pub fn applied_to(&self, mut material: Material) -> Result<Material> {
        let Some(least) = self.min_roughness else {
            return Ok(material);
        };
        let Some(roughness) = &mut material.roughness else {
            return Err(Error::option(
                "min-roughness",
                "given for a matte material",
                "a material with roughness",
            ));
        };
        roughness
            .iter_mut()
            .for_each(|rough| *rough = rough.max(least as f32));
        Ok(material)
    }
}

/// What a bake did.
#[derive(Clone, Debug)]
pub struct Baked {
    /// The sample's description, as written.
    pub description: Description,
    /// View, shadow and path rays traced by this run.
    pub rays: u64,
    /// Images that an interrupted run had written already.
    pub resumed: usize,
    /// Share of all light that the brightest hundredth of the values carries, 0 to 1, estimated from a few
    /// texels and views.
    pub glare: f64,
}

/// Bakes `material` into the sample folder `target`. An interrupted bake leaves a hidden folder beside
/// it, from which the same call goes on to the same bytes; any other failure leaves nothing.
pub fn bake(
    material: &Material,
    options: &BakeOptions,
    target: &Path,
    progress: &Progress,
) -> Result<Baked> {
    options.validate()?;
    material.check()?;
    let changed = match options.min_roughness {
        Some(_) => Some(options.applied_to(material.clone())?),
        None => None,
    };
    let material = changed.as_ref().unwrap_or(material);
    let description = describe(material, options)?;
    let scene = Scene {
        material,
        surface: material.surface(),
        samples: options.samples,
        bounces: options.bounces,
        light_radius: 0.5 * options.light_diameter.to_radians(),
        seed: options.seed,
    };
    warn_of_darkness(&scene, &description, progress);
    let glare = Glare::of(&scene, &description, progress);
    if let Some(warning) = glare.objection() {
        progress.warn(warning);
    }
    progress.check()?;
    let heights = HeightMap::levelled(description.grid(), material.heights.clone())?;
    let mut writer = SampleWriter::resume(target, description)?;
    writer.set_heights(Some(heights));
    let resumed = writer.images_written();
    match write_images(&scene, &mut writer, progress) {
        Ok(rays) => Ok(Baked {
            description: writer.finish()?,
            rays,
            resumed,
            glare: glare.share,
        }),
        Err(Error::Interrupted) => Err(Error::Interrupted),
        Err(error) => {
            writer.discard();
            Err(error)
        }
    }
}

/// Warns when much of the surface sees none of the lights: its height scale is likely wrong.
fn warn_of_darkness(scene: &Scene, description: &Description, progress: &Progress) {
    let surface = &scene.surface;
    let texels = surface.width() * surface.height();
    let in_the_dark = |texel: &usize| {
        let point = SurfacePoint {
            x: texel % surface.width(),
            y: texel / surface.width(),
            within: DVec2::ZERO,
        };
        let normal = surface.normal(point);
        let lit =
            |light: &Direction| normal.dot(light.0) > 0.0 && !surface.occluded(point, light.0);
        !progress.is_interrupted() && !description.lights.iter().any(lit)
    };
    let dark = (0..texels).into_par_iter().filter(in_the_dark).count();
    let share = dark as f64 / texels as f64;
    if share > DARK {
        progress.warn(format!(
            "no light reaches {:.0} % of the surface: its relief is {:.1} texels deep; check the height \
             scale",
            100.0 * share,
            surface.highest() - surface.lowest()
        ));
    }
}

fn describe(material: &Material, options: &BakeOptions) -> Result<Description> {
    let views = options.views.directions()?;
    if let Some(low) = views.iter().position(|v| v.cos_theta() < LEAST_VIEW_COSINE) {
        return Err(Error::option(
            "views",
            format!(
                "view {low} lies {:.3}° from the normal",
                views[low].theta().to_degrees()
            ),
            "views above the horizon, by 0.06° or more",
        ));
    }
    let description = Description {
        format: FORMAT.into(),
        version: VERSION,
        name: material.name.clone(),
        width: material.grid.width,
        height: material.grid.height,
        channels: 3,
        dtype: options.dtype,
        texel_mm: material.texel_mm,
        layout: Layout::Product,
        views,
        lights: options.lights.directions()?,
        pairs: None,
        tileable: material.grid.tileable,
        id: ContentId::of_bytes(b""),
        source: json!({
            "kind": "bake",
            "material": material.id(),
            "samples": options.samples,
            "bounces": options.bounces,
            "light-diameter": options.light_diameter,
            "min-roughness": options.min_roughness,
            "seed": options.seed,
        }),
    };
    description.check()?;
    if description.image_count() > MOST_IMAGES {
        return Err(Error::option(
            "lights",
            format!(
                "{} views × {} lights",
                description.views.len(),
                description.lights.len()
            ),
            format!("at most {MOST_IMAGES} images: a sample has one for each pair"),
        ));
    }
    Ok(description)
}

/// One view and a run of lights: what is rendered at once.
#[derive(Clone)]
struct Slab {
    view: View,
    lights: std::ops::Range<usize>,
}

/// Images of one slab: row after row, in it light after light, (width) RGB each.
struct Rendered {
    slab: Slab,
    rows: Vec<Vec3>,
    rays: u64,
}

/// Renders slab after slab, writing each while the next is rendered.
fn write_images(scene: &Scene, writer: &mut SampleWriter, progress: &Progress) -> Result<u64> {
    let description = writer.description().clone();
    progress.begin("bake", description.image_count() as u64);
    let done = writer.images_written();
    progress.advance(done as u64)?;
    let mut rays = 0;
    let mut finished: Option<Rendered> = None;
    for slab in slabs(&description, done) {
        progress.check()?;
        let (written, rendered) = rayon::join(
            || write(finished.as_ref(), writer, progress),
            || render(scene, slab, &description.lights, progress),
        );
        written?;
        progress.check()?;
        rays += rendered.rays;
        finished = Some(rendered);
    }
    write(finished.as_ref(), writer, progress)?;
    progress.end();
    Ok(rays)
}

/// The images from `done` on in the order of the file, cut so that a slab fits the memory for it.
fn slabs(description: &Description, done: usize) -> Vec<Slab> {
    let image = description.grid().len() * size_of::<Vec3>();
    let at_once = (SLAB / image).max(1);
    let lights = description.lights.len();
    let cut = |(index, &direction): (usize, &Direction)| {
        let view = View { index, direction };
        let first_left = done.saturating_sub(index * lights).min(lights);
        (first_left..lights)
            .step_by(at_once)
            .map(move |first| Slab {
                view,
                lights: first..lights.min(first + at_once),
            })
    };
    description.views.iter().enumerate().flat_map(cut).collect()
}

/// Renders a slab; what comes back of an interrupted one is worth nothing.
fn render(scene: &Scene, slab: Slab, lights: &[Direction], progress: &Progress) -> Rendered {
    let width = scene.material.grid.width as usize;
    let height = scene.material.grid.height as usize;
    let lights = Lights::new(&lights[slab.lights.clone()]);
    let count = slab.lights.len();
    let mut rows = vec![Vec3::ZERO; height * count * width];
    let rays = rows
        .par_chunks_mut(count * width)
        .enumerate()
        .map(|(row, images)| {
            let place = (slab.view, row);
            render_row(scene, place, &lights, images, progress)
        })
        .sum();
    Rendered { slab, rows, rays }
}

/// One row of every image of a slab.
fn render_row(
    scene: &Scene,
    (view, row): (View, usize),
    lights: &Lights,
    images: &mut [Vec3],
    progress: &Progress,
) -> u64 {
    let width = scene.material.grid.width as usize;
    let (mut sums, mut scratch) = (vec![Vec3::ZERO; images.len() / width], Columns::default());
    let mut rays = 0;
    for col in 0..width {
        if progress.is_interrupted() {
            break;
        }
        sums.fill(Vec3::ZERO);
        rays += scene.shade_texel(view, (row, col), lights, (&mut sums, &mut scratch));
        for (light, sum) in sums.iter().enumerate() {
            images[light * width + col] = *sum / scene.samples as f32;
        }
    }
    rays
}

/// Hands the images of a slab to the writer.
fn write(
    rendered: Option<&Rendered>,
    writer: &mut SampleWriter,
    progress: &Progress,
) -> Result<()> {
    let Some(Rendered { slab, rows, .. }) = rendered else {
        return Ok(());
    };
    let width = writer.description().width as usize;
    let count = slab.lights.len();
    for light in 0..count {
        let image: Vec<Vec3> = rows
            .chunks_exact(count * width)
            .flat_map(|row| &row[light * width..(light + 1) * width])
            .copied()
            .collect();
        writer.push(bytemuck::cast_slice(&image))?;
        progress.advance(1)?;
    }
    Ok(())
}
