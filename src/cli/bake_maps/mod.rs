//! `mesotex bake-maps`: the decorated surface of a surface texton map into a texture map.

mod target;

use std::path::PathBuf;
use std::time::Instant;

use clap::Args;

use crate::btf::sample::{self, Sample};
use crate::cli::bake_maps::target::Target;
use crate::cli::machine::Need;
use crate::cli::outcome::Outcome;
use crate::cli::outputs::{Files, Product};
use crate::cli::session::{Common, Session};
use crate::cli::transfer::describe;
use crate::error::{Error, Result};
use crate::exemplar::channels::ChannelKind;
use crate::format::gltf::companions::companions;
use crate::format::id::ContentId;
use crate::format::image::Precision;
use crate::maps::vertex_map::SurfaceTextonMap;
use crate::mesh::atlas::padding;
use crate::render::memory;
use crate::render::options::RenderOptions;
use crate::render::renderer::Shading;
use crate::render::sequence::{Inputs, with_renderer};
use crate::textures::folder::{TEXTURES_FOLDER, write_set};
use crate::textures::model::{ModelOptions, Subject};
use crate::textures::texture::Texture;
use crate::textures::transfer::PADDED;

/// Columns and rows that a texture map may have.
const RESOLUTIONS: std::ops::RangeInclusive<u32> = 16..=16384;
/// Bytes that a texel takes at the peak.
const TEXEL: u64 = 160;

/// Options of rendering that a texture map has no use for.
const IDLE: [&str; 20] = [
    "sweep",
    "frames",
    "sweep_length",
    "sweep_from",
    "sweep_to",
    "turns",
    "size",
    "samples",
    "shading",
    "camera_path",
    "layers",
    "half",
    "float",
    "compression",
    "pattern",
    "skip_existing",
    "shard",
    "background",
    "animation",
    "mip",
];

/// Bake the decorated surface into texture maps, for one view and light.
///
/// Each texel is shaded as `render --shading pixel` shades the point it lies on. Writes DIR/color.png (by the
/// sRGB curve, for viewers), DIR/radiance.exr (linear) and DIR/surface.glb, unlit. A texel that faces away from
/// the camera is shaded as if it were seen at a grazing angle.
#[derive(Clone, Debug, Args)]
#[command(
    mut_args(|arg| match IDLE.contains(&arg.get_id().as_str()) {
        true => arg.hide(true),
        false => arg,
    }),
    after_help = "\
Examples:
  mesotex bake-maps weave.sample bunny.map.ply --unwrap -o bunny.baked
  mesotex bake-maps weave.sample bunny.map.ply --mesh bunny.glb -o bunny.baked --resolution 2048
  mesotex bake-maps weave.sample bunny.map.ply --unwrap -o night --light point:0,2,1 --camera-azimuth 90"
)]
pub struct Arguments {
    /// The sample, NAME.sample
    pub sample: PathBuf,
    /// The surface texton map made from it, NAME.map.ply
    pub map: PathBuf,
    /// The folder of the texture maps
    #[arg(short, long, value_name = "DIR")]
    pub output: PathBuf,
    /// The mesh whose texture coordinates are used: the one the map was made on, or another of the same
    /// surface, as the one it was retiled from [default: the map's own, with --unwrap]
    #[arg(long, value_name = "MESH")]
    pub mesh: Option<PathBuf>,
    /// Make new texture coordinates
    #[arg(long)]
    pub unwrap: bool,
    /// Columns and rows of the texture maps
    #[arg(long, value_name = "N", default_value_t = 1024)]
    pub resolution: u32,
    /// Bake even though the map was made from a sample with another id
    #[arg(long)]
    pub force: bool,
    #[command(flatten)]
    pub options: RenderOptions,
    #[command(flatten)]
    pub common: Common,
}

impl Arguments {
    /// Refuses options that no input could satisfy.
    pub fn check(&self) -> Result<()> {
        self.options.validate()?;
        self.check_idle()?;
        if self.mesh.is_none() && !self.unwrap {
            return Err(Error::option(
                "mesh",
                "not given, and a surface texton map has no texture coordinates",
                "--mesh MESH with texture coordinates, or --unwrap",
            ));
        }
        match RESOLUTIONS.contains(&self.resolution) {
            true => Ok(()),
            false => Err(Error::option(
                "resolution",
                self.resolution.to_string(),
                format!("{} to {}", RESOLUTIONS.start(), RESOLUTIONS.end()),
            )),
        }
    }

    /// Refuses options of frames and sweeps.
    fn check_idle(&self) -> Result<()> {
        let values = |options: &RenderOptions| {
            serde_json::to_value(options).map_err(|error| Error::data("options", error.to_string()))
        };
        let (given, default) = (values(&self.options)?, values(&RenderOptions::default())?);
        let changed = IDLE.iter().map(|name| name.replace('_', "-"));
        let mut changed = changed.filter(|name| given.get(name) != default.get(name));
        match changed.next() {
            None => Ok(()),
            Some(name) => Err(Error::option(
                name,
                "given for texture maps, which have one view and light and a --resolution",
                "options of camera, light, weights, texels and shadows",
            )),
        }
    }

    /// What the command reads and writes.
    pub fn files(&self) -> Result<Files> {
        let mut files = Files::default()
            .read([&self.sample])
            .read(&sample::files_of(&self.sample))
            .read([&self.map])
            .read(&self.options.environment)
            .write("output", [&self.output], Product::Folder(&TEXTURES_FOLDER));
        if let Some(mesh) = &self.mesh {
            files = files.read([mesh]).read(&companions(mesh)?);
        }
        Ok(files)
    }

    /// Runs the command.
    pub fn run(&self, session: &Session) -> Result<Outcome> {
        self.check()?;
        let _locks = self.files()?.claim()?;
        let (started, progress) = (Instant::now(), session.progress());
        let sample = Sample::open(&self.sample)?;
        let map = SurfaceTextonMap::read(&self.map)?;
        self.check_memory(&sample)?;
        let target = Target::new(
            &map,
            self.mesh.as_deref(),
            self.unwrap,
            self.resolution,
            progress,
        )?;
        let placed = target.placed(&map, progress)?;
        let inside = target.points.inside();
        let texel = (target.surface.mesh.area() / inside.max(1) as f64).sqrt();
        let options = RenderOptions {
            shading: Shading::Pixel,
            ..self.options.clone()
        };
        let inputs = Inputs {
            sample: &sample,
            map: &map,
            map_id: &ContentId::of_file(&self.map)?,
            folder: crate::format::atomic::parent(&self.output),
            force: self.force,
        };
        let colors = with_renderer(
            &inputs,
            &options,
            &progress,
            |renderer, frames| match frames.first() {
                Some(frame) => renderer.texel_colors(frame, &placed.hits, texel),
                None => Ok(Vec::new()),
            },
        )?;
        let textures = self.textures(&target, &colors);
        let subject = Subject {
            surface: &target.surface,
            origin: map.origin,
            texel,
            is_lit: true,
        };
        let model = ModelOptions::default();
        let written = write_set(
            &self.output,
            &subject,
            &map.sample,
            &textures,
            &model,
            progress,
        )?;
        let seconds = started.elapsed().as_secs_f64();
        Ok(describe(&written, &self.output)
            .line(format!(
                "{inside} texels in {} charts, {texel:.4} mesh units each, in {seconds:.2} s",
                target.atlas.charts
            ))
            .line(format!(
                "no texel lies farther than {:.2e} mesh units from the map's surface",
                placed.farthest
            ))
            .figure("texels", inside)
            .figure("charts", target.atlas.charts)
            .figure("texel", texel)
            .figure("farthest", placed.farthest)
            .figure("seconds", seconds)
            .wrote(&self.output))
    }

    /// Refuses textures that this machine has too little memory for.
    fn check_memory(&self, sample: &Sample) -> Result<()> {
        let side = u64::from(self.resolution);
        let need = Need {
            bytes: (side * side * TEXEL).saturating_add(memory::table_bytes(&self.options, sample)),
            work: format!("texture maps of {side}×{side} texels"),
            option: "resolution",
            advice: "a smaller --resolution or --table-memory".into(),
        };
        need.check()
    }

    /// The radiance as it is, and as viewers show it.
    fn textures(&self, target: &Target, colors: &[[f32; 3]]) -> [Texture; 2] {
        let most = colors.as_flattened().iter().copied().fold(1.0, f32::max);
        let mut radiance = Texture {
            name: "radiance".into(),
            kind: ChannelKind::Color,
            count: 3,
            low: 0.0,
            high: f64::from(most),
            precision: Precision::Float,
            width: self.resolution,
            height: self.resolution,
            numbers: colors.as_flattened().to_vec(),
        };
        let pairs = padding(&target.points, &target.atlas, &target.surface.mesh, PADDED);
        radiance.copy(&pairs);
        let mut filled: Vec<bool> = (0..colors.len())
            .map(|texel| target.points.is_inside(texel))
            .collect();
        pairs
            .iter()
            .for_each(|&(outside, _)| filled[outside as usize] = true);
        radiance.fill_rest(&filled);
        let gain = self.options.exposure.exp2();
        let shown = radiance
            .numbers
            .iter()
            .map(|value| (value * gain).clamp(0.0, 1.0));
        let color = Texture {
            name: "color".into(),
            high: 1.0,
            precision: Precision::Bits8,
            numbers: shown.collect(),
            ..radiance.clone()
        };
        [color, radiance]
    }
}
