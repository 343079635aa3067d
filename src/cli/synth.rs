//! `mesotex synth`: space, neighbour table and a mesh (or a flat grid) in, surface texton map out.

mod controls;
mod faces;
mod physical_scale;
mod pictures;
mod prepared;
mod product;
mod renamed;
mod report;
mod target;

use std::path::PathBuf;
use std::time::Instant;

use clap::Args;

pub use crate::cli::synth::report::FORMAT as REPORT_FORMAT;

use crate::cli::endings::check_stem;
use crate::cli::info::kind::{Kind, MESHES};
use crate::cli::outcome::Outcome;
use crate::cli::outputs::{Files, Product};
use crate::cli::session::{Common, Session};
use crate::cli::subcommand::Subcommand;
use crate::cli::synth::faces::{FaceOutputs, Request};
use crate::cli::synth::physical_scale::PhysicalTexel;
use crate::cli::synth::pictures::{PictureArguments, Plane};
use crate::cli::synth::renamed::RenamedOptions;
use crate::cli::synth::report::{AtlasFigures, Report, Seconds};
use crate::cli::synth::target::TargetArguments;
use crate::error::{Error, Result};
use crate::exemplar::neighbor_table::NeighborTable;
use crate::exemplar::space::Space;
use crate::format::json;
use crate::format::mesh_formats::companions;
use crate::format::ours::Format;
use crate::maps::vertex_map::SurfaceTextonMap;
use crate::sites::atlas::preparation::AtlasSurface;
use crate::sites::level::{SiteEdge, SiteHierarchy, Sites};
use crate::sites::target::{Target, WithSites};
use crate::sites::vertices::circles::CircleSource;
use crate::synthesis::all_levels::synthesize_planned;
use crate::synthesis::check::Plan;
use crate::synthesis::checkpoint::Checkpoint;
use crate::synthesis::inputs::{Inputs, LevelMap};
use crate::synthesis::level_choice::LevelChoice;
use crate::synthesis::map::surface_map;
use crate::synthesis::method::Figure;
use crate::synthesis::options::SynthesisOptions;
use crate::synthesis::pattern_controls::PatternControls;
use crate::synthesis::quality::Quality;
use crate::synthesis::quality::agreement::{self, Agreement};
use crate::synthesis::{check, quality};
use crate::textures::channel::SampleChannel;
use crate::textures::model::ModelOptions;

/// How to continue after an interruption.
const IF_INTERRUPTED: &str =
    "type the same command with --resume to continue after the last finished level";

/// Synthesize the surface texton map.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  mesotex synth bark.space.npz bark.knn.npz bunny.ply -o bunny.map.ply
  mesotex synth bark.space.npz bark.knn.npz bunny.ply -o bunny.map.ply --levels 3 --texel 0.01
  mesotex synth bark.space.npz bark.knn.npz bunny.ply -o bunny.map.ply --mesh-unit cm
  mesotex synth bark.space.npz bark.knn.npz --grid 256x256 -o flat.map.ply --pictures flat
  mesotex synth bark.space.npz bark.knn.npz bunny.ply -o full.map.ply --search full --report full.json
  mesotex synth bark.space.npz bark.knn.npz bunny.ply -o round.map.ply --method adaptive
  mesotex synth bark.space.npz bark.knn.npz bunny.ply -o copied.map.ply --method coherent
  mesotex synth bark.space.npz bark.knn.npz spot.obj -o spot.atlas --onto atlas --resolution 512 --method multiscale
  mesotex synth bark.space.npz bark.knn.npz quads.obj -o quads.atlas --onto atlas --charts faces --method coherent
  mesotex synth rust.space.npz bunny.ply -o bunny.faces.ply --method choosy --onto faces")]
pub struct Arguments {
    /// The surface texton space, NAME.space.npz
    pub space: PathBuf,
    /// The neighbour table made from it, NAME.knn.npz; --method choosy needs none
    #[arg(required_unless_present_any = ["mesh", "grid"])]
    pub table: Option<PathBuf>,
    #[command(flatten)]
    pub target: TargetArguments,
    /// The surface texton map to write, NAME.map.ply; with --onto atlas the folder NAME.atlas of textures, with --onto
    /// faces the face map NAME.faces.ply
    #[arg(long, short)]
    pub output: PathBuf,
    #[command(flatten)]
    pub options: SynthesisOptions,
    #[command(flatten)]
    pub renamed: RenamedOptions,
    /// Write the options and the quality figures as JSON
    #[arg(long, value_name = "FILE")]
    pub report: Option<PathBuf>,
    #[command(flatten)]
    pub pictures: PictureArguments,
    #[command(flatten)]
    pub faces: FaceOutputs,
    #[command(flatten)]
    pub model: ModelOptions,
    /// Accept a table that was made from another space of the same size
    #[arg(long)]
    pub force: bool,
    /// Continue an interrupted run after its last finished level
    #[arg(long)]
    pub resume: bool,
    #[command(flatten)]
    pub common: Common,
}

impl Subcommand for Arguments {
    fn common(&self) -> &Common {
        &self.common
    }

    fn check(&self) -> Result<()> {
        self.renamed.refuse()?;
        if let Some(name) = &self.pictures.pictures {
            check_stem(
                "pictures",
                name,
                &["coordinate.png", "label.png", "energy.png"],
            )?;
        }
        self.options.validate()?;
        self.target.check(self.options.method)?;
        product::check(&self.output, self.target.is_atlas(), &self.model)?;
        self.target.surface.validate()
    }

    fn files(&self) -> Result<Files> {
        if !self.is_onto_faces() {
            self.check_table_is_given()?;
        }
        let mut files = Files::default()
            .read_as(&[Kind::Archive], &self.space)
            .read(self.table_path())
            .read(&self.target.surface.guide)
            .read(&self.target.surface.keys)
            .write("output", [&self.output], product::product_at(&self.output))
            .write("report", &self.report, Product::File(Format::Json));
        if let Some(mesh) = self.mesh_path() {
            files = files.read_as(&MESHES, mesh).read(&companions(mesh)?);
        }
        Ok(self.faces.files(self.pictures.files(files)))
    }

    fn if_interrupted(&self) -> &'static str {
        match self.is_onto_faces() {
            true => faces::IF_INTERRUPTED,
            false => IF_INTERRUPTED,
        }
    }

    fn run(&self, session: &Session) -> Result<Outcome> {
        let _locks = self.files()?.claim()?;
        if self.is_onto_faces() {
            return self.run_on_faces(session);
        }
        let options = SynthesisOptions {
            seed: session.seed(),
            ..self.options.clone()
        };
        let (space, table) = self.read_exemplar()?;
        let started = Instant::now();
        let is_measured = self.report.is_some() || self.pictures.pictures.is_some();
        let physical = self.target.physical_texel(&space)?;
        let by_unit = |error| name_texel(physical, error);
        let (target, exemplar) = (self.target.with_texel(physical), (&space, &table));
        let user = target.read_mesh(session)?;
        let choice = target.choose_levels(exemplar, user.as_ref(), &options);
        let choice = choice.map_err(by_unit)?;
        let options = with_levels(options, choice.as_ref());
        let plan = check::complete_for(&space, &table, &options)?;
        let completed = (&options, &plan);
        let prepared = target.prepare(user, exemplar, completed, is_measured, session);
        let prepared = prepared.map_err(by_unit)?;
        let target = prepared.target;
        let done = target.sites.with(Job {
            arguments: self,
            space: &space,
            table: &table,
            target: &target,
            options: &options,
            plan: &plan,
            started,
            session,
        })?;
        let circles = prepared.circles.map(CircleSource::name);
        let report = Report::new(
            &done.map,
            &options,
            (&plan, choice.map(|choice| choice.reason)),
            (circles, AtlasFigures::of(&target)),
            done.measured.quality,
            done.measured.agreement,
            done.searched,
        );
        let plane = Plane::of(&target);
        let atlas = target.surface.atlas;
        // The sites are big and not needed any more: they are given back meanwhile.
        rayon::spawn(move || drop(target.sites));
        let finished = Finished {
            map: &done.map,
            atlas: atlas.as_deref(),
            space: &space,
            report: &report,
            plane: &plane,
            energies: &done.measured.energies,
        };
        let drawn = self.write(&finished, session)?;
        // Until here an interrupted or failed run is continued with --resume.
        if let Err(error) = done.checkpoint.remove() {
            session.progress().warn(error.to_string());
        }
        let next = product::next(&self.output, &space, &self.model);
        let outcome = self.outcome(&report, done.seconds, &drawn);
        Ok(describe_texel(physical, outcome).next(next))
    }
}

impl Arguments {
    fn run_on_faces(&self, session: &Session) -> Result<Outcome> {
        let space = Space::read(&self.space)?;
        self.read_table(&space)?;
        let Some(mesh) = self.mesh_path() else {
            return Err(Error::option("onto", "faces without a mesh", "SPACE MESH"));
        };
        let physical = self.target.physical_texel(&space)?;
        let request = Request {
            mesh,
            target: &self.target.with_texel(physical),
            options: &self.options,
            pictures: &self.pictures,
            outputs: &self.faces,
            output: &self.output,
            report: self.report.as_deref(),
        };
        let outcome = faces::run(&request, &space, session);
        let outcome = outcome.map_err(|error| name_texel(physical, error))?;
        Ok(describe_texel(physical, outcome))
    }

    /// Writes the map, the report and the pictures; returns the files beside map and report.
    fn write(&self, done: &Finished<'_>, session: &Session) -> Result<Vec<PathBuf>> {
        let (written, drawn) = rayon::join(
            || {
                let textures = (done.space, &self.model);
                let progress = session.progress();
                product::write(&self.output, done.map, done.atlas, textures, progress)?;
                let report_file = self.report.as_ref();
                report_file.map_or(Ok(()), |path| json::write(path, done.report))
            },
            || self.pictures.draw(done.plane, done.map, done.energies),
        );
        written.and(drawn)
    }

    /// Whether sites are faces.
    pub fn is_onto_faces(&self) -> bool {
        self.target.is_onto_faces(self.options.method)
    }

    /// Whether a model is among what is written: an atlas holds one.
    pub fn has_model(&self) -> bool {
        product::is_atlas(&self.output)
    }

    /// The mesh: the last of the files, as faces need no table before it.
    pub fn mesh_path(&self) -> Option<&PathBuf> {
        let only = self.table.as_ref().filter(|_| self.is_onto_faces());
        self.target.mesh.as_ref().or(only)
    }

    /// The table: what stands between space and mesh, where faces are written on.
    pub fn table_path(&self) -> Option<&PathBuf> {
        let is_mesh = self.is_onto_faces() && self.target.mesh.is_none();
        self.table.as_ref().filter(|_| !is_mesh)
    }

    /// Refuses two files where three are needed.
    fn check_table_is_given(&self) -> Result<()> {
        match self.target.mesh.is_some() || self.target.grid.is_some() {
            true => Ok(()),
            false => Err(Error::option(
                "method",
                format!("{} with two files", self.options.method.name()),
                "SPACE TABLE MESH, or SPACE TABLE --grid WxH; --method choosy alone needs no table",
            )),
        }
    }

    fn read_exemplar(&self) -> Result<(Space, NeighborTable)> {
        let space = Space::read(&self.space)?;
        let Some(table) = self.read_table(&space)? else {
            return Err(Error::option(
                "method",
                "no neighbour table",
                "SPACE TABLE MESH",
            ));
        };
        self.pictures.check(&space)?;
        self.model
            .check_channels(&SampleChannel::of_space(&space))?;
        Ok((space, table))
    }

    /// The table, if one is given; refuses that of another space.
    fn read_table(&self, space: &Space) -> Result<Option<NeighborTable>> {
        let Some(path) = self.table_path() else {
            return Ok(None);
        };
        let table = NeighborTable::read(path)?;
        let belongs = table.check_belongs_to(space, self.force);
        belongs.map_err(|error| error.in_file(path))?;
        Ok(Some(table))
    }

    fn outcome(&self, report: &Report, seconds: Seconds, drawn: &[PathBuf]) -> Outcome {
        let mut outcome = report.outcome(seconds).wrote(&self.output);
        for path in self.report.iter().chain(drawn) {
            outcome = outcome.wrote(path);
        }
        outcome
    }
}

/// An error about the texel, by the unit that it came from.
fn name_texel(physical: Option<PhysicalTexel>, error: Error) -> Error {
    match physical {
        Some(physical) => physical.name_in(error),
        None => error,
    }
}

/// Says how large a texel is, where it came from a unit.
fn describe_texel(physical: Option<PhysicalTexel>, outcome: Outcome) -> Outcome {
    match physical {
        Some(physical) => outcome.line(physical.describe()),
        None => outcome,
    }
}

/// Options with the levels that were chosen.
fn with_levels(options: SynthesisOptions, choice: Option<&LevelChoice>) -> SynthesisOptions {
    let levels = choice.map(|choice| choice.levels as u32);
    SynthesisOptions {
        levels: levels.or(options.levels),
        ..options
    }
}

/// What is written of a finished run.
struct Finished<'a> {
    map: &'a SurfaceTextonMap,
    atlas: Option<&'a AtlasSurface>,
    space: &'a Space,
    report: &'a Report,
    plane: &'a Plane,
    energies: &'a [f64],
}

/// The work on a target's sites.
struct Job<'a> {
    arguments: &'a Arguments,
    space: &'a Space,
    table: &'a NeighborTable,
    target: &'a Target,
    options: &'a SynthesisOptions,
    plan: &'a Plan,
    started: Instant,
    session: &'a Session,
}

/// What comes of it.
struct Done {
    map: SurfaceTextonMap,
    measured: Measured,
    checkpoint: Checkpoint,
    seconds: Seconds,
    searched: u64,
}

impl WithSites for Job<'_> {
    type Found = Result<Done>;

    fn run<const N: usize, S: Sites<N>>(self, sites: &SiteHierarchy<S>) -> Result<Done> {
        let inputs = Inputs {
            space: self.space,
            table: self.table,
            sites,
            controls: self.target.controls.as_ref(),
        };
        let options = self.options;
        // Synthesize, level after level.
        let prepared = self.started.elapsed();
        let checkpoint = Checkpoint::new(&self.arguments.output, inputs, options)?;
        let LevelMap {
            coords, searched, ..
        } = self.synthesize(inputs, &checkpoint)?;
        let seconds = Seconds::new(prepared, self.started.elapsed());
        // Make the map, and turn its edges by the exemplar's orientation.
        let (map, mut edges) = rayon::join(
            || surface_map(self.space, self.target, coords, options),
            || self.target.surface.edges(),
        );
        let pattern = PatternControls::of(self.space, options.method);
        pattern.turn_edges(&mut edges, &map.coords);
        // Measure on the sites of the table's window.
        let measured = self.target.with_measured(Measure {
            job: &self,
            map: &map,
            edges: &edges,
        });
        let measured = match measured {
            Some(measured) => measured?,
            None => self.measure_edges(&map, &edges, sites),
        };
        Ok(Done {
            map,
            measured,
            checkpoint,
            seconds,
            searched,
        })
    }
}

/// What is measured of a finished map.
struct Measured {
    quality: Quality,
    agreement: Option<Agreement>,
    energies: Vec<f64>,
}

/// The measuring of a finished map, in the table's square windows.
struct Measure<'a> {
    job: &'a Job<'a>,
    map: &'a SurfaceTextonMap,
    edges: &'a [SiteEdge],
}

impl WithSites for Measure<'_> {
    type Found = Result<Measured>;

    fn run<const N: usize, S: Sites<N>>(self, sites: &SiteHierarchy<S>) -> Result<Measured> {
        let Job {
            space,
            table,
            options,
            plan,
            session,
            arguments,
            ..
        } = self.job;
        let inputs = Inputs {
            space,
            table,
            sites,
            controls: None,
        };
        // Measure edges alone where the sites have another window.
        let (coords, progress) = (&self.map.coords, session.progress());
        let window = table.levels[0].neighborhood.offsets.len();
        if sites.levels[0].samples_per_site() != window {
            return Ok(self.job.measure_edges(self.map, self.edges, sites));
        }
        // Measure the figures, and beside them what pictures need.
        let (quality, energies) = rayon::join(
            || quality::measure(inputs, coords, self.edges, options.seed, progress),
            || arguments.pictures.energies(inputs, coords, progress),
        );
        let agreement = match options.method.reports(Figure::MetricAgreement) {
            true => agreement::measure(inputs, coords, (options, plan), progress)?,
            false => None,
        };
        Ok(Measured {
            quality: quality?,
            energies: energies?,
            agreement,
        })
    }
}

impl Job<'_> {
    /// Measures what needs no windows, where the target has not those of the table.
    fn measure_edges<const N: usize, S: Sites<N>>(
        &self,
        map: &SurfaceTextonMap,
        edges: &[SiteEdge],
        sites: &SiteHierarchy<S>,
    ) -> Measured {
        let areas = sites.levels[0].areas();
        Measured {
            quality: quality::measure_edges(self.space, &map.coords, edges, areas),
            energies: Vec::new(),
            agreement: None,
        }
    }

    /// Synthesizes level after level, each kept for a run that is interrupted. A level that cannot be kept is told:
    /// the work continues.
    fn synthesize<const N: usize, S: Sites<N>>(
        &self,
        inputs: Inputs<'_, S>,
        checkpoint: &Checkpoint,
    ) -> Result<LevelMap> {
        let progress = self.session.progress();
        let begun = match self.arguments.resume {
            true => checkpoint.load(progress)?,
            false => None,
        };
        let mut keep = |map: &_| {
            if let Err(error) = checkpoint.save(map) {
                progress.warn(format!("{error}; the finished level is not kept"));
            }
            Ok(())
        };
        let completed = (self.options, self.plan);
        synthesize_planned(inputs, completed, begun, &mut keep, progress)
    }
}
