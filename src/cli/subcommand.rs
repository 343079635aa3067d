//! What every command has: answers about its arguments, and its work.

use crate::cli::outcome::Outcome;
use crate::cli::outputs::Files;
use crate::cli::session::{Common, Session};
use crate::error::Result;

/// How to continue with a chain of stages after an interruption.
pub(in crate::cli) const CHAIN_IF_INTERRUPTED: &str = "type the same command to continue: finished stages \
    are skipped, an unfinished bake continues after its last complete image, any other stage starts over";
/// How to continue after an interruption of a command that keeps nothing unfinished.
pub(in crate::cli) const STAGE_IF_INTERRUPTED: &str =
    "type the same command to start over; this command keeps no unfinished work";

/// The arguments of a command.
pub(in crate::cli) trait Subcommand {
    /// The options of every command.
    fn common(&self) -> &Common;

    /// Refuses options that no input could satisfy.
    fn check(&self) -> Result<()> {
        Ok(())
    }

    /// What the command reads and writes.
    fn files(&self) -> Result<Files> {
        Ok(Files::default())
    }

    /// What a user types to continue after an interruption.
    fn if_interrupted(&self) -> &'static str {
        STAGE_IF_INTERRUPTED
    }

    /// Runs the command.
    fn run(&self, session: &Session) -> Result<Outcome>;
}
