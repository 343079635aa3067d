//! `mesotex view`: a decorated surface as a page to turn in a browser.

use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;

use crate::btf::sample::{self, Sample};
use crate::cli::atlas::{self, Look};
use crate::cli::outcome::Outcome;
use crate::cli::outputs::{Files, Product};
use crate::cli::render::surface;
use crate::cli::session::{Common, Session};
use crate::cli::subcommand::Subcommand;
use crate::error::{Error, Result};
use crate::format::id::check_same;
use crate::format::ours::Format;
use crate::maps::vertex_map::SurfaceTextonMap;
use crate::render::Axis;
use crate::render::renderer::Shading;
use crate::report::page;
use crate::report::viewer::{ViewerOptions, viewer_page};

/// The error that factors may leave where none is asked for.
pub(in crate::cli) const DEFAULT_ERROR: f64 = 0.04;

/// Make a page that shows a decorated surface in a browser, to turn it and move the light.
///
/// The page needs WebGL 2 and nothing from the network. The sample is factored for it, and the page states the error.
/// A page has up to 30 MB; a surface that is too large for it is reduced.
#[derive(Clone, Debug, Args)]
#[command(after_help = "\
Examples:
  mesotex view weave.sample bunny.map.ply -o bunny.html
  mesotex view leaf.sample bunny.atlas -o leaf.html
  mesotex view weave.sample scan.map.ply -o scan.html --up z --error 0.1")]
pub struct Arguments {
    /// The sample, NAME.sample.
    pub sample: PathBuf,
    /// What was synthesized from it: a surface texton map, NAME.map.ply, an atlas, NAME.atlas, or a face map,
    /// NAME.faces.ply.
    pub map: PathBuf,
    /// The page to write, NAME.html.
    #[arg(short, long, value_name = "PAGE.html")]
    pub output: PathBuf,
    /// Largest error of the sample's factors, relative to the root mean square of all values. The error is larger if
    /// the page would otherwise exceed its size limit.
    #[arg(long, value_name = "E", default_value_t = DEFAULT_ERROR)]
    pub error: f64,
    /// The axis of the mesh that points up.
    #[arg(long, value_enum, default_value_t, allow_hyphen_values = true)]
    pub up: Axis,
    /// The side of the mesh that is seen first. [default: chosen from the mesh's shape, as `render` does]
    #[arg(long, value_enum, value_name = "AXIS", allow_hyphen_values = true)]
    pub front: Option<Axis>,
    /// Make the page even if the map was made from a sample with another id.
    #[arg(long)]
    pub force: bool,
    #[command(flatten)]
    pub common: Common,
}

impl Subcommand for Arguments {
    fn common(&self) -> &Common {
        &self.common
    }

    fn check(&self) -> Result<()> {
        page::check_ending(&self.output)?;
        self.options().validate()
    }

    fn files(&self) -> Result<Files> {
        Ok(Files::default()
            .read([&self.sample])
            .read(&sample::files_of(&self.sample))
            .read([&self.map])
            .read(&atlas::files(&self.map))
            .write("output", [&self.output], Product::File(Format::Page)))
    }

    fn run(&self, session: &Session) -> Result<Outcome> {
        // Claim the output, and read sample and map.
        let _locks = self.files()?.claim()?;
        let begun = Instant::now();
        let sample = Sample::open(&self.sample)?;
        let drawn_as = (Look::default(), Shading::Pixel);
        let map = surface::read(&self.map, drawn_as, session.progress())?.map;
        self.check_pair(&sample, &map)?;
        // Make the page.
        let title = name_of(&self.map);
        let made = viewer_page((&sample, &map), &title, &self.options(), session.progress())
            .map_err(|error| error.in_file(&self.map))?;
        page::write(&self.output, &made.html)?;
        // Tell what it holds.
        let megabytes = made.html.len() as f64 / 1e6;
        let mut outcome = Outcome::default().line(format!(
            "{} vertices, factors of up to {} eigentextures per view: error {:.2} % of the root mean square of all values",
            made.vertices,
            made.rank,
            100.0 * made.error
        ));
        for note in &made.notes {
            outcome = outcome.line(note.as_str());
        }
        Ok(outcome
            .line(format!("a page of {megabytes:.1} MB; open it in a browser"))
            .figure("vertices", made.vertices)
            .figure("relative_error", made.error)
            .figure("rank", made.rank)
            .figure("bytes", made.html.len())
            .figure("notes", made.notes)
            .figure("seconds", begun.elapsed().as_secs_f64())
            .wrote(&self.output))
    }
}

impl Arguments {
    fn options(&self) -> ViewerOptions {
        ViewerOptions {
            error: self.error,
            up: self.up,
            front: self.front,
        }
    }

    /// Refuses a map that was made from another sample.
    fn check_pair(&self, sample: &Sample, map: &SurfaceTextonMap) -> Result<()> {
        let (grid, [width, height]) = (sample.grid(), map.header.exemplar);
        if [grid.width, grid.height] != [width, height] {
            return Err(
                Error::data("exemplar", format!("{width} × {height} texels"))
                    .expected(format!(
                        "{} × {}, as the sample has",
                        grid.width, grid.height
                    ))
                    .advice("view a map with the sample it was synthesized from")
                    .in_file(&self.map),
            );
        }
        check_same("sample id", &map.header.sample, sample.id(), self.force)
            .map_err(|error| error.in_file(&self.map))
    }
}

/// What a product is called: its file's name up to the first dot that begins its kind.
pub(super) fn name_of(path: &Path) -> String {
    let name = path
        .file_name()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned();
    let kinds = [
        ".map.ply",
        ".faces.ply",
        ".atlas",
        ".ply",
        ".toml",
        ".sample",
    ];
    let kind = kinds.iter().find_map(|kind| name.strip_suffix(kind));
    kind.map_or(name.clone(), str::to_owned)
}
