//! What all commands share: their common options, threads, progress and interruption.

use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use clap::Args;

use crate::cli::interruption::Interruption;
use crate::cli::outcome::Outcome;
use crate::cli::terminal::Terminal;
use crate::error::{Error, Result};
use crate::progress::{Event, Progress};

/// Options of every command.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Common options")]
pub struct Common {
    /// Seed of all random numbers; the same seed gives the same bytes. Every command accepts it, even one without
    /// random numbers. [default: 0, or the scene's]
    #[arg(long)]
    pub seed: Option<u64>,
    /// Number of threads; the result does not depend on it. [default: all cores]
    #[arg(long)]
    pub threads: Option<usize>,
    /// Print nothing but errors.
    #[arg(long, short)]
    pub quiet: bool,
    /// Print each finished stage with its time on stderr.
    #[arg(long, short, conflicts_with = "quiet")]
    pub verbose: bool,
    /// Print the report, or the error, as JSON on stdout.
    #[arg(long)]
    pub json: bool,
    /// Skip the command if FILE.json records it as done with the same options and its inputs and outputs have not
    /// changed. Otherwise run it and record it there.
    #[arg(long, value_name = "FILE.json")]
    pub once: Option<PathBuf>,
}

/// One run of the program.
#[derive(Clone)]
pub struct Session {
    common: Common,
    terminal: Terminal,
    listener: Arc<dyn Fn(Event) + Sync + Send>,
    interruption: Interruption,
    /// Whether a report of a failed run was printed.
    has_reported: Arc<AtomicBool>,
}

impl Session {
    /// Sets up threads, progress and signals; `hint` says how to continue after an interruption.
    pub fn new(common: &Common, hint: &'static str) -> Result<Self> {
        set_threads(common.threads)?;
        let terminal = Terminal::new(common.quiet, common.verbose);
        let interruption = Interruption::listen(&terminal, hint)?;
        let drawn = terminal.clone();
        Ok(Self {
            common: common.clone(),
            terminal,
            listener: Arc::new(move |event| drawn.show(event)),
            interruption,
            has_reported: Arc::default(),
        })
    }

    /// The seed of everything drawn at random.
    pub fn seed(&self) -> u64 {
        self.common.seed.unwrap_or(0)
    }

    /// The seed that the user gave.
    pub fn given_seed(&self) -> Option<u64> {
        self.common.seed
    }

    /// The same session with another seed.
    #[must_use]
    pub fn with_seed(&self, seed: Option<u64>) -> Self {
        let mut session = self.clone();
        session.common.seed = seed;
        session
    }

    /// The same session with another seed where the user gave none.
    #[must_use]
    pub fn or_seed(&self, seed: Option<u64>) -> Self {
        self.with_seed(self.common.seed.or(seed))
    }

    /// Where library calls report their progress.
    pub fn progress(&self) -> Progress<'_> {
        Progress::new(&*self.listener, Some(self.interruption.flag()))
    }

    /// Whether and by what this run was asked to stop.
    pub fn interruption(&self) -> &Interruption {
        &self.interruption
    }

    /// Prints a line of a report that is not finished yet, for a person.
    pub fn say(&self, line: &str) -> Result<()> {
        self.terminal.clear();
        match self.common.json || self.common.quiet {
            true => Ok(()),
            false => print(&format!("{line}\n")),
        }
    }

    /// Prints what a command that failed has done so far, for a program.
    pub fn report_json(&self, outcome: &Outcome) -> Result<()> {
        match self.common.json {
            true => {
                self.has_reported.store(true, Ordering::Relaxed);
                self.report(outcome)
            }
            false => Ok(()),
        }
    }

    /// Whether an error is still to be printed for a program.
    pub fn owes_json(&self) -> bool {
        self.common.json && !self.has_reported.load(Ordering::Relaxed)
    }

    /// Prints a finished command's report, for a person or as JSON.
    pub fn report(&self, outcome: &Outcome) -> Result<()> {
        self.terminal.clear();
        let text = match (self.common.json, self.common.quiet) {
            (true, _) => format!("{:#}\n", outcome.json(&self.terminal.warnings())),
            (false, true) => return Ok(()),
            (false, false) => outcome.text(),
        };
        print(&text)
    }
}

/// Prints on stdout, at once also when that is piped.
fn print(text: &str) -> Result<()> {
    let mut stdout = io::stdout().lock();
    stdout
        .write_all(text.as_bytes())
        .and_then(|()| stdout.flush())
        .map_err(Error::io(Path::new("standard output"), "write the report"))
}

/// Bytes of a thread's stack: as much as a process's first thread mostly has, for commands run in one.
const STACK: usize = 8 << 20;

fn set_threads(threads: Option<usize>) -> Result<()> {
    if let Some(threads) = threads.filter(|threads| !(1..=1024).contains(threads)) {
        return Err(Error::option("threads", threads.to_string(), "1 to 1024"));
    }
    rayon::ThreadPoolBuilder::new()
        .num_threads(threads.unwrap_or(0))
        .stack_size(STACK)
        .build_global()
        .map_err(|error| match threads {
            Some(threads) => Error::option(
                "threads",
                format!("{threads}: {error}"),
                "threads this machine can start",
            ),
            None => Error::io(Path::new("threads"), "start")(io::Error::other(error)),
        })
}
