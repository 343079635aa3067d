//! `mesotex man`.

use std::path::Path;

use clap::{Args, CommandFactory};
use clap_mangen::Man;

use crate::cli::CommandLine;
use crate::cli::failure::likely_names::suggestion;
use crate::cli::outcome::Outcome;
use crate::cli::session::{Common, Session};
use crate::cli::subcommand::Subcommand;
use crate::error::{Error, Result};

/// Print a manual page.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  mesotex man > mesotex.1
  mesotex man render > mesotex-render.1")]
pub struct Arguments {
    /// The command to explain. [default: mesotex as a whole]
    pub command: Option<String>,
    #[command(flatten)]
    pub common: Common,
}

impl Subcommand for Arguments {
    fn common(&self) -> &Common {
        &self.common
    }

    fn run(&self, _session: &Session) -> Result<Outcome> {
        let mut root = CommandLine::command();
        root.build();
        let explained = match &self.command {
            None => root,
            Some(name) => subcommand(&root, name)?,
        };
        let mut page = Vec::new();
        Man::new(explained)
            .render(&mut page)
            .map_err(Error::io(Path::new("manual page"), "write"))?;
        Ok(Outcome::default().line(String::from_utf8_lossy(&page).trim_end()))
    }
}

fn subcommand(root: &clap::Command, name: &str) -> Result<clap::Command> {
    let found = root.find_subcommand(name).cloned();
    found.ok_or_else(|| {
        let known = root.get_subcommands().map(clap::Command::get_name);
        let meant = suggestion(name, known);
        Error::option(
            "command",
            format!("{name}{meant}"),
            "a command of `mesotex --help`",
        )
    })
}
