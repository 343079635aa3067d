//! What the commands that work in shards have in common: the parts they join, the seeds of parts, parts that are kept.

use std::path::{Path, PathBuf};

use crate::cli::outcome::Outcome;
use crate::cli::session::Session;
use crate::error::{Error, Result};
use crate::shard::Shard;

/// The arguments of a command that works in shards.
pub(in crate::cli) trait InShards {
    /// The parts to join; none where the command does the work itself.
    fn parts(&self) -> &[PathBuf];
}

/// Refuses a seed that the parts were not made with: it would have no effect.
pub(in crate::cli) fn refuse_other_seed(session: &Session, seed: u64) -> Result<()> {
    match session.given_seed().filter(|given| *given != seed) {
        None => Ok(()),
        Some(given) => Err(Error::option(
            "seed",
            format!("{given}, of parts made with {seed}"),
            format!("{seed}, or no --seed"),
        )),
    }
}

/// Says that the part of a shard is there already. `source` is what it was made from: "material", "sample".
pub(in crate::cli) fn outcome_of_kept(output: &Path, shard: Shard, source: &str) -> Outcome {
    Outcome::default()
        .line(format!(
            "{} is there already: shard {shard} of this {source} and these options",
            output.display()
        ))
        .figure("shard", shard.to_string())
        .figure("kept", true)
}
