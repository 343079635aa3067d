//! A mesh: its size, shape, and what cleaning would change.

use std::path::Path;

use crate::cli::mesh::{read_outcome, with_shape};
use crate::cli::outcome::Outcome;
use crate::error::Result;
use crate::mesh::reading::read;
use crate::progress::Progress;

/// Reads and cleans a mesh and describes its content.
pub fn describe(path: &Path, progress: Progress<'_>) -> Result<Outcome> {
    let user = read(path, progress)?;
    let outcome = with_shape(read_outcome(path, &user), &user);
    Ok(outcome.figure("kind", "mesh"))
}
