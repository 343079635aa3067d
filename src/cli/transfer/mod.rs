//! `mesotex transfer`: other maps of the sample onto a surface that is synthesized already.

mod maps;
mod vertices;

use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;
use serde_json::json;

use crate::cli::atlas;
use crate::cli::exemplar::option_values::ImageEncoding;
use crate::cli::exemplar::reading::ReadingOptions;
use crate::cli::machine::Need;
use crate::cli::outcome::Outcome;
use crate::cli::outputs::{Files, Product};
use crate::cli::session::{Common, Session};
use crate::cli::subcommand::Subcommand;
use crate::cli::transfer::maps::MapFile;
use crate::error::{Error, Result};
use crate::format::ours::Format;
use crate::grid::TexelGrid;
use crate::maps::atlas_map::description::LARGEST;
use crate::maps::atlas_map::{AtlasMap, Description};
use crate::maps::face_map::FaceMap;
use crate::maps::vertex_map::SurfaceTextonMap;
use crate::textures::channel::SampleChannel;
use crate::textures::folder::{TEXTURES_FOLDER, Written, write_textures};
use crate::textures::memory;
use crate::textures::model::ModelOptions;
use crate::textures::transfer::{Canvas, check_finer};

/// Transfer other aligned maps of the sample to a synthesized surface.
///
/// Onto an atlas: a folder of texture maps and surface.glb that shows them. Onto a surface texton map: a
/// PLY whose vertices have the maps' values, colours as red, green and blue.
#[derive(Clone, Debug, Args)]
#[command(after_help = "\
Examples:
  mesotex transfer bunny.atlas --maps color.png height.png normal:bumps.png -o bunny.textures
  mesotex transfer bunny.atlas --maps color.png height:relief.exr -o relief.textures --displace 0.02
  mesotex transfer bunny.atlas --maps color-4k.png --finer 4 -o fine.textures
  mesotex transfer cow.atlas --maps color.png alpha.png -o green.textures --surface-color 46,139,87
  mesotex transfer bunny.map.ply --maps color.png mask:wear.png -o bunny.colors.ply")]
pub struct Arguments {
    /// What was synthesized: NAME.atlas or NAME.map.ply
    pub input: PathBuf,
    /// Images aligned with the sample, of its size or a multiple of it. KIND: color, height, mask, alpha or normal
    /// (green is up); without KIND the file's name decides, and a grey image counts as a height
    #[arg(long, required = true, num_args = 1.., value_name = "[KIND:]FILE")]
    pub maps: Vec<MapFile>,
    /// The folder to write for an atlas, the PLY for a surface texton map
    #[arg(long, short)]
    pub output: PathBuf,
    /// Opposite borders of the maps continue each other (for a surface texton map; an atlas states it itself)
    #[arg(long)]
    pub tile: bool,
    /// Make texture maps with N times the columns and rows of the atlas, so that maps larger than the sample keep
    /// their detail
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub finer: u32,
    /// How the numbers of colours encode light
    #[arg(long, value_enum, default_value = "auto")]
    pub encoding: ImageEncoding,
    #[command(flatten)]
    pub reading: ReadingOptions,
    #[command(flatten)]
    pub model: ModelOptions,
    #[command(flatten)]
    pub common: Common,
}

impl Subcommand for Arguments {
    fn common(&self) -> &Common {
        &self.common
    }

    fn check(&self) -> Result<()> {
        maps::check(&self.maps)?;
        if !(1..=LARGEST).contains(&self.finer) {
            return Err(Error::option(
                "finer",
                self.finer.to_string(),
                format!("1 to {LARGEST}"),
            ));
        }
        self.model.validate()?;
        FaceMap::refuse_at(&self.input)?;
        if !self.is_atlas() && self.input.is_dir() {
            let found = format!("{} is a folder without an atlas.json", self.input.display());
            return Err(Error::data("input", found).expected("NAME.atlas or NAME.map.ply"));
        }
        Ok(())
    }

    fn files(&self) -> Result<Files> {
        let maps = self.maps.iter().map(|map| &map.path);
        let files = Files::default().read([&self.input]).read(maps);
        Ok(match self.is_atlas() {
            true => files.read(&atlas::files(&self.input)).write(
                "output",
                [&self.output],
                Product::Folder(&TEXTURES_FOLDER),
            ),
            false => files.write("output", [&self.output], Product::File(Format::Ply)),
        })
    }

    fn run(&self, session: &Session) -> Result<Outcome> {
        let _locks = self.files()?.claim()?;
        let started = Instant::now();
        let outcome = match self.is_atlas() {
            true => self.onto_atlas(session)?,
            false => self.onto_vertices(session)?,
        };
        let seconds = started.elapsed().as_secs_f64();
        Ok(outcome.figure("seconds", seconds).wrote(&self.output))
    }
}

impl Arguments {
    /// Whether the input is an atlas.
    pub fn is_atlas(&self) -> bool {
        atlas::is_atlas(&self.input)
    }

    fn onto_atlas(&self, session: &Session) -> Result<Outcome> {
        let progress = session.progress();
        let description = AtlasMap::read_description(&self.input)?;
        check_finer([description.width, description.height], self.finer)?;
        let channels = self.channels(description.grid(), session)?;
        self.model.check_channels(&channels)?;
        self.check_memory(&description, &channels)?;
        let map = AtlasMap::read(&self.input)?;
        let canvas = Canvas::new(&map, self.finer).map_err(|error| error.in_file(&self.input))?;
        let textures = canvas.carry_all(&channels, progress)?;
        let written = write_textures(&self.output, &map, &textures, &self.model, progress)?;
        Ok(describe(&written, &self.output).line(format!(
            "{} maps on {}×{} texels",
            textures.len(),
            self.finer * map.width,
            self.finer * map.height
        )))
    }

    /// Refuses textures that this machine has too little memory for.
    fn check_memory(&self, description: &Description, channels: &[SampleChannel]) -> Result<()> {
        let bytes = memory::bytes_to_transfer(description, self.finer, channels, &self.model);
        if self.finer == 1 {
            return atlas::check_memory(&self.input, description, bytes);
        }
        let [width, height] = [description.width, description.height].map(|side| side * self.finer);
        let need = Need {
            bytes,
            work: format!("texture maps of {width}x{height} texels"),
            option: "finer",
            advice: "a smaller --finer, or fewer --maps".into(),
        };
        need.check()
    }

    fn onto_vertices(&self, session: &Session) -> Result<Outcome> {
        let map = SurfaceTextonMap::read(&self.input)?;
        let channels = self.channels(map.grid(self.tile), session)?;
        let properties = vertices::write(&self.output, &map, &channels)?;
        let vertices = map.mesh.positions.len();
        Ok(Outcome::default()
            .line(format!("{} maps on {vertices} vertices", channels.len()))
            .line(format!("properties {}", properties.join(", ")))
            .figure("vertices", vertices)
            .figure("properties", properties))
    }

    fn channels(&self, grid: TexelGrid, session: &Session) -> Result<Vec<SampleChannel>> {
        let mut reader = self.reading.reader();
        let channels = maps::read(&self.maps, (grid, self.finer), self.encoding, &mut reader)?;
        reader.finish(session.progress())?;
        Ok(channels)
    }
}

/// What a person and a program read of a folder of textures.
pub(in crate::cli) fn describe(written: &Written, folder: &Path) -> Outcome {
    let outcome = written
        .channels
        .iter()
        .fold(Outcome::default(), |outcome, channel| {
            outcome.line(format!("{}: {}", channel.file, channel.kind))
        });
    let model = written.model;
    let outcome = outcome.line(match model.edge {
        Some(edge) => format!(
            "surface.glb: {} triangles of at most {edge:.4} mesh units, displaced",
            model.triangles
        ),
        None => format!("surface.glb: {} triangles", model.triangles),
    });
    let files = written
        .channels
        .iter()
        .map(|channel| folder.join(&channel.file));
    outcome
        .figure("channels", json!(written.channels))
        .figure("model", json!(model))
        .put_inside(files)
}
