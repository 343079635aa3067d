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
mod parts;
mod plan;
mod render;
mod report;
pub mod run;
mod session;
mod subcommand;
mod synth;
mod terminal;
mod textons;
mod transfer;
mod unused_options;
mod vary;
mod view;

use std::ffi::OsString;
use std::process::ExitCode;

use clap::{CommandFactory, FromArgMatches, Parser};

use crate::cli::outcome::Outcome;
use crate::cli::outputs::Files;
use crate::cli::session::{Common, Session};
use crate::cli::subcommand::Subcommand;
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

/// Makes the list of commands; each row is the name of a command and the type of its arguments.
macro_rules! commands {
    ($($command:ident($arguments:ty),)+) => {
        // A doc comment here would replace the program's description on the help page.
        #[derive(Debug, clap::Subcommand)]
        pub(in crate::cli) enum Command {
            $($command($arguments),)+
        }

        impl Subcommand for Command {
            fn common(&self) -> &Common {
                match self { $(Self::$command(arguments) => arguments.common(),)+ }
            }

            fn check(&self) -> Result<()> {
                match self { $(Self::$command(arguments) => arguments.check(),)+ }
            }

            fn files(&self) -> Result<Files> {
                match self { $(Self::$command(arguments) => arguments.files(),)+ }
            }

            fn if_interrupted(&self) -> &'static str {
                match self { $(Self::$command(arguments) => arguments.if_interrupted(),)+ }
            }

            fn run(&self, session: &Session) -> Result<Outcome> {
                match self { $(Self::$command(arguments) => arguments.run(session),)+ }
            }
        }
    };
}

commands! {
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
