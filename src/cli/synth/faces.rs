//! `synth --onto faces`: a space and a mesh in, a face map out (Castellanos and Williams).

mod outputs;
mod report;

use std::path::{Path, PathBuf};
use std::time::Instant;

pub(super) use self::outputs::FaceOutputs;
use self::report::FaceReport;
use crate::btf::sample::Sample;
use crate::cli::machine::Need;
use crate::cli::outcome::Outcome;
use crate::cli::session::Session;
use crate::cli::synth::pictures::{PictureArguments, shown_colors};
use crate::cli::synth::report::Seconds;
use crate::cli::synth::target::TargetArguments;
use crate::error::{Error, Result};
use crate::exemplar::channels::ChannelKind;
use crate::exemplar::space::Space;
use crate::format::json;
use crate::maps::face_map::FaceMap;
use crate::mesh::face_colors::{ColoredMesh, Coloring, colored_base};
use crate::mesh::reading::{self, UserMesh};
use crate::sites::faces::plan::FacePlan;
use crate::sites::faces::pyramid::FacePyramid;
use crate::synthesis::faces::decorated::at_centers;
use crate::synthesis::faces::exemplar::SquareExemplar;
use crate::synthesis::faces::map::face_map;
use crate::synthesis::faces::memory::bytes_to_synthesize;
use crate::synthesis::options::SynthesisOptions;
use crate::synthesis::recipes::choosy::{ChoosyOptions, ChoosyResult, synthesize_faces};
use crate::textures::channel::SampleChannel;
use crate::textures::face_channels::carry_onto_faces;

/// How to continue after an interruption.
pub(super) const IF_INTERRUPTED: &str =
    "type the same command to start over; --onto faces keeps no unfinished work";

/// What the command was told.
pub(super) struct Request<'a> {
    /// The mesh.
    pub(super) mesh: &'a Path,
    /// How it is prepared.
    pub(super) target: &'a TargetArguments,
    /// How it is textured.
    pub(super) options: &'a SynthesisOptions,
    /// Where colours come from, and whether vertices have them.
    pub(super) pictures: &'a PictureArguments,
    /// What is written beside the map.
    pub(super) outputs: &'a FaceOutputs,
    /// The map.
    pub(super) output: &'a Path,
    /// The report.
    pub(super) report: Option<&'a Path>,
}

/// Runs the command.
pub(super) fn run(arguments: &Request<'_>, space: &Space, session: &Session) -> Result<Outcome> {
    let progress = session.progress();
    let channels = channels(arguments, space)?;
    let path = arguments.mesh;
    let started = Instant::now();
    // Prepare the exemplar and the faces.
    let user = reading::read(path, progress)?;
    let plan = plan(arguments, space, &user, session)?;
    let spectrum = arguments.options.spectrum;
    let exemplar = SquareExemplar::new(space, plan.side, spectrum);
    let bytes = check_memory(arguments, &user, &plan, exemplar.channels)?;
    let in_mesh = |error: Error| error.in_file(path);
    let base = base_mesh(arguments, &user, &plan, session).map_err(in_mesh)?;
    let surface = FacePyramid::subdivided(&base, plan.subdivisions, progress)?;
    let prepared = started.elapsed();
    // Synthesize.
    let options = ChoosyOptions {
        seed: session.seed(),
        ..arguments.options.choosy.clone()
    };
    let result =
        synthesize_faces(exemplar.image(), &surface, &options, progress).map_err(in_mesh)?;
    let seconds = Seconds::new(prepared, started.elapsed());
    // Make a map of the sources, and carry the channels onto it.
    let finished = (&surface, &result);
    let mut map = face_map(
        space,
        finished,
        exemplar.square,
        (user.origin, session.seed()),
    );
    let centers = at_centers(&map)?;
    carry_onto_faces(&mut map, &centers, &channels);
    // Write and tell.
    let report = FaceReport::new(
        (&map, &result, &surface),
        (space, &exemplar, &centers),
        (arguments.options, session.seed()),
        (base.coloring, bytes),
    );
    let written = write(arguments, finished, &map, &report)?;
    let mut outcome = report.outcome(seconds);
    for path in &written {
        outcome = outcome.wrote(path);
    }
    Ok(outcome.next(format!(
        "mesotex render NAME.sample {} -o frames",
        arguments.output.display()
    )))
}

/// The channels that the faces are given: those of the space, and the colours of `--sample` where it has none.
fn channels(arguments: &Request<'_>, space: &Space) -> Result<Vec<SampleChannel>> {
    let mut channels = SampleChannel::of_space(space);
    let has_colors = channels
        .iter()
        .any(|channel| channel.kind == ChannelKind::Color);
    match (&arguments.pictures.sample, has_colors) {
        (Some(path), true) => Err(Error::option(
            "sample",
            format!("{}, but the space has colours of its own", path.display()),
            "no --sample, or a space of textons",
        )),
        (None, false) => {
            arguments
                .outputs
                .refuse_without_colors(arguments.pictures)?;
            Ok(channels)
        }
        (None, true) => Ok(channels),
        (Some(path), false) => {
            arguments.pictures.check_size(space)?;
            let colors = shown_colors(&Sample::open(path)?)?;
            let (name, grid) = ("color".into(), space.levels[0].grid);
            let color = SampleChannel::of_image(name, ChannelKind::Color, colors, grid, 1);
            channels.push(color.map_err(|error| error.in_file(path))?);
            Ok(channels)
        }
    }
}

/// Plans the surface, and says what is left out of the sample and what was repaired.
fn plan(
    arguments: &Request<'_>,
    space: &Space,
    user: &UserMesh,
    session: &Session,
) -> Result<FacePlan> {
    let grid = space.levels[0].grid;
    let sample = ([grid.width, grid.height], space.levels.len());
    let target = &arguments.target;
    let plan = FacePlan::new(&user.mesh, sample, &target.faces, target.surface.texel)?;
    if [grid.width, grid.height] != [plan.side; 2] {
        session.progress().warn(format!(
            "the sample has {} × {} texels; its middle {side} × {side} are used: a square that {} subdivisions halve",
            grid.width,
            grid.height,
            plan.subdivisions,
            side = plan.side
        ));
    }
    if user.report.cut_edges > 0 {
        session.progress().warn(format!(
            "the mesh was cut at {} edges where more than two triangles meet: the texture is not continued across them",
            user.report.cut_edges
        ));
    }
    Ok(plan)
}

/// Refuses a surface that this machine has too little memory for; returns what it takes.
fn check_memory(
    arguments: &Request<'_>,
    user: &UserMesh,
    plan: &FacePlan,
    channels: usize,
) -> Result<u64> {
    let dimensions = arguments.options.choosy.dimensions;
    let has_model = arguments.outputs.glb.is_some();
    let bytes = bytes_to_synthesize(&user.mesh, plan, (channels, dimensions), has_model);
    let need = Need {
        bytes,
        work: format!("{} faces of {channels} numbers", plan.faces()),
        option: "subdivisions",
        advice: "fewer --subdivisions or --base-faces, a larger --texel, or a smaller sample"
            .into(),
    };
    need.check()?;
    Ok(bytes)
}

/// The base mesh; says so where it has its two colours by the fallback.
fn base_mesh(
    arguments: &Request<'_>,
    user: &UserMesh,
    plan: &FacePlan,
    session: &Session,
) -> Result<ColoredMesh> {
    let crease = arguments.target.surface.crease.to_radians();
    let base = colored_base(&user.mesh, plan.base_faces, crease, session.progress())?;
    if base.coloring == Coloring::Barycentric {
        session.progress().warn(format!(
            "no base mesh of {} triangles in two colours was found: one with a sixth of them is subdivided barycentrically",
            plan.base_faces
        ));
    }
    Ok(base)
}

/// Writes everything that was asked for; returns the files.
fn write(
    arguments: &Request<'_>,
    finished: (&FacePyramid, &ChoosyResult),
    map: &FaceMap,
    report: &FaceReport,
) -> Result<Vec<PathBuf>> {
    map.write(arguments.output)?;
    let mut written = vec![arguments.output.to_path_buf()];
    if let Some(path) = arguments.report {
        json::write(path, report)?;
        written.push(path.to_path_buf());
    }
    let vertex_colors = arguments.pictures.vertex_colors.as_deref();
    written.extend(arguments.outputs.write(finished, map, vertex_colors)?);
    Ok(written)
}
