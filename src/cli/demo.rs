//! `mesotex demo`.

use clap::Args;

use crate::cli::outcome::Outcome;
use crate::cli::session::{Common, Session};
use crate::error::{Error, Result};

/// Everything, on the built-in material and mesh.
#[derive(Debug, Args)]
pub struct Arguments {
    #[command(flatten)]
    pub common: Common,
}

impl Arguments {
    /// Runs the command.
    pub fn run(&self, _session: &Session) -> Result<Outcome> {
        Err(Error::data("mesotex demo", "not built yet"))
    }
}
