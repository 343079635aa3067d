//! `mesotex render`.

mod overviews;
pub(in crate::cli) mod surface;

use std::fs;
use std::path::PathBuf;
use std::time::Instant;

use clap::Args;

use crate::btf::sample::{self, Sample};
use crate::byte_size::ByteSize;
use crate::cli::atlas::{self, Look};
use crate::cli::clipped_colors::describe_clipped;
use crate::cli::info::kind::Kind;
use crate::cli::machine::Need;
use crate::cli::outcome::Outcome;
use crate::cli::outputs::{Files, Product};
use crate::cli::render::overviews::Overviews;
use crate::cli::render::surface::DrawnSurface;
use crate::cli::session::{Common, Session};
use crate::cli::subcommand::Subcommand;
use crate::error::{Error, Result};
use crate::format::image::encode_srgb8;
use crate::format::ours::Format;
use crate::maps::vertex_map::SurfaceTextonMap;
use crate::mesh::colored_vertices::{self, ColoredVertices};
use crate::render::memory;
use crate::render::option_values::Sweep;
use crate::render::options::RenderOptions;
use crate::render::sweep::{self, Inputs, Report};
use crate::textures::model::ModelOptions;
use crate::textures::surface_color::SurfaceColor;

/// How to continue after an interruption.
const IF_INTERRUPTED: &str =
    "type the same command with --skip-existing to keep the finished frames";

/// Render a decorated mesh to OpenEXR frames.
///
/// Each frame DIR/frame.0001.exr has a PNG preview beside it; a contact sheet shows them all. An atlas is drawn on
/// its mesh subdivided to about one vertex per texel, without its transparent texels. A face of a face map has one
/// colour with vertex shading, and shows the sample with pixel shading.
#[derive(Clone, Debug, Args)]
#[command(after_help = "\
Examples:
  mesotex render weave.sample bunny.map.ply -o frames
  mesotex render weave.sample bunny.map.ply -o frames --sweep light-azimuth --frames 48
  mesotex render weave.sample bunny.map.ply -o orbit --sweep view-orbit --shading pixel --animation gif
  mesotex render weave.sample bunny.map.ply -o studio --fill 0.12 --ground --light-radius 2 --background '#c8ccd0'
  mesotex render weave.sample bunny.map.ply -o closer --front x --zoom 2.5
  mesotex render weave.sample bunny.map.ply -o two --light sun:30,40 --light point:0,2,1,1.5
  mesotex render leaf.sample bunny.atlas -o frames --displace 0.02 --shading pixel
  mesotex render rust.sample bunny.faces.ply -o frames --texels bilinear
  mesotex render wicker.sample cow.atlas -o frames --surface-color '#2e8b57'
  mesotex render weave.sample bunny.map.ply -o part --frames 1-240x2 --skip-existing --shard 0/3")]
pub struct Arguments {
    /// The sample, NAME.sample.
    pub sample: PathBuf,
    /// What was synthesized from it: a surface texton map, NAME.map.ply, an atlas, NAME.atlas, or a face map,
    /// NAME.faces.ply.
    pub map: PathBuf,
    /// Folder of the frames; it is created if it does not exist.
    #[arg(short, long, value_name = "DIR")]
    pub output: PathBuf,
    /// Write the mesh with the vertices' colours under the first frame's view and light: bytes red, green,
    /// blue (sRGB), as MeshLab and Blender show them.
    #[arg(long, value_name = "FILE.ply")]
    pub vertex_colors: Option<PathBuf>,
    /// Also write the linear values, as floats r, g, b (`vertex_color` in Mitsuba).
    #[arg(long, requires = "vertex_colors")]
    pub linear_colors: bool,
    /// Render even if the map was made from a sample with another id.
    #[arg(long)]
    pub force: bool,
    /// Displace the surface of an atlas along its normals by X mesh units per unit of its height channel.
    #[arg(long, value_name = "X", allow_negative_numbers = true)]
    pub displace: Option<f64>,
    /// Matte colour of the surface where the alpha channel of an atlas is transparent, in place of holes: sRGB, numbers
    /// from 0 to 255.
    #[arg(long, value_name = "R,G,B|#RRGGBB")]
    pub surface_color: Option<SurfaceColor>,
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
        let model = ModelOptions {
            displace: self.displace,
            ..ModelOptions::default()
        };
        model.validate()
    }

    fn files(&self) -> Result<Files> {
        let table = match &self.options.sweep.kind {
            Sweep::File(path) => Some(path),
            _ => None,
        };
        let mut files = Files::default()
            .read_as(&[Kind::Sample], &self.sample)
            .read(&sample::files_of(&self.sample))
            .read_as(&[Kind::Map, Kind::Atlas, Kind::FaceMap], &self.map)
            .read(&atlas::files(&self.map))
            .read(table)
            .read(&self.options.camera.camera_path)
            .read(&self.options.lights.environment)
            .write("output", [&self.output], Product::Frames)
            .write(
                "vertex-colors",
                &self.vertex_colors,
                Product::File(Format::Ply),
            );
        if let Some(shard) = self.options.files.shard {
            // Shards of one sweep write one folder side by side; any other two runs may not.
            let mut name = self.output.clone().into_os_string();
            name.push(format!(".shard-{}-of-{}", shard.index, shard.count));
            files.writes[0].lock = Some(name.into());
            files.writes[1..]
                .iter_mut()
                .for_each(|colors| colors.lock = None);
        }
        Ok(files)
    }

    fn if_interrupted(&self) -> &'static str {
        IF_INTERRUPTED
    }

    fn run(&self, session: &Session) -> Result<Outcome> {
        let _locks = self.files()?.claim()?;
        let overviews = Overviews::new(&self.output, self.options.files.animation)?;
        let sample = Sample::open(&self.sample)?;
        let drawn_as = (self.look(), self.options.image.shading);
        let surface = surface::read(&self.map, drawn_as, session.progress())?;
        let DrawnSurface { map, cover, id } = surface;
        self.check_memory(&sample, &map)?;
        fs::create_dir_all(&self.output).map_err(Error::io(&self.output, "create"))?;
        let inputs = Inputs {
            sample: &sample,
            map: &map,
            map_id: &id,
            cover: cover.as_ref(),
            folder: &self.output,
            force: self.force,
        };
        let outcome = self.write_vertex_colors(&inputs, Outcome::default(), session)?;
        let start = Instant::now();
        let report = sweep::render(&inputs, &self.options, session.progress())?;
        let seconds = start.elapsed().as_secs_f64();
        let frames = report.files.iter().filter(|file| file.is_there);
        let outcome = describe(outcome, &report, &map, seconds)
            .wrote(&self.output)
            .put_inside(frames.flat_map(|file| [file.frame.clone(), file.preview.clone()]));
        overviews.add(outcome, &report.files, session.progress())
    }
}

impl Arguments {
    fn look(&self) -> Look {
        Look {
            displace: self.displace,
            surface_color: self.surface_color,
        }
    }

    /// Refuses frames, lights and tables that this machine has too little memory for.
    fn check_memory(&self, sample: &Sample, map: &SurfaceTextonMap) -> Result<()> {
        let options = &self.options;
        let (frames, table) = (
            memory::frame_bytes(options, map),
            memory::table_bytes(options, sample),
        );
        let table_is_more = table > frames;
        let need = Need {
            bytes: frames.saturating_add(table),
            work: match table_is_more {
                true => format!(
                    "the sample laid out for shading ({}) and frames",
                    ByteSize(table)
                ),
                false => format!("frames of {} and their lights", options.image.size),
            },
            option: if table_is_more {
                "table-memory"
            } else {
                "size"
            },
            advice:
                "a smaller --size, fewer --samples, lights or --frames, or a smaller --table-memory"
                    .into(),
        };
        need.check()
    }

    fn write_vertex_colors(
        &self,
        inputs: &Inputs,
        outcome: Outcome,
        session: &Session,
    ) -> Result<Outcome> {
        let Some(file) = &self.vertex_colors else {
            return Ok(outcome);
        };
        let (colors, _) = sweep::with_renderer(
            inputs,
            &self.options,
            session.progress(),
            |renderer, frames| match frames.first() {
                Some(first) => renderer.vertex_colors(&first.view, &first.lights),
                None => Ok(Vec::new()),
            },
        )?;
        let srgb: Vec<[u8; 3]> = colors.iter().map(|rgb| rgb.map(encode_srgb8)).collect();
        let vertices = ColoredVertices {
            normals: Some(&inputs.map.normals),
            srgb: &srgb,
            linear: self.linear_colors.then_some(&colors),
        };
        let map = inputs.map;
        colored_vertices::write(file, (&map.mesh, map.header.origin), vertices)?;
        Ok(describe_clipped(outcome, &colors).wrote(file))
    }
}

fn describe(outcome: Outcome, report: &Report, map: &SurfaceTextonMap, seconds: f64) -> Outcome {
    let Report {
        rendered,
        kept,
        replaced,
        ..
    } = report;
    // Tell what was rendered.
    let mut outcome = outcome.line(format!(
        "{rendered} frames of {} vertices in {seconds:.2} s",
        map.mesh.positions.len()
    ));
    if *rendered > 0 {
        let mebibytes = report.table_bytes as f64 / f64::from(1 << 20);
        let place = if report.table_mapped {
            "on disk"
        } else {
            "in memory"
        };
        outcome = outcome.line(format!(
            "copy of the sample for shading: {mebibytes:.0} MiB {place}"
        ));
    }
    // Tell what was chosen for the whole sweep.
    if let Some(front) = &report.front {
        outcome = outcome
            .line(front.describe())
            .figure("front", front.to_string());
    }
    if let Some(parallax) = &report.parallax {
        outcome = outcome
            .line(parallax.describe())
            .figure("parallax", parallax.heights.is_some());
    }
    // Tell what an earlier run had made.
    if *kept > 0 {
        outcome = outcome.line(format!("{kept} frames kept"));
    }
    if *replaced > 0 {
        outcome = outcome.line(format!(
            "{replaced} frames of other options or inputs made again"
        ));
    }
    outcome
        .figure("frames", *rendered)
        .figure("kept", *kept)
        .figure("replaced", *replaced)
        .figure("seconds", seconds)
        .figure("vertices", map.mesh.positions.len())
        .figure("table_bytes", report.table_bytes)
}
