//! `mesotex bake-maps`: the decorated surface of a surface texton map or of an atlas into texture maps.

mod onto_atlas;
mod onto_mesh;
mod target;

use std::path::PathBuf;
use std::time::Instant;

use clap::Args;

use crate::btf::sample::{self, Sample};
use crate::cli::atlas::{self, is_atlas};
use crate::cli::info::kind::Kind;
use crate::cli::machine::Need;
use crate::cli::outcome::Outcome;
use crate::cli::outputs::{Files, Product};
use crate::cli::session::{Common, Session};
use crate::cli::subcommand::Subcommand;
use crate::error::{Error, Result};
use crate::exemplar::channels::ChannelKind;
use crate::format::image::Precision;
use crate::format::mesh_formats::companions;
use crate::maps::face_map::FaceMap;
use crate::render::memory;
use crate::render::options::{ImageOptions, RenderOptions};
use crate::render::renderer::Shading;
use crate::textures::folder::TEXTURES_FOLDER;
use crate::textures::surface_color::SurfaceColor;
use crate::textures::texture::Texture;

/// Columns and rows that a texture map may have.
const RESOLUTIONS: std::ops::RangeInclusive<u32> = 16..=16384;
/// Columns and rows that it has by default.
const RESOLUTION: u32 = 1024;
/// Bytes that a texel takes at the peak.
const TEXEL: u64 = 160;

/// Options of rendering that a texture map has no use for: not shown in help, and refused.
pub(in crate::cli) const OPTIONS_OF_FRAMES: [&str; 23] = [
    "sweep",
    "frames",
    "sweep-length",
    "sweep-from",
    "sweep-to",
    "turns",
    "size",
    "samples",
    "shading",
    "camera-path",
    "layers",
    "half",
    "float",
    "compression",
    "pattern",
    "skip-existing",
    "shard",
    "background",
    "tone",
    "ground",
    "zoom",
    "animation",
    "mip",
];

/// Bake the decorated surface into texture maps, for one view and light.
///
/// Each texel is shaded as `render --shading pixel` shades the point it lies on; a texel of an atlas by its own
/// texture coordinate. Writes DIR/color.png (by the sRGB curve, for viewers), DIR/radiance.exr (linear) and
/// DIR/surface.glb, unlit. A texel that faces away from the camera is shaded as if it were seen at a grazing angle.
#[derive(Clone, Debug, Args)]
#[command(
    mut_args(|arg| match arg.get_long().is_some_and(|name| OPTIONS_OF_FRAMES.contains(&name)) {
        true => arg.hide(true),
        false => arg,
    }),
    after_help = "\
Examples:
  mesotex bake-maps weave.sample bunny.map.ply --unwrap -o bunny.baked
  mesotex bake-maps weave.sample bunny.atlas -o bunny.baked
  mesotex bake-maps weave.sample bunny.map.ply --mesh bunny.glb -o bunny.baked --resolution 2048
  mesotex bake-maps weave.sample bunny.map.ply --unwrap -o night --light point:0,2,1 --camera-azimuth 90"
)]
pub struct Arguments {
    /// The sample, NAME.sample
    pub sample: PathBuf,
    /// What was synthesized from it: a surface texton map, NAME.map.ply, or an atlas, NAME.atlas
    pub map: PathBuf,
    /// The folder of the texture maps
    #[arg(short, long, value_name = "DIR")]
    pub output: PathBuf,
    /// A mesh with texture coordinates: the one the map was made on, or one of the same surface, such as the mesh it
    /// was retiled from. [default: the map's own, with --unwrap]
    #[arg(long, value_name = "MESH")]
    pub mesh: Option<PathBuf>,
    /// Make new texture coordinates
    #[arg(long)]
    pub unwrap: bool,
    /// Columns and rows of the texture maps; an atlas has its own. [default: 1024]
    #[arg(long, value_name = "N")]
    pub resolution: Option<u32>,
    /// Matte colour of the surface where the alpha channel of an atlas is transparent, in place of holes: sRGB, numbers
    /// from 0 to 255
    #[arg(long, value_name = "R,G,B|#RRGGBB")]
    pub surface_color: Option<SurfaceColor>,
    /// Bake even if the map was made from a sample with another id
    #[arg(long)]
    pub force: bool,
    #[command(flatten)]
    pub options: RenderOptions,
    #[command(flatten)]
    pub common: Common,
}

impl Subcommand for Arguments {
    fn common(&self) -> &Common {
        &self.common
    }

    fn check(&self) -> Result<()> {
        self.options.validate()?;
        if is_atlas(&self.map) {
            return Ok(());
        }
        FaceMap::refuse_at(&self.map)?;
        if self.mesh.is_none() && !self.unwrap {
            return Err(Error::option(
                "mesh",
                "not given, and a surface texton map has no texture coordinates",
                "--mesh MESH with texture coordinates, or --unwrap",
            ));
        }
        match RESOLUTIONS.contains(&self.resolution()) {
            true => Ok(()),
            false => Err(Error::option(
                "resolution",
                self.resolution().to_string(),
                format!("{} to {}", RESOLUTIONS.start(), RESOLUTIONS.end()),
            )),
        }
    }

    fn files(&self) -> Result<Files> {
        let mut files = Files::default()
            .read_as(&[Kind::Sample], &self.sample)
            .read(&sample::files_of(&self.sample))
            .read_as(&[Kind::Map, Kind::Atlas, Kind::FaceMap], &self.map)
            .read(&atlas::files(&self.map))
            .read(&self.options.lights.environment)
            .write("output", [&self.output], Product::Folder(&TEXTURES_FOLDER));
        if let Some(mesh) = &self.mesh {
            files = files.read([mesh]).read(&companions(mesh)?);
        }
        Ok(files)
    }

    fn run(&self, session: &Session) -> Result<Outcome> {
        let _locks = self.files()?.claim()?;
        let started = Instant::now();
        let sample = Sample::open(&self.sample)?;
        let outcome = match is_atlas(&self.map) {
            true => self.bake_atlas(&sample, session)?,
            false => self.bake_map(&sample, session)?,
        };
        let seconds = started.elapsed().as_secs_f64();
        Ok(outcome.figure("seconds", seconds).wrote(&self.output))
    }
}

impl Arguments {
    fn resolution(&self) -> u32 {
        self.resolution.unwrap_or(RESOLUTION)
    }

    /// The options of one frame, shaded as pixels are.
    fn shading(&self) -> RenderOptions {
        RenderOptions {
            image: ImageOptions {
                shading: Shading::Pixel,
                ..self.options.image.clone()
            },
            ..self.options.clone()
        }
    }

    /// Refuses textures that this machine has too little memory for.
    fn check_memory(&self, side: u32, sample: &Sample) -> Result<()> {
        let texels = u64::from(side) * u64::from(side);
        let need = Need {
            bytes: (texels * TEXEL).saturating_add(memory::table_bytes(&self.shading(), sample)),
            work: format!("texture maps of {side}×{side} texels"),
            option: "resolution",
            advice: "a smaller --resolution or --table-memory".into(),
        };
        need.check()
    }

    /// The radiance as it is and as viewers show it, padded; `is_inside` says which texels lie in charts.
    fn textures(
        &self,
        [width, height]: [u32; 2],
        colors: Vec<[f32; 3]>,
        padding: &[(u32, u32)],
        is_inside: impl Fn(usize) -> bool,
    ) -> Vec<Texture> {
        // Keep the radiance as it is.
        let numbers = colors.into_flattened();
        let most = numbers.iter().copied().fold(1.0, f32::max);
        let mut radiance = Texture {
            name: "radiance".into(),
            kind: ChannelKind::Color,
            count: 3,
            low: 0.0,
            high: f64::from(most),
            precision: Precision::Float,
            width,
            height,
            numbers,
        };
        // Fill the surroundings of the charts.
        radiance.copy(padding);
        radiance.fill_beyond(padding, is_inside);
        // Show it as viewers do: exposed, clamped, in 8 bits.
        let gain = self.options.files.exposure.exp2();
        let shown = radiance
            .numbers
            .iter()
            .map(|value| (value * gain).clamp(0.0, 1.0));
        let color = Texture {
            name: "color".into(),
            kind: ChannelKind::Color,
            count: 3,
            low: 0.0,
            high: 1.0,
            precision: Precision::Bits8,
            width,
            height,
            numbers: shown.collect(),
        };
        vec![color, radiance]
    }
}
