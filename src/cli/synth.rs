//! `mesotex synth`: space, neighbour table and a mesh (or a flat grid) in, surface texton map out.

mod pictures;
mod report;
mod target;

use std::path::PathBuf;
use std::time::Instant;

use clap::Args;

pub use crate::cli::synth::report::FORMAT as REPORT_FORMAT;

use crate::cli::outcome::Outcome;
use crate::cli::outputs::{Files, Product};
use crate::cli::session::{Common, Session};
use crate::cli::synth::pictures::{PictureArguments, Plane};
use crate::cli::synth::report::{Report, Seconds};
use crate::cli::synth::target::{Target, TargetArguments};
use crate::error::Result;
use crate::exemplar::neighbor_table::NeighborTable;
use crate::exemplar::space::Space;
use crate::format::gltf::companions::companions;
use crate::format::json;
use crate::format::ours::Format;
use crate::grid::TexCoord;
use crate::index::TextonLabel;
use crate::surface_map::SurfaceTextonMap;
use crate::synthesis::checkpoint::Checkpoint;
use crate::synthesis::engine::{Inputs, synthesize, textons};
use crate::synthesis::options::SynthesisOptions;
use crate::synthesis::quality::agreement;
use crate::synthesis::{check, quality};

/// How to go on after an interruption.
pub const IF_INTERRUPTED: &str =
    "type the same command with --resume to go on after the last finished level";

/// Synthesize the surface texton map.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  mesotex synth bark.space.npz bark.knn.npz bunny.ply -o bunny.map.ply
  mesotex synth bark.space.npz bark.knn.npz bunny.ply -o bunny.map.ply --levels 3 --texel 0.01
  mesotex synth bark.space.npz bark.knn.npz --grid 256x256 -o flat.map.ply --pictures flat
  mesotex synth bark.space.npz bark.knn.npz bunny.ply -o full.map.ply --search full --report full.json")]
pub struct Arguments {
    /// The surface texton space, NAME.space.npz
    pub space: PathBuf,
    /// The neighbour table made from it, NAME.knn.npz
    pub table: PathBuf,
    #[command(flatten)]
    pub target: TargetArguments,
    /// The surface texton map to write, NAME.map.ply
    #[arg(long, short)]
    pub output: PathBuf,
    #[command(flatten)]
    pub options: SynthesisOptions,
    /// Write the options and the quality figures as JSON
    #[arg(long, value_name = "FILE")]
    pub report: Option<PathBuf>,
    #[command(flatten)]
    pub pictures: PictureArguments,
    /// Take a table that was made from another space of the same size
    #[arg(long)]
    pub force: bool,
    /// Continue an interrupted run after its last finished level
    #[arg(long)]
    pub resume: bool,
    #[command(flatten)]
    pub common: Common,
}

impl Arguments {
    /// Runs the command.
    pub fn run(&self, session: &Session) -> Result<Outcome> {
        let _locks = self.files()?.claim()?;
        let options = SynthesisOptions {
            seed: session.seed(),
            ..self.options.clone()
        };
        let (space, table) = self.read_exemplar(&options)?;
        let started = Instant::now();
        let target = Target::prepare(&self.target, (&space, &table), &options, session)?;
        let inputs = Inputs {
            space: &space,
            table: &table,
            sites: target.sites(),
        };
        let prepared = started.elapsed();
        let checkpoint = Checkpoint::new(&self.output, inputs, &options)?;
        let coords = self.synthesize(inputs, &options, &checkpoint, session)?;
        let seconds = Seconds::new(prepared, started.elapsed());
        let (map, edges) = rayon::join(
            || surface_map(&space, &target, coords, options.seed),
            || target.edges(),
        );
        let (found, energies) = rayon::join(
            || {
                let progress = session.progress();
                quality::measure(inputs, &map.coords, &edges, options.seed, progress)
            },
            || {
                self.pictures
                    .energies(inputs, &map.coords, session.progress())
            },
        );
        let (found, energies) = (found?, energies?);
        let agreement = agreement::measure(inputs, &map.coords, &options, session.progress())?;
        let plan = check::complete(&space, &table, &options)?;
        let report = Report::new(&map, &options, &plan, found, agreement);
        let plane = Plane::of(&target);
        // The target is big and not needed any more: it is given back meanwhile.
        rayon::spawn(move || drop(target));
        let drawn = self.write(&map, &report, &plane, &energies)?;
        // Until here an interrupted or failed run is continued with --resume.
        if let Err(error) = checkpoint.remove() {
            session.progress().warn(error.to_string());
        }
        Ok(self.outcome(&report, seconds, &drawn))
    }

    /// Writes the map, the report and the pictures; returns the files beside map and report.
    fn write(
        &self,
        map: &SurfaceTextonMap,
        report: &Report,
        plane: &Plane,
        energies: &[f64],
    ) -> Result<Vec<PathBuf>> {
        let (written, drawn) = rayon::join(
            || {
                map.write(&self.output)?;
                let report_file = self.report.as_ref();
                report_file.map_or(Ok(()), |path| json::write(path, report))
            },
            || self.pictures.draw(plane, map, energies),
        );
        written.and(drawn)
    }

    /// Refuses options that no input could satisfy.
    pub fn check(&self) -> Result<()> {
        self.options.validate()?;
        self.target.surface.validate()
    }

    /// What the command reads and writes.
    pub fn files(&self) -> Result<Files> {
        let mut files = Files::default()
            .read([&self.space, &self.table])
            .read(&self.target.surface.guide)
            .write("output", [&self.output], Product::File(Format::Mesh))
            .write("report", &self.report, Product::File(Format::Json));
        if let Some(mesh) = &self.target.mesh {
            files = files.read([mesh]).read(&companions(mesh)?);
        }
        Ok(self.pictures.files(files))
    }

    fn read_exemplar(&self, options: &SynthesisOptions) -> Result<(Space, NeighborTable)> {
        let space = Space::read(&self.space)?;
        let table = NeighborTable::read(&self.table)?;
        let belongs = table.check_belongs_to(&space, self.force);
        belongs.map_err(|error| error.in_file(&self.table))?;
        check::complete(&space, &table, options)?;
        self.pictures.check(&space)?;
        Ok((space, table))
    }

    /// Synthesizes level after level, each kept for a run that is interrupted. A level that cannot be
    /// kept is told: the work goes on.
    fn synthesize(
        &self,
        inputs: Inputs<'_>,
        options: &SynthesisOptions,
        checkpoint: &Checkpoint,
        session: &Session,
    ) -> Result<Vec<TexCoord>> {
        let progress = session.progress();
        let begun = match self.resume {
            true => checkpoint.load(progress)?,
            false => None,
        };
        let keep = |map: &_| {
            if let Err(error) = checkpoint.save(map) {
                progress.warn(format!("{error}; the finished level is not kept"));
            }
            Ok(())
        };
        let map = synthesize(inputs, options, begun, keep, progress)?;
        Ok(map.coords)
    }

    fn outcome(&self, report: &Report, seconds: Seconds, drawn: &[PathBuf]) -> Outcome {
        let mut outcome = report.outcome(seconds).wrote(&self.output);
        for path in self.report.iter().chain(drawn) {
            outcome = outcome.wrote(path);
        }
        outcome.next(format!(
            "mesotex render NAME.sample {} -o frames",
            self.output.display()
        ))
    }
}

/// The map on the target's surface; vertices in no face hold nothing.
fn surface_map(
    space: &Space,
    target: &Target,
    coords: Vec<TexCoord>,
    seed: u64,
) -> SurfaceTextonMap {
    let grid = space.levels[0].grid;
    let mut map = SurfaceTextonMap {
        mesh: target.mesh().clone(),
        normals: target.normals(),
        orientations: target.orientations(),
        scale: target.scale().map(<[f32]>::to_vec),
        textons: textons(space, &coords),
        coords,
        exemplar: [grid.width, grid.height],
        texel: target.texel(),
        origin: target.origin(),
        seed,
        sample: space.sample.clone(),
        space: space.id.clone(),
    };
    let mut in_face = vec![false; map.mesh.positions.len()];
    for &vertex in map.mesh.triangles.iter().flatten() {
        in_face[vertex as usize] = true;
    }
    for vertex in (0..in_face.len()).filter(|&vertex| !in_face[vertex]) {
        map.coords[vertex] = TexCoord { s: 0.5, t: 0.5 };
        map.textons[vertex] = TextonLabel::NONE;
    }
    map
}
