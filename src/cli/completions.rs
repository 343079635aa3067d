//! `mesotex completions`.

use clap::{Args, CommandFactory};
use clap_complete::Shell;

use crate::cli::CommandLine;
use crate::cli::outcome::Outcome;
use crate::cli::session::{Common, Session};
use crate::cli::subcommand::Subcommand;
use crate::error::Result;

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

impl Subcommand for Arguments {
    fn common(&self) -> &Common {
        &self.common
    }

    fn run(&self, _session: &Session) -> Result<Outcome> {
        let mut script = Vec::new();
        clap_complete::generate(
            self.shell,
            &mut CommandLine::command(),
            "mesotex",
            &mut script,
        );
        let script = String::from_utf8_lossy(&script);
        Ok(Outcome::default().line(script.trim_end()))
    }
}
