//! What a run will take, before it begins: seconds and memory per stage, of the [`cost`](super::cost) model.
//!
//! Sizes come from the options of the stages, and from files that are there. What cannot be known before an earlier
//! stage has run, as the size of a data set that is not imported yet, is said to be unknown.

use std::path::Path;

use serde_json::{Value, json};

use crate::btf::bake::Samples;
use crate::btf::sample::Sample;
use crate::cli::exemplar::with_kind;
use crate::cli::machine::available_memory;
use crate::cli::run::check::Stage;
use crate::cli::run::cost::{self, Cost, SampleSize, Sequence, Synthesis};
use crate::cli::{Command, bake, exemplar, import, mesh, render, synth, textons};
use crate::error::Result;
use crate::format::{image, ply};
use crate::mesh::reading;
use crate::progress::Progress;
use crate::render::memory::{frame_count, light_count};
use crate::render::nearest::Weighting;
use crate::render::renderer::{Shading, Shadows};
use crate::synthesis::Effort;

/// Rays per texel and image that `--samples auto` takes on average.
const AUTO_SAMPLES: f64 = 12.0;
/// Rounds that `--polish auto` amounts to: none of a sample that tiles, about a third of one of others.
const AUTO_POLISH: f64 = 0.15;

/// A stage of a plan.
pub(super) struct PlannedStage {
    /// Its name.
    name: String,
    /// What it takes; `None` where that is not known yet.
    cost: Option<Cost>,
    /// Whether nothing is to be done.
    is_done: bool,
}

/// What a run takes.
pub(super) struct Plan {
    stages: Vec<PlannedStage>,
    threads: usize,
}

impl Plan {
    /// The plan of stages, of which some are done; `has_pages` where pages follow.
    pub(super) fn of(
        stages: &[Stage],
        done: &[bool],
        has_pages: bool,
        progress: Progress<'_>,
    ) -> Result<Self> {
        let mut sizes = Sizes {
            progress,
            sample: None,
            vertices: None,
        };
        let mut planned = Vec::new();
        for (stage, &is_done) in stages.iter().zip(done) {
            progress.check()?;
            planned.push(PlannedStage {
                name: stage.name.clone(),
                cost: sizes.cost_of(stage, is_done),
                is_done,
            });
        }
        if has_pages {
            planned.push(PlannedStage {
                name: "pages".into(),
                cost: sizes.cost_of_pages(),
                is_done: done.iter().all(|is_done| *is_done),
            });
        }
        Ok(Self {
            stages: planned,
            threads: rayon::current_num_threads(),
        })
    }

    /// What a person reads: the sum, then a line per stage.
    pub(super) fn lines(&self) -> Vec<String> {
        let to_run: Vec<&PlannedStage> =
            self.stages.iter().filter(|stage| !stage.is_done).collect();
        if to_run.is_empty() {
            return vec!["nothing to do: no stage has changed".into()];
        }
        let seconds = to_run.iter().filter_map(|stage| self.seconds(stage)).sum();
        let peak = to_run
            .iter()
            .filter_map(|stage| stage.cost)
            .map(|cost| cost.bytes)
            .fold(0.0, f64::max);
        let at_least = match to_run.iter().all(|stage| stage.cost.is_some()) {
            true => "about",
            false => "at least",
        };
        let threads = match self.threads {
            1 => "1 thread".to_owned(),
            count => format!("{count} threads"),
        };
        let mut lines = vec![format!(
            "plan: {at_least} {} and {} at the peak, on {threads}",
            duration(seconds),
            memory(peak)
        )];
        let names = self.stages.iter().map(|stage| stage.name.chars().count());
        let width = names.max().unwrap_or(0);
        lines.extend(self.stages.iter().map(|stage| self.line(stage, width)));
        let free = available_memory().filter(|free| peak > free.0 as f64);
        lines.extend(free.map(|free| format!("this machine has {free} free now")));
        lines
    }

    fn line(&self, stage: &PlannedStage, width: usize) -> String {
        let name = &stage.name;
        let takes = match (stage.is_done, stage.cost) {
            (true, _) => "nothing changed".into(),
            (false, None) => "not known yet: it depends on data that is not there".into(),
            (false, Some(cost)) => {
                let seconds = duration(cost.seconds_on(self.threads));
                format!("{seconds:>8}  {:>8}", memory(cost.bytes))
            }
        };
        format!("  {name:<width$}  {takes}")
    }

    fn seconds(&self, stage: &PlannedStage) -> Option<f64> {
        Some(stage.cost?.seconds_on(self.threads))
    }

    /// What a program reads.
    pub(super) fn figures(&self) -> Value {
        let stages = self.stages.iter().map(|stage| {
            json!({
                "stage": stage.name,
                "skipped": stage.is_done,
                "seconds": self.seconds(stage),
                "bytes": stage.cost.map(|cost| cost.bytes as u64),
            })
        });
        json!({"threads": self.threads, "stages": stages.collect::<Vec<_>>()})
    }
}

/// A time as a person says it.
fn duration(seconds: f64) -> String {
    match seconds {
        s if s < 9.95 => format!("{s:.1} s"),
        s if s < 99.5 => format!("{s:.0} s"),
        s if s < 5970.0 => format!("{:.0} min", s / 60.0),
        s => format!("{:.1} h", s / 3600.0),
    }
}

/// A size as a person says it.
fn memory(bytes: f64) -> String {
    let mebibytes = bytes / f64::from(1 << 20);
    match mebibytes < 999.5 {
        true => format!("{mebibytes:.0} MiB"),
        false => format!("{:.1} GiB", mebibytes / 1024.0),
    }
}

/// What is known of the inputs of later stages.
struct Sizes<'a> {
    progress: Progress<'a>,
    sample: Option<SampleSize>,
    vertices: Option<f64>,
}

impl Sizes<'_> {
    /// What a stage takes; what it makes is known to the next.
    fn cost_of(&mut self, stage: &Stage, is_done: bool) -> Option<Cost> {
        match &stage.command {
            Command::Bake(arguments) => self.bake(arguments),
            Command::Import(arguments) => self.import(arguments, is_done),
            Command::Exemplar(arguments) => self.exemplar(arguments, is_done),
            Command::Textons(arguments) => self.textons(arguments),
            Command::Gram(_) => Some(cost::gram()),
            Command::Knn(_) => Some(cost::knn(self.sample?.texels)),
            Command::Mesh(arguments) => self.mesh(arguments, is_done),
            Command::Synth(arguments) => self.synth(arguments),
            Command::Render(arguments) => self.render(arguments),
            _ => None,
        }
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
        self.sample = Some(size_of(&arguments.output).unwrap_or(sample));
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

    /// The size of a data set is known once it is imported.
    fn import(&mut self, arguments: &import::Arguments, is_done: bool) -> Option<Cost> {
        self.sample = is_done.then(|| size_of(&arguments.output)).flatten();
        None
    }

    fn exemplar(&mut self, arguments: &exemplar::Arguments, is_done: bool) -> Option<Cost> {
        let texels = match is_done {
            true => size_of(&with_kind(&arguments.output, "sample"))?.texels,
            false => {
                let image = image::read(arguments.images.first()?).ok()?;
                f64::from(image.width) * f64::from(image.height)
            }
        };
        self.sample = Some(SampleSize {
            texels,
            images: 1.0,
            lights: 1.0,
        });
        Some(cost::exemplar(texels))
    }

    fn textons(&mut self, arguments: &textons::Arguments) -> Option<Cost> {
        if self.sample.is_none() {
            self.sample = size_of(&arguments.sample);
        }
        let sample = self.sample?;
        let options = &arguments.options;
        let chosen = options.chosen_of(sample.images as usize) as f64;
        let channels = if options.luminance { 1.0 } else { 3.0 };
        let (count, grid) = (f64::from(options.textons), f64::from(options.image_grid));
        Some(cost::textons(sample, chosen, count, grid, channels))
    }

    /// Of a mesh that is made already, the input need not be read.
    fn mesh(&mut self, arguments: &mesh::Arguments, is_done: bool) -> Option<Cost> {
        let asked = arguments.options.vertices.map(|count| count as f64);
        let own = match is_done {
            true => self.vertices_in(&arguments.output)?,
            false => self.vertices_in(&arguments.input)?,
        };
        self.vertices = Some(asked.unwrap_or(own));
        Some(cost::mesh(own, asked, arguments.wants_field()))
    }

    fn synth(&mut self, arguments: &synth::Arguments) -> Option<Cost> {
        if self.vertices.is_none() {
            self.vertices = self.vertices_in(arguments.mesh_path()?);
        }
        let options = &arguments.options;
        let is_atlas = arguments.target.is_atlas();
        let sites = match is_atlas {
            true => f64::from(arguments.target.atlas.resolution).powi(2),
            false => self.vertices?,
        };
        let synthesis = Synthesis {
            method: options.method,
            search: options.k_coherence.search,
            polish: match options.k_coherence.polish {
                Effort::Auto => AUTO_POLISH,
                Effort::Rounds(rounds) => f64::from(rounds),
            },
            is_atlas,
        };
        Some(synthesis.cost(self.sample?.texels, sites))
    }

    fn render(&self, arguments: &render::Arguments) -> Option<Cost> {
        let options = &arguments.options;
        let [width, height] = options.image.size.0.map(f64::from);
        let sequence = Sequence {
            frames: frame_count(options) as f64,
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
        Some(cost::render(self.sample?, self.vertices?, sequence))
    }

    fn cost_of_pages(&self) -> Option<Cost> {
        Some(cost::pages(self.sample?, self.vertices?))
    }

    /// How many vertices a mesh has, where it can be read.
    fn vertices_in(&self, path: &Path) -> Option<f64> {
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
        Some(count as f64)
    }
}

/// The size of a sample that is there.
fn size_of(path: &Path) -> Option<SampleSize> {
    let sample = Sample::open(path).ok()?;
    Some(SampleSize {
        texels: sample.grid().len() as f64,
        images: sample.image_count() as f64,
        lights: sample.description().lights.len() as f64,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_said_in_fitting_units() {
        let said = [0.04, 9.94, 9.96, 99.0, 120.0, 7200.0].map(duration);
        assert_eq!(said, ["0.0 s", "9.9 s", "10 s", "99 s", "2 min", "2.0 h"]);
        assert_eq!([3e7, 3e9].map(memory), ["29 MiB", "2.8 GiB"]);
    }
}
