//! The command line: one file per subcommand, each options → library call → what the user reads.
//!
//! This room alone sees all others, and alone prints: reports on stdout, progress and warnings
//! on stderr. Exit code 0: done; 1: the data or the machine is at fault; 2: the usage is; 129, 130,
//! 143: stopped by SIGHUP, SIGINT, SIGTERM.

mod atlas;
mod bake;
mod bake_maps;
mod clipped_colors;
mod completions;
mod demo;
mod endings;
mod exemplar;
mod export;
mod factor;
mod failure;
mod gram;
mod heights;
mod import;
mod info;
mod init;
mod interruption;
mod knn;
mod machine;
mod manual;
mod mask;
mod mesh;
mod once;
mod outcome;
mod outputs;
mod plan;
mod render;
mod report;
pub mod run;
mod session;
mod synth;
mod terminal;
mod textons;
mod transfer;
mod unused_options;
mod vary;
mod view;

use std::ffi::OsString;
use std::process::ExitCode;

use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};

use crate::cli::outcome::Outcome;
use crate::cli::outputs::Files;
use crate::cli::session::{Common, Session};
use crate::error::{Error, Result};
use crate::format::guard;

/// Puts measured appearance on real geometry: BTF textons, synthesis on meshes, OpenEXR frames.
#[derive(Debug, Parser)]
#[command(
    name = "mesotex",
    version,
    propagate_version = true,
    max_term_width = 100,
    after_help = EXAMPLES
)]
struct CommandLine {
    #[command(subcommand)]
    command: Command,
}

impl CommandLine {
    /// The command of a command line, and which options were given.
    fn read<W>(
        words: impl IntoIterator<Item = W>,
    ) -> std::result::Result<(Command, unused_options::Given), clap::Error>
    where
        W: Into<OsString> + Clone,
    {
        let mut command = Self::command();
        let matches = command.try_get_matches_from_mut(words)?;
        let given = unused_options::Given::of(&command, &matches);
        let line = Self::from_arg_matches(&matches).map_err(|error| error.format(&mut command))?;
        Ok((line.command, given))
    }
}

/// What stands below the list of commands.
const EXAMPLES: &str = "\
Examples:
  mesotex demo -o demo                                     everything below on built-in inputs
  mesotex init --material Bricks075_2K-PNG/ --mesh bunny.obj
                                                           a scene of everything below, for `mesotex run`
  mesotex bake Bricks075_2K-PNG/ -o bricks.sample          a BTF from a folder of texture maps
  mesotex import capture/ -o coin.sample                   a BTF from photographs or a measured file
  mesotex textons bricks.sample -o bricks.textons.npz      its 3D textons
  mesotex gram bricks.textons.npz -o bricks.space.npz      their dot products
  mesotex knn bricks.space.npz -o bricks.knn.npz           the nearest neighbours of each texel
  mesotex synth bricks.space.npz bricks.knn.npz bunny.obj -o bunny.map.ply
  mesotex render bricks.sample bunny.map.ply -o frames --sweep light-azimuth --frames 48

Sets of directions (--views, --lights):
  12x5            12 azimuths at each of 5 polar angles, 15 to 75 degrees: 60 directions
  bonn81, bonn151 the directions of the measured data sets of Bonn
  fibonacci:N     N directions spread evenly over the hemisphere
  rings:THETA:COUNT[:OFFSET],...   rings of COUNT directions at polar angle THETA
  FILE.csv        a table with the columns theta_deg and phi_deg

`mesotex COMMAND --help` explains a command. `mesotex man COMMAND` prints its manual page.";

#[derive(Debug, Subcommand)]
pub(in crate::cli) enum Command {
    Demo(demo::Arguments),
    Bake(bake::Arguments),
    Import(import::Arguments),
    Factor(factor::Arguments),
    Export(export::Arguments),
    Heights(heights::Arguments),
    Init(init::Arguments),
    Info(info::Arguments),
    Textons(textons::Arguments),
    Gram(gram::Arguments),
    Knn(knn::Arguments),
    Exemplar(exemplar::Arguments),
    Mask(mask::Arguments),
    Vary(vary::Arguments),
    Mesh(mesh::Arguments),
    Synth(Box<synth::Arguments>),
    Render(render::Arguments),
    BakeMaps(bake_maps::Arguments),
    Transfer(transfer::Arguments),
    View(view::Arguments),
    Report(report::Arguments),
    Run(run::Arguments),
    Plan(plan::Arguments),
    Completions(completions::Arguments),
    Man(manual::Arguments),
}

/// How to continue with a chain of stages after an interruption.
const CHAIN_IF_INTERRUPTED: &str = "type the same command to continue: finished stages are skipped, \
    an unfinished bake continues after its last complete image, any other stage starts over";
/// How to continue after an interruption of a command that keeps nothing unfinished.
const STAGE_IF_INTERRUPTED: &str =
    "type the same command to start over; this command keeps no unfinished work";

impl Command {
    fn common(&self) -> &Common {
        match self {
            Self::Demo(arguments) => &arguments.common,
            Self::Bake(arguments) => &arguments.common,
            Self::Import(arguments) => &arguments.common,
            Self::Factor(arguments) => &arguments.common,
            Self::Export(arguments) => &arguments.common,
            Self::Heights(arguments) => &arguments.common,
            Self::Init(arguments) => &arguments.common,
            Self::Info(arguments) => &arguments.common,
            Self::Textons(arguments) => &arguments.common,
            Self::Gram(arguments) => &arguments.common,
            Self::Knn(arguments) => &arguments.common,
            Self::Exemplar(arguments) => &arguments.common,
            Self::Mask(arguments) => &arguments.common,
            Self::Vary(arguments) => arguments.common(),
            Self::Mesh(arguments) => &arguments.common,
            Self::Synth(arguments) => &arguments.common,
            Self::Render(arguments) => &arguments.common,
            Self::BakeMaps(arguments) => &arguments.common,
            Self::Transfer(arguments) => &arguments.common,
            Self::View(arguments) => &arguments.common,
            Self::Report(arguments) => &arguments.common,
            Self::Run(arguments) => &arguments.common,
            Self::Plan(arguments) => &arguments.common,
            Self::Completions(arguments) => &arguments.common,
            Self::Man(arguments) => &arguments.common,
        }
    }

    /// Refuses options that no input could satisfy.
    fn check(&self) -> Result<()> {
        match self {
            Self::Bake(arguments) => arguments.check(),
            Self::Export(arguments) => arguments.check(),
            Self::Heights(arguments) => arguments.options.validate(),
            Self::Textons(arguments) => arguments.options.validate(),
            Self::Knn(arguments) => arguments.options.validate(),
            Self::Exemplar(arguments) => arguments.check(),
            Self::Mask(arguments) => arguments.check(),
            Self::Vary(arguments) => arguments.check(),
            Self::Mesh(arguments) => arguments.check(),
            Self::Synth(arguments) => arguments.check(),
            Self::Render(arguments) => arguments.check(),
            Self::BakeMaps(arguments) => arguments.check(),
            Self::Transfer(arguments) => arguments.check(),
            Self::View(arguments) => arguments.check(),
            Self::Report(arguments) => arguments.check(),
            Self::Demo(arguments) => arguments.check(),
            Self::Plan(arguments) => arguments.check(),
            Self::Import(arguments) => arguments.check(),
            Self::Factor(_)
            | Self::Info(_)
            | Self::Init(_)
            | Self::Gram(_)
            | Self::Run(_)
            | Self::Completions(_)
            | Self::Man(_) => Ok(()),
        }
    }

    /// What the command reads and writes.
    fn files(&self) -> Result<Files> {
        match self {
            Self::Bake(arguments) => arguments.files(),
            Self::Import(arguments) => arguments.files(),
            Self::Factor(arguments) => Ok(arguments.files()),
            Self::Export(arguments) => Ok(arguments.files()),
            Self::Heights(arguments) => Ok(arguments.files()),
            Self::Init(arguments) => arguments.files(),
            Self::Textons(arguments) => Ok(arguments.files()),
            Self::Gram(arguments) => Ok(arguments.files()),
            Self::Knn(arguments) => Ok(arguments.files()),
            Self::Exemplar(arguments) => Ok(arguments.files()),
            Self::Mask(arguments) => Ok(arguments.files()),
            Self::Vary(arguments) => Ok(arguments.files()),
            Self::Mesh(arguments) => arguments.files(),
            Self::Synth(arguments) => arguments.files(),
            Self::Render(arguments) => Ok(arguments.files()),
            Self::BakeMaps(arguments) => arguments.files(),
            Self::Transfer(arguments) => Ok(arguments.files()),
            Self::View(arguments) => Ok(arguments.files()),
            Self::Report(arguments) => Ok(arguments.files()),
            Self::Plan(arguments) => Ok(arguments.files()),
            Self::Demo(_) | Self::Info(_) | Self::Run(_) | Self::Completions(_) | Self::Man(_) => {
                Ok(Files::default())
            }
        }
    }

    /// What a user types to continue after an interruption.
    fn if_interrupted(&self) -> &'static str {
        match self {
            Self::Bake(arguments) => arguments.if_interrupted(),
            Self::Import(arguments) => arguments.if_interrupted(),
            Self::Synth(arguments) => arguments.if_interrupted(),
            Self::Render(_) => render::IF_INTERRUPTED,
            Self::Run(_) | Self::Demo(_) => CHAIN_IF_INTERRUPTED,
            Self::Factor(_)
            | Self::Export(_)
            | Self::Heights(_)
            | Self::Info(_)
            | Self::Init(_)
            | Self::Textons(_)
            | Self::Gram(_)
            | Self::Knn(_)
            | Self::Exemplar(_)
            | Self::Mask(_)
            | Self::Vary(_)
            | Self::Mesh(_)
            | Self::BakeMaps(_)
            | Self::Transfer(_)
            | Self::View(_)
            | Self::Report(_)
            | Self::Plan(_)
            | Self::Completions(_)
            | Self::Man(_) => STAGE_IF_INTERRUPTED,
        }
    }

    fn run(&self, session: &Session) -> Result<Outcome> {
        match self {
            Self::Demo(arguments) => arguments.run(session),
            Self::Bake(arguments) => arguments.run(session),
            Self::Import(arguments) => arguments.run(session),
            Self::Factor(arguments) => arguments.run(session),
            Self::Export(arguments) => arguments.run(session),
            Self::Heights(arguments) => arguments.run(session),
            Self::Init(arguments) => arguments.run(session),
            Self::Info(arguments) => arguments.run(session),
            Self::Textons(arguments) => arguments.run(session),
            Self::Gram(arguments) => arguments.run(session),
            Self::Knn(arguments) => arguments.run(session),
            Self::Exemplar(arguments) => arguments.run(session),
            Self::Mask(arguments) => arguments.run(session),
            Self::Vary(arguments) => arguments.run(session),
            Self::Mesh(arguments) => arguments.run(session),
            Self::Synth(arguments) => arguments.run(session),
            Self::Render(arguments) => arguments.run(session),
            Self::BakeMaps(arguments) => arguments.run(session),
            Self::Transfer(arguments) => arguments.run(session),
            Self::View(arguments) => arguments.run(session),
            Self::Report(arguments) => arguments.run(session),
            Self::Run(arguments) => arguments.run(session),
            Self::Plan(arguments) => arguments.run(session),
            Self::Completions(arguments) => Ok(arguments.run()),
            Self::Man(arguments) => arguments.run(),
        }
    }
}

/// Runs the command line of this process.
pub fn main() -> ExitCode {
    guard::silence();
    let words: Vec<String> = std::env::args_os()
        .map(|word| word.to_string_lossy().into_owned())
        .collect();
    let (command, given) = match CommandLine::read(std::env::args_os()) {
        Ok(read) => read,
        Err(error) => return failure::refuse(&error, &words),
    };
    let as_json = command.common().json;
    // Values by themselves before combinations of them.
    let checked = command
        .check()
        .and_then(|()| unused_options::check(&command, &given));
    if let Err(error) = checked {
        return failure::fail(&error, as_json);
    }
    let session = match Session::new(command.common(), command.if_interrupted()) {
        Ok(session) => session,
        Err(error) => return failure::fail(&error, as_json),
    };
    // In a thread of the pool: one that waits outside is put to sleep and woken for every step that
    // is done in parallel.
    let run = || match &command.common().once {
        Some(record) => once::run(&command, &words[1..], record, &session),
        None => command.run(&session),
    };
    let result = rayon::scope(|_| run()).and_then(|outcome| session.report(&outcome));
    session.interruption().end();
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(Error::Interrupted) => {
            session.interruption().tell();
            ExitCode::from(session.interruption().exit_code())
        }
        Err(error) => failure::fail(&error, session.owes_json()),
    }
}
