//! `mesotex knn`.

use clap::Args;

use crate::cli::outcome::Outcome;
use crate::cli::session::{Common, Session};
use crate::error::{Error, Result};

/// The k nearest neighbours of every texel.
#[derive(Debug, Args)]
pub struct Arguments {
    #[command(flatten)]
    pub common: Common,
}

impl Arguments {
    /// Runs the command.
    pub fn run(&self, _session: &Session) -> Result<Outcome> {
        Err(Error::data("mesotex knn", "not built yet"))
    }
}
