//! The sizes of what stages read and write, and what each stage takes by the [`cost`](super::cost) model.
//!
//! Sizes come from the options of the stages, and from files that are there: of measured images, one is read. What
//! cannot be known before an earlier stage has run, as the size of a `.btf` file that is not imported yet, is unknown.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use crate::btf::bake::Samples;
use crate::btf::sample::{Description, Sample};
use crate::cli::exemplar::with_kind;
use crate::cli::run::check::Stage;
use crate::cli::run::cost::{self, Cost, SampleSize, Sequence};
use crate::cli::{Command, bake, exemplar, import, mesh, render, synth, textons};
use crate::format::{image, ply};
use crate::mesh::reading;
use crate::progress::Progress;
use crate::render::memory::{frame_count, light_count};
use crate::render::nearest::Weighting;
use crate::render::renderer::{Shading, Shadows};
use crate::synthesis::Workload;
use crate::texton::TextonOptions;
use crate::texton::image_blocks::ImageBlocks;

/// Rays per texel and image that `--samples auto` takes on average.
const AUTO_SAMPLES: f64 = 12.0;
/// What is known of files, made or there.
pub struct Sizes<'a> {
    progress: Progress<'a>,
    /// By file, the size of the sample that it is or was made from.
    samples: HashMap<PathBuf, SampleSize>,
    /// By file, the vertices of the mesh that it is or was made for.
    vertices: HashMap<PathBuf, f64>,
    /// Whether products of earlier runs tell more than options do.
    sees_products: bool,
}

impl<'a> Sizes<'a> {
    /// Sizes of stages in their order; `sees_products` where earlier runs' products may tell them.
    pub fn new(progress: Progress<'a>, sees_products: bool) -> Self {
        Self {
            progress,
            samples: HashMap::new(),
            vertices: HashMap::new(),
            sees_products,
        }
    }

    /// What a stage takes; what it makes is known to later ones.
    pub fn cost_of(&mut self, stage: &Stage, is_done: bool) -> Option<Cost> {
        match &stage.command {
            Command::Bake(arguments) => self.bake(arguments),
            Command::Import(arguments) => self.import(arguments, is_done),
            Command::Exemplar(arguments) => self.exemplar(arguments, is_done),
            Command::Textons(arguments) => self.textons(arguments),
            Command::Gram(arguments) => {
                let size = self.samples.get(&arguments.textons).copied();
                self.hand_on_sample(size, [&arguments.output]);
                Some(cost::gram())
            }
            Command::Knn(arguments) => Some(cost::knn(self.samples.get(&arguments.space)?.texels)),
            Command::Mesh(arguments) => self.mesh(arguments, is_done),
            Command::Synth(arguments) => self.synth(arguments),
            Command::Render(arguments) => self.render(arguments),
            _ => None,
        }
    }

    /// What the pages of a sample and a map take.
    pub fn cost_of_pages(&self, [sample, map]: &[PathBuf; 2]) -> Option<Cost> {
        let (sample, vertices) = (self.samples.get(sample)?, self.vertices.get(map)?);
        Some(cost::pages(*sample, *vertices))
    }

    fn hand_on_sample<'p>(
        &mut self,
        size: Option<SampleSize>,
        files: impl IntoIterator<Item = &'p PathBuf>,
    ) {
        for file in files {
            match size {
                Some(size) => self.samples.insert(file.clone(), size),
                None => self.samples.remove(file),
            };
        }
    }

    /// The size of a sample, made by a stage or there.
    fn sample_at(&mut self, path: &Path) -> Option<SampleSize> {
        if let Some(size) = self.samples.get(path) {
            return Some(*size);
        }
        let size = size_of(path)?;
        self.samples.insert(path.to_path_buf(), size);
        Some(size)
    }

    fn bake(&mut self, arguments: &bake::Arguments) -> Option<Cost> {
        let options = &arguments.options;
        let views = options.views.directions().ok()?.len() as f64;
        let directions = options.lights.directions().ok()?;
        let lights = directions.len() as f64;
        let steep = directions.iter().map(|light| 1.0 / light.0.z.max(0.01));
        let slant = steep.sum::<f64>() / lights;
        let size = f64::from(arguments.size);
        let sample = SampleSize {
            texels: size * size,
            images: views * lights,
            lights,
        };
        let made = self.sees_products.then(|| size_of(&arguments.output));
        self.hand_on_sample(made.flatten().or(Some(sample)), [&arguments.output]);
        let samples = match options.samples {
            Samples::Fixed(count) => f64::from(count),
            Samples::Auto => AUTO_SAMPLES,
        };
        Some(cost::bake(
            sample,
            samples,
            f64::from(options.bounces),
            slant,
        ))
    }

    /// Of measured images the list and one image tell what comes of them.
    fn import(&mut self, arguments: &import::Arguments, is_done: bool) -> Option<Cost> {
        let made = is_done.then(|| size_of(&arguments.output)).flatten();
        let foreseen = arguments.foresee().ok().flatten();
        let size = made.or(foreseen
            .as_ref()
            .map(|(sample, _)| size_as_described(sample)));
        self.hand_on_sample(size, [&arguments.output]);
        let (_, pixels) = foreseen?;
        Some(cost::import(size?, pixels as f64))
    }

    /// How many shards an import can have; 1 where that is not known.
    pub fn most_shards_of_import(&self, arguments: &import::Arguments) -> u32 {
        let is_one_already = arguments.shard.is_some() || !arguments.reduce.is_empty();
        match self.samples.get(&arguments.output) {
            Some(sample) if !is_one_already => sample.images as u32,
            _ => 1,
        }
    }

    /// What shards of an import take each, and what it takes to join their parts; `whole` is one run.
    pub fn costs_of_import_shards(
        &self,
        arguments: &import::Arguments,
        whole: Option<Cost>,
        shards: u32,
    ) -> Option<[Cost; 2]> {
        let sample = self.samples.get(&arguments.output)?;
        Some(cost::import_in_shards(whole?, *sample, f64::from(shards)))
    }

    fn exemplar(&mut self, arguments: &exemplar::Arguments, is_done: bool) -> Option<Cost> {
        let sample = with_kind(&arguments.output, "sample");
        let texels = match is_done {
            true => size_of(&sample)?.texels,
            false => {
                let image = image::read(arguments.images.first()?).ok()?;
                f64::from(image.width) * f64::from(image.height)
            }
        };
        let size = SampleSize {
            texels,
            images: 1.0,
            lights: 1.0,
        };
        let space = with_kind(&arguments.output, "space.npz");
        self.hand_on_sample(Some(size), [&sample, &space]);
        Some(cost::exemplar(texels))
    }

    fn textons(&mut self, arguments: &textons::Arguments) -> Option<Cost> {
        let size = self.sample_at(&arguments.sample);
        self.hand_on_sample(size, [&arguments.output]);
        let sample = size?;
        let options = &arguments.options;
        let chosen = options.chosen_of(sample.images as usize) as f64;
        let channels = channels_of(options);
        let (count, grid) = (f64::from(options.textons), f64::from(options.image_grid));
        Some(cost::textons(sample, chosen, count, grid, channels))
    }

    /// What shards of a bake take each, and what it takes to join their parts.
    pub fn costs_of_bake_shards(
        &mut self,
        arguments: &bake::Arguments,
        shards: u32,
    ) -> Option<[Cost; 2]> {
        let whole = self.bake(arguments)?;
        let sample = self.sample_at(&arguments.output)?;
        Some(cost::bake_in_shards(whole, sample, f64::from(shards)))
    }

    /// How many shards an analysis can have; 1 where that is not known.
    pub fn most_shards_of_textons(&self, arguments: &textons::Arguments) -> u32 {
        let is_factored = Sample::open(&arguments.sample).is_ok_and(|s| s.factors().is_some());
        let Some(sample) = self.samples.get(&arguments.sample).filter(|_| !is_factored) else {
            return 1;
        };
        let images = sample.images as usize;
        match arguments.options.chosen_of(images) < images {
            true => images as u32,
            false => ImageBlocks::of_all(images).count() as u32,
        }
    }

    /// What shards of an analysis take each, and what it takes to join their parts.
    pub fn costs_of_textons_shards(
        &mut self,
        arguments: &textons::Arguments,
        shards: u32,
    ) -> Option<[Cost; 2]> {
        let sample = self.sample_at(&arguments.sample)?;
        let whole = self.textons(arguments)?;
        let options = &arguments.options;
        let work = [
            options.chosen_of(sample.images as usize) as f64,
            f64::from(options.image_grid),
            channels_of(options),
        ];
        let shards = f64::from(shards);
        Some(cost::textons_in_shards(whole, sample, work, shards))
    }

    /// Of a mesh that is made already, the input need not be read.
    fn mesh(&mut self, arguments: &mesh::Arguments, is_done: bool) -> Option<Cost> {
        let asked = arguments.options.vertices.map(|count| count as f64);
        let own = match is_done {
            true => self.vertices_in(&arguments.output)?,
            false => self.vertices_in(&arguments.input)?,
        };
        let vertices = asked.unwrap_or(own);
        self.vertices.insert(arguments.output.clone(), vertices);
        Some(cost::mesh(own, asked, arguments.wants_field()))
    }

    fn synth(&mut self, arguments: &synth::Arguments) -> Option<Cost> {
        let vertices = self.vertices_in(arguments.mesh_path()?)?;
        self.vertices.insert(arguments.output.clone(), vertices);
        let options = &arguments.options;
        let is_atlas = arguments.target.is_atlas();
        let sites = match is_atlas {
            true => f64::from(arguments.target.atlas.resolution).powi(2),
            false => vertices,
        };
        let work = Workload {
            texels: self.samples.get(&arguments.space)?.texels,
            onto_atlas: is_atlas,
        };
        Some(cost::synth(options, work, sites))
    }

    fn render(&mut self, arguments: &render::Arguments) -> Option<Cost> {
        let frames = frame_count(&arguments.options) as usize;
        let own = match arguments.options.files.shard {
            None => frames,
            Some(shard) => (0..frames).filter(|place| shard.takes(*place)).count(),
        };
        self.cost_of_frames(arguments, own)
    }

    /// What so many frames of a rendering take.
    pub fn cost_of_frames(&mut self, arguments: &render::Arguments, frames: usize) -> Option<Cost> {
        let options = &arguments.options;
        let [width, height] = options.image.size.0.map(f64::from);
        let sequence = Sequence {
            frames: frames as f64,
            pixels: width * height,
            lights: light_count(options) as f64,
            by_pixel: options.image.shading == Shading::Pixel,
            shadows_by_pixel: options.image.shadows == Shadows::Pixel,
            has_fill: options.lights.fill > 0.0,
            has_ground: options.lights.ground,
            reads: match options.image.weights {
                Weighting::Quadratic => 1.5,
                Weighting::Continuous | Weighting::InverseAngle => 1.0,
            },
            table: (options.files.table_memory as f64) * f64::from(1 << 20),
        };
        let vertices = *self.vertices.get(&arguments.map)?;
        Some(cost::render(
            self.sample_at(&arguments.sample)?,
            vertices,
            sequence,
        ))
    }

    /// How many vertices a mesh has, where it is known or can be read.
    fn vertices_in(&mut self, path: &Path) -> Option<f64> {
        if let Some(vertices) = self.vertices.get(path) {
            return Some(*vertices);
        }
        let is_ply = path
            .extension()
            .is_some_and(|ending| ending.eq_ignore_ascii_case("ply"));
        let count = match is_ply {
            true => ply::vertex_count(path).ok()?,
            false => {
                let user = reading::read(path, self.progress).ok()?;
                user.mesh.positions.len()
            }
        };
        self.vertices.insert(path.to_path_buf(), count as f64);
        Some(count as f64)
    }
}

/// The channels that an analysis filters.
fn channels_of(options: &TextonOptions) -> f64 {
    if options.luminance { 1.0 } else { 3.0 }
}

/// The size of a sample that is there.
fn size_of(path: &Path) -> Option<SampleSize> {
    let sample = Sample::open(path).ok()?;
    Some(size_as_described(sample.description()))
}

fn size_as_described(sample: &Description) -> SampleSize {
    SampleSize {
        texels: sample.grid().len() as f64,
        images: sample.image_count() as f64,
        lights: sample.lights.len() as f64,
    }
}
