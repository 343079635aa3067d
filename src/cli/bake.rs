//! `mesotex bake`: a material, from maps or built in, to a sample folder.

use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;
use serde_json::{Value, json};

use crate::btf::bake::export::write_surface;
use crate::btf::bake::maps::{self, MapOptions, MaterialSet, read_recipe, read_set};
use crate::btf::bake::material::Material;
use crate::btf::bake::presets::Preset;
use crate::btf::bake::preview::write_preview;
use crate::btf::bake::steepness::Steepness;
use crate::btf::bake::{BakeOptions, Baked, bake, bake_part, join};
use crate::btf::direction_set::DirectionSet;
use crate::btf::sample::{self, Sample};
use crate::btf::writer::SAMPLE_FOLDER;
use crate::cli::machine::Need;
use crate::cli::outcome::{Outcome, next_textons};
use crate::cli::outputs::{Files, Product};
use crate::cli::parts::{InShards, outcome_of_kept, refuse_other_seed};
use crate::cli::session::{Common, Session};
use crate::cli::subcommand::{STAGE_IF_INTERRUPTED, Subcommand};
use crate::error::Result;
use crate::format::ours::Format;
use crate::shard::Shard;

/// Bytes per texel that the material takes while it is made and baked, measured on presets of 1024 and 2048 texels per
/// side.
const BYTES_PER_TEXEL: u64 = 100;

/// Texels along the longer side, by default.
pub const SIZE: u32 = 128;

/// How to continue after an interruption.
const IF_INTERRUPTED: &str = "type the same command to continue after the last whole image";

/// Ray-trace a BTF from height, colour and roughness.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  mesotex bake --preset weave --size 64 -o weave.sample
  mesotex bake --preset cobbles --views bonn81 --lights bonn81 -o cobbles.sample
  mesotex bake bark.toml --size 128 --views fibonacci:50 --lights fibonacci:50 -o bark.sample
  mesotex bake Bricks075_2K-PNG/ --depth 0.03 --samples auto --error 0.01 -o bricks.sample
  mesotex bake --preset weave --size 64 --shard 0/2 -o weave.0of2  (and --shard 1/2 -o weave.1of2, elsewhere)
  mesotex bake --reduce weave.0of2 weave.1of2 -o weave.sample

A material file is TOML, its maps PNG, JPEG, TIFF, HDR or OpenEXR as well:
  height = \"height.png\"        # white is high
  height-mm = 12               # of white over black
  width-mm = 200               # of the whole map
  albedo = \"albedo.png\"        # or [0.5, 0.4, 0.3], linear
  roughness = 0.6              # or a map; without it the surface is matte (Lambert)
docs/bake.md lists all fields.")]
pub struct Arguments {
    /// A material file (TOML), or a folder of maps with the names that libraries and programs give them (ambientCG,
    /// Poly Haven, Poliigon and others; `mesotex info FOLDER` lists what is found).
    #[arg(required_unless_present_any = ["preset", "reduce"], conflicts_with_all = ["preset", "reduce"])]
    pub material: Option<PathBuf>,
    /// The sample folder to write, as bark.sample; with --shard, the folder of a part, as bark.0of3.
    #[arg(short, long)]
    pub output: PathBuf,
    /// A built-in procedural material.
    #[arg(long, value_enum)]
    pub preset: Option<Preset>,
    /// Texels along the longer side; maps are resampled to it by area averages.
    #[arg(long, default_value_t = SIZE)]
    pub size: u32,
    /// Also write a picture: relief beside flat texture, and a sheet of views × lights.
    #[arg(long, value_name = "FILE.png")]
    pub preview: Option<PathBuf>,
    /// Also write the surface as it is baked: heights in texels, albedo, roughness, metallic.
    #[arg(long, value_name = "FILE.npz")]
    pub surface: Option<PathBuf>,
    /// Bake only shard i of n (counted from 0) of the views and write it as a part; --reduce joins the parts. An
    /// existing part of the same material and options is kept.
    #[arg(long, value_name = "I/N", conflicts_with = "reduce")]
    pub shard: Option<Shard>,
    /// Join the parts of all shards to the sample that one run without --shard bakes, byte for byte.
    #[arg(long, value_name = "PART", num_args = 1..)]
    pub reduce: Vec<PathBuf>,
    #[command(flatten)]
    pub options: BakeOptions,
    #[command(flatten)]
    pub maps: MapOptions,
    #[command(flatten)]
    pub common: Common,
}

impl Subcommand for Arguments {
    fn common(&self) -> &Common {
        &self.common
    }

    fn check(&self) -> Result<()> {
        self.maps.validate()?;
        self.options.validate()
    }

    fn files(&self) -> Result<Files> {
        let maps = match &self.material {
            Some(path) => read_recipe(path)?.files(),
            None => Vec::new(),
        };
        let tables = [&self.options.views, &self.options.lights];
        let parts = self.reduce.iter().flat_map(|part| sample::files_of(part));
        Ok(Files::default()
            .read(&parts.collect::<Vec<_>>())
            .read(&self.material)
            .read(&maps)
            .read(tables.into_iter().filter_map(DirectionSet::file))
            .write("output", [&self.output], Product::Folder(&SAMPLE_FOLDER))
            .write("preview", &self.preview, Product::File(Format::Picture))
            .write("surface", &self.surface, Product::File(Format::Archive)))
    }

    fn if_interrupted(&self) -> &'static str {
        match self.reduce.is_empty() {
            true => IF_INTERRUPTED,
            false => STAGE_IF_INTERRUPTED,
        }
    }

    fn run(&self, session: &Session) -> Result<Outcome> {
        let options = BakeOptions {
            seed: session.seed(),
            ..self.options.clone()
        };
        let _locks = self.files()?.claim()?;
        if !self.reduce.is_empty() {
            return self.join(session);
        }
        let (material, found) = self.material(session)?;
        let material = options.applied_to(material)?;
        let started = Instant::now();
        let (output, progress) = (&self.output, session.progress());
        let baked = match self.shard {
            Some(shard) => bake_part(&material, &options, shard, output, progress)?,
            None => bake(&material, &options, output, progress)?,
        };
        if let Some(shard) = self.shard.filter(|_| baked.is_kept) {
            let kept = outcome_of_kept(output, shard, "material");
            return Ok(kept.figure("resumed", baked.resumed));
        }
        let seconds = started.elapsed().as_secs_f64();
        let mut outcome = self.outcome(found, &material, &baked, seconds);
        if let Some(path) = &self.surface {
            write_surface(&material, path)?;
            outcome = outcome.wrote(path);
        }
        if let Some(path) = &self.preview {
            write_preview(&material, &Sample::open(&self.output)?, path)?;
            outcome = outcome.wrote(path);
        }
        Ok(outcome)
    }
}

impl InShards for Arguments {
    fn parts(&self) -> &[PathBuf] {
        &self.reduce
    }
}

impl Arguments {
    /// Joins parts.
    fn join(&self, session: &Session) -> Result<Outcome> {
        if let Some(seed) = self.seed_of_parts()? {
            refuse_other_seed(session, seed)?;
        }
        let description = join(&self.reduce, &self.output, session.progress())?;
        let (views, lights) = (description.views.len(), description.lights.len());
        Ok(Outcome::default()
            .line(format!(
                "{}: {views} views × {lights} lights of {} parts",
                description.name,
                self.reduce.len()
            ))
            .figure("parts", self.reduce.len())
            .figure("name", description.name)
            .figure("width", description.width)
            .figure("height", description.height)
            .figure("views", views)
            .figure("lights", lights)
            .figure("id", description.id.to_string())
            .wrote(&self.output)
            .next(next_textons(&self.output)))
    }

    /// The seed that the first part states.
    fn seed_of_parts(&self) -> Result<Option<u64>> {
        let Some(part) = self.reduce.first() else {
            return Ok(None);
        };
        let part = Sample::open(part)?;
        Ok(part.description().source["seed"].as_u64())
    }

    /// Draws the relief that `sample` was baked from.
    pub fn draw_relief(&self, sample: &Sample, path: &Path, session: &Session) -> Result<()> {
        let (material, _) = self.material(session)?;
        write_preview(&self.options.applied_to(material)?, sample, path)
    }

    /// The material, at the size it is baked, and a report of how it was made.
    fn material(&self, session: &Session) -> Result<(Material, Outcome)> {
        let need = Need {
            bytes: BYTES_PER_TEXEL.saturating_mul(u64::from(self.size).pow(2)),
            work: format!("{0} × {0} texels", self.size),
            option: "size",
            advice: "a smaller --size".into(),
        };
        need.check()?;
        if let Some(preset) = self.preset {
            let material = preset.material(self.size, session.seed(), session.progress())?;
            return Ok((material, Outcome::default()));
        }
        let set = read_set(self.material.as_deref().unwrap_or(Path::new("")))?;
        let mut report = with_files(Outcome::default(), &set);
        let loaded = maps::material(&set.recipe?, &self.maps, self.size, session.progress())?;
        for note in loaded.notes {
            report = report.line(note);
        }
        if let Some(depth) = loaded.depth {
            report = report
                .line(format!("depth: {depth:.3} of the width"))
                .figure("depth", depth);
        }
        Ok((loaded.material, report))
    }

    fn outcome(&self, found: Outcome, material: &Material, baked: &Baked, seconds: f64) -> Outcome {
        let steepness = Steepness::of(material);
        let description = &baked.description;
        let (views, lights) = (description.views.len(), description.lights.len());
        let (width, height) = (description.width, description.height);
        let rate = baked.rays as f64 / seconds / 1e6;
        // Say what was baked.
        let outcome = match baked.resumed {
            0 => found,
            images => found.line(format!("resumed after {images} images")),
        };
        let outcome = outcome
            .line(format!(
                "{}: {width} × {height} texels, {views} views × {lights} lights",
                material.name
            ))
            .line(format!(
                "{} rays in {seconds:.2} s, {rate:.1} million per second",
                baked.rays
            ))
            .line(steepness.describe());
        // Add the figures, and what comes next.
        with_quality(outcome, &self.options, baked)
            .figure("slope_mean_deg", steepness.mean_deg)
            .figure("slope_p95_deg", steepness.p95_deg)
            .figure("light_in_brightest_hundredth", baked.glare)
            .figure("name", material.name.clone())
            .figure("width", width)
            .figure("height", height)
            .figure("views", views)
            .figure("lights", lights)
            .figure("resumed", baked.resumed)
            .figure("rays", baked.rays)
            .figure("view_rays", baked.view_rays)
            .figure("seconds", seconds)
            .figure("id", description.id.to_string())
            .figure("kept", false)
            .wrote(&self.output)
            .next(match self.shard {
                Some(_) => "mesotex bake --reduce PART... -o NAME.sample".into(),
                None => next_textons(&self.output),
            })
    }
}

/// Says how many samples texels took, what error they leave, and what was done to highlights.
fn with_quality(outcome: Outcome, options: &BakeOptions, baked: &Baked) -> Outcome {
    let mut outcome = outcome.figure("samples", baked.samples);
    if let Some(left) = baked.error_left {
        outcome = outcome
            .line(format!(
                "{:.1} samples per texel on average; the remaining error is {:.2} % of the radiance",
                baked.samples,
                100.0 * left
            ))
            .figure("error_left", left);
    }
    if let Some(roughness) = baked.widened_to {
        outcome = outcome
            .line(format!(
                "highlights are no narrower than the spacing of the directions: roughness {roughness:.2} or more \
                 (--angular-filter off keeps them)"
            ))
            .figure("widened_to_roughness", roughness);
    }
    if options.clamp {
        outcome = outcome
            .line(format!(
                "{} numbers beyond half precision were clamped",
                baked.clamped
            ))
            .figure("clamped", baked.clamped);
    }
    outcome
}

/// Says what every file of a material is used for, and what stands in for roles that no file plays.
pub fn with_files(mut outcome: Outcome, set: &MaterialSet) -> Outcome {
    for line in set.lines() {
        outcome = outcome.line(line);
    }
    let files: Vec<Value> = set
        .files
        .iter()
        .map(|file| {
            json!({
                "file": file.file.to_string_lossy(),
                "role": file.role,
                "used": file.used,
                "why": file.why,
            })
        })
        .collect();
    let defaults = set.defaults.iter();
    let defaults: Vec<Value> = defaults
        .map(|role| json!({ "role": role.role, "value": role.value }))
        .collect();
    outcome
        .figure("naming", set.naming)
        .figure("files", files)
        .figure("defaults", defaults)
}
