//! Baking: a BTF sample ray-traced from height, colour and roughness.
//!
//! In: a [`Material`] (from maps, a folder, or a [preset](presets)) and [`BakeOptions`]. Out: a
//! sample folder whose texel (row, col) in the image of view v and light l is the radiance of what
//! the ray through the mean-plane point (row, col) towards v meets first: parallax, masking, shadows and
//! interreflections are in the value. Written image by image, so a sample may be larger than memory.
//! Not handled: transmission, translucency, overhangs (a height field has none).

mod angular;
pub(crate) mod brdf;
mod directions;
pub(crate) mod export;
mod glare;
mod half_range;
pub(crate) mod height_field;
mod lights;
pub mod maps;
pub(crate) mod material;
mod options;
pub(crate) mod presets;
pub(crate) mod preview;
mod refinement;
mod sample_plan;
mod samples;
mod shade;
mod slabs;
pub(crate) mod steepness;
mod trace;

pub use angular::AngularFilter;
pub use brdf::Diffuse;
pub use material::Material;
pub use options::BakeOptions;
pub use presets::Preset;
pub use samples::Samples;

use std::ops::Range;
use std::path::{Path, PathBuf};

use glam::DVec2;
use rayon::prelude::*;
use serde_json::{Map, json};

use crate::btf::bake::angular::Widening;
use crate::btf::bake::directions::Directions;
use crate::btf::bake::glare::Glare;
use crate::btf::bake::height_field::{HeightField, ReliefPoint};
use crate::btf::bake::refinement::{error_left, typical_radiance};
use crate::btf::bake::sample_plan::SamplePlan;
use crate::btf::bake::samples::AUTO_LEAST;
use crate::btf::bake::shade::BakeScene;
use crate::btf::bake::slabs::write_images;
use crate::btf::direction::Direction;
use crate::btf::height_map::HeightMap;
use crate::btf::parts::{self, Maker, NewPart};
use crate::btf::sample::{DType, Description, FORMAT, Layout, VERSION};
use crate::btf::writer::SampleWriter;
use crate::error::{Error, Result};
use crate::format::id::ContentId;
use crate::progress::Progress;
use crate::shard::Shard;

/// A surface of which more than this share sees no light at all is warned of.
const DARK: f64 = 0.1;
/// Images of a sample at most: 440 times those of the largest measured ones.
const MOST_IMAGES: usize = 10_000_000;
/// Views closer to the horizon see the surface from the side only.
const LEAST_VIEW_COSINE: f64 = 1e-3;

/// What a bake did.
#[derive(Clone, Debug)]
pub struct Baked {
    /// The sample's description, as written.
    pub description: Description,
    /// View, shadow and path rays traced by this run.
    pub rays: u64,
    /// View rays among them.
    pub view_rays: u64,
    /// View rays per texel of this run, on average; 0 when there was nothing left to do.
    pub samples: f64,
    /// Images that an interrupted run had written already.
    pub resumed: usize,
    /// Whether the part of a shard was there, whole, and nothing was done.
    pub is_kept: bool,
    /// Share of all light that the brightest hundredth of the values carries, 0 to 1, estimated from a few
    /// texels and views.
    pub glare: f64,
    /// With `--samples auto`: the relative error that is left, Σ |difference| / Σ radiance, measured at places spread
    /// over the sample.
    pub error_left: Option<f64>,
    /// Where highlights were widened to the spacing of the directions: the roughness they have at least, median over
    /// pairs of view and light.
    pub widened_to: Option<f64>,
    /// Numbers of this run beyond half precision that were clamped.
    pub clamped: u64,
}

impl Baked {
    /// Of a part that stays as it is.
    fn kept(description: Description) -> Self {
        Self {
            resumed: description.image_count(),
            description,
            rays: 0,
            view_rays: 0,
            samples: 0.0,
            is_kept: true,
            glare: 0.0,
            error_left: None,
            widened_to: None,
            clamped: 0,
        }
    }
}

/// Bakes `material` into the sample folder `target`. An interrupted bake leaves a hidden folder beside it, from which
/// the same call continues to the same bytes; any other failure leaves nothing.
pub fn bake(
    material: &Material,
    options: &BakeOptions,
    target: &Path,
    progress: Progress<'_>,
) -> Result<Baked> {
    bake_views(material, options, None, target, progress)
}

/// Bakes the views of a shard into the part `target`, as [`bake`] does those of a whole sample; [`join`] makes a
/// sample of all parts. A part that is there already, whole, is kept.
pub fn bake_part(
    material: &Material,
    options: &BakeOptions,
    shard: Shard,
    target: &Path,
    progress: Progress<'_>,
) -> Result<Baked> {
    bake_views(material, options, Some(shard), target, progress)
}

/// Joins the parts of all shards to the sample `target`, as one run bakes it; returns its description. Refuses parts of
/// other bakes than the first, and shards that are missing or there twice.
pub fn join(parts: &[PathBuf], target: &Path, progress: Progress<'_>) -> Result<Description> {
    parts::join(parts, Maker::Bake, target, progress)
}

/// Bakes all views, or those of a shard.
fn bake_views(
    material: &Material,
    options: &BakeOptions,
    shard: Option<Shard>,
    target: &Path,
    progress: Progress<'_>,
) -> Result<Baked> {
    // Check what is given, and describe the sample, or the shard's part of it.
    options.validate()?;
    material.check()?;
    let changed = match options.min_roughness {
        Some(_) => Some(options.applied_to(material.clone())?),
        None => None,
    };
    let material = changed.as_ref().unwrap_or(material);
    let directions = directions(material, options)?;
    let mut description = describe(material, options, &directions)?;
    let heights = HeightMap::levelled(description.grid(), material.heights.clone())?;
    let mut views = 0..directions.views.len();
    if let Some(shard) = shard {
        shard.check(views.len(), "views")?;
        views = shard.range(views.len());
        description = new_part(shard, &views, directions.lights.len()).described_in(&description);
        if let Some(found) = parts::find(target, |_| description.clone(), Some(&heights)) {
            return Ok(Baked::kept(found));
        }
    }
    // Plan the rays of each texel.
    let surface = material.surface();
    warn_of_darkness(&surface, &directions.lights, progress);
    let coarse = SamplePlan::fixed(AUTO_LEAST);
    let scene = BakeScene {
        material,
        surface: &surface,
        plan: &coarse,
        bounces: options.bounces,
        light_radius: 0.5 * options.light_diameter.to_radians(),
        seed: options.seed,
    };
    let plan = plan(&scene, options, &directions, progress)?;
    let scene = BakeScene {
        plan: &plan,
        ..scene
    };
    // Refuse highlights that the numbers cannot hold, and warn of glare.
    if options.dtype == DType::F2 && !options.clamp {
        half_range::check(&scene, &directions, progress)?;
    }
    let glare = Glare::of(&scene, &directions, progress);
    if let Some(warning) = glare.objection() {
        progress.warn(warning);
    }
    progress.check()?;
    // Render the images.
    let mut writer = SampleWriter::resume(target, description)?;
    writer.set_heights(Some(heights));
    let baked = render(
        &scene,
        (&directions, views),
        writer,
        options.clamp,
        progress,
    )?;
    Ok(Baked {
        glare: glare.share,
        ..baked
    })
}

/// Renders the images of some views that are not written yet, and finishes the sample. An interruption leaves what is
/// written, any other failure nothing.
fn render(
    scene: &BakeScene,
    (directions, views): (&Directions, Range<usize>),
    mut writer: SampleWriter,
    clamp: bool,
    progress: Progress<'_>,
) -> Result<Baked> {
    // Render what is missing, and measure the error that is left.
    let resumed = writer.images_written();
    let place = (directions, views.clone());
    let written = write_images(scene, place, &mut writer, clamp, progress)
        .and_then(|tally| Ok((tally, left(scene, directions, views, progress)?)));
    // Finish the sample. An interrupted one is kept for the next run.
    match written {
        Ok((tally, error_left)) => Ok(Baked {
            description: writer.finish()?,
            rays: tally.work.rays,
            view_rays: tally.work.samples,
            samples: tally.work.samples as f64 / tally.texels.max(1) as f64,
            resumed,
            is_kept: false,
            glare: 0.0,
            error_left,
            widened_to: directions
                .widening
                .as_ref()
                .map(Widening::typical_roughness),
            clamped: tally.clamped,
        }),
        Err(Error::Interrupted) => Err(Error::Interrupted),
        Err(error) => {
            writer.discard();
            Err(error)
        }
    }
}

/// The part of a shard has the images of its views. All that they depend on is in the description.
fn new_part(shard: Shard, views: &Range<usize>, lights: usize) -> NewPart {
    NewPart {
        maker: Maker::Bake,
        shard,
        images: views.start * lights..views.end * lights,
        made_from: Map::new(),
        own: None,
    }
}

/// Where samples look through; for `auto`, with what the scene is like.
fn plan(
    scene: &BakeScene,
    options: &BakeOptions,
    directions: &Directions,
    progress: Progress<'_>,
) -> Result<SamplePlan> {
    match options.samples {
        Samples::Fixed(count) => Ok(SamplePlan::fixed(count)),
        Samples::Auto => {
            let typical = typical_radiance(scene, directions, progress)?;
            Ok(SamplePlan::refined(options.wanted_error(), typical))
        }
    }
}

/// The error that is left in some views, where the user asked for one.
fn left(
    scene: &BakeScene,
    directions: &Directions,
    views: Range<usize>,
    progress: Progress<'_>,
) -> Result<Option<f64>> {
    match scene.plan.is_refined() {
        true => error_left(scene, directions, views, progress),
        false => Ok(None),
    }
}

/// Warns when much of the surface sees none of the lights: its height scale is likely wrong.
fn warn_of_darkness(surface: &HeightField, lights: &[Direction], progress: Progress<'_>) {
    let texels = surface.width() * surface.height();
    let in_the_dark = |texel: &usize| {
        let point = ReliefPoint {
            x: texel % surface.width(),
            y: texel / surface.width(),
            within: DVec2::ZERO,
        };
        let normal = surface.normal(point);
        let lit =
            |light: &Direction| normal.dot(light.0) > 0.0 && !surface.occluded(point, light.0);
        !progress.is_interrupted() && !lights.iter().any(lit)
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

/// The directions of a bake, and how wide they make highlights.
fn directions(material: &Material, options: &BakeOptions) -> Result<Directions> {
    let views = options.views.directions()?;
    let lights = options.lights.directions()?;
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
    if views.len().saturating_mul(lights.len()) > MOST_IMAGES {
        return Err(Error::option(
            "lights",
            format!("{} views × {} lights", views.len(), lights.len()),
            format!("at most {MOST_IMAGES} images: a sample has one for each pair"),
        ));
    }
    let widening = Widening::choose(options.angular_filter, material, &views, &lights)?;
    Ok(Directions {
        views,
        lights,
        widening,
    })
}

fn describe(
    material: &Material,
    options: &BakeOptions,
    directions: &Directions,
) -> Result<Description> {
    let samples = match options.samples {
        Samples::Fixed(count) => json!(count),
        Samples::Auto => json!("auto"),
    };
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
        views: directions.views.clone(),
        lights: directions.lights.clone(),
        pairs: None,
        tileable: material.grid.tileable,
        id: ContentId::of_bytes(b""),
        source: json!({
            "kind": "bake",
            "material": material.id(),
            "samples": samples,
            "error": options.error,
            "bounces": options.bounces,
            "light-diameter": options.light_diameter,
            "min-roughness": options.min_roughness,
            "angular-filter": if directions.widening.is_some() { "on" } else { "off" },
            "clamp": options.clamp,
            "seed": options.seed,
        }),
    };
    description.check()?;
    Ok(description)
}
