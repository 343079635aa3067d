//! Which directions are left out together.

use clap::ValueEnum;
use rand::seq::SliceRandom;
use serde::Serialize;

use crate::random;

/// Directions that are left out at most.
pub const MOST_HELD: usize = 256;

/// Which directions are left out at a time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum LeaveOut {
    /// Each alone, in turn.
    #[default]
    Each,
    /// A tenth of them, drawn at random, all at once.
    Tenth,
}

/// Groups of what is left out together: of each alone, or of a tenth at once. Beyond [`MOST_HELD`], that many drawn.
pub(super) fn groups(
    distinct: &[u32],
    leave_out: LeaveOut,
    purpose: &str,
    seed: u64,
) -> Vec<Vec<u32>> {
    let count = match leave_out {
        LeaveOut::Each => distinct.len(),
        LeaveOut::Tenth => distinct.len().div_ceil(10),
    };
    let mut stream = random::stream(seed, &format!("held out {purpose}"), 0, 0);
    let mut drawn: Vec<u32> = distinct
        .choose_multiple(&mut stream, count.min(MOST_HELD))
        .copied()
        .collect();
    drawn.sort_unstable();
    match leave_out {
        LeaveOut::Each => drawn.into_iter().map(|one| vec![one]).collect(),
        LeaveOut::Tenth => vec![drawn],
    }
}
