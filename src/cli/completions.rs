//! `mesotex completions`.

use clap::{Args, CommandFactory};
use clap_complete::Shell;

use crate::cli::CommandLine;
use crate::cli::outcome::Outcome;
use crate::cli::session::Common;

/// Print a script that completes commands and options in a shell.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  mesotex completions bash > ~/.local/share/bash-completion/completions/mesotex
  mesotex completions zsh > ~/.zfunc/_mesotex
  mesotex completions fish > ~/.config/fish/completions/mesotex.fish")]
pub struct Arguments {
    /// The shell that the script is for.
    #[arg(value_enum)]
    pub shell: Shell,
    #[command(flatten)]
    pub common: Common,
}

impl Arguments {
    /// Runs the command.
    pub fn run(&self) -> Outcome {
        let mut script = Vec::new();
        clap_complete::generate(
            self.shell,
            &mut CommandLine::command(),
            "mesotex",
            &mut script,
        );
        Outcome::default().line(String::from_utf8_lossy(&script).trim_end())
    }
}
