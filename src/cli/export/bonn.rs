//! `mesotex export` of Bonn's `.btf` files.

use std::path::Path;

use serde_json::json;

use crate::btf::bonn::signature::Format;
use crate::btf::bonn::{BonnExportOptions, export};
use crate::cli::outcome::Outcome;
use crate::cli::session::Session;
use crate::error::Result;

/// Writes a sample as a `.btf` file.
pub(super) fn run(
    sample: &Path,
    format: Format,
    options: &BonnExportOptions,
    out: &Path,
    session: &Session,
) -> Result<Outcome> {
    let (seed, progress) = (session.seed(), session.progress());
    let exported = export(sample, format, options, out, seed, progress)?;
    let mut outcome = Outcome::default()
        .figure("format", format.name())
        .figure("rank", json!(exported.rank))
        .figure("error", json!(exported.error));
    if let Some(rank) = exported.rank {
        outcome = outcome.line(format!("{}: {rank} components", format.name()));
    }
    if let Some(error) = exported.error {
        outcome = outcome.line(format!(
            "the file read again differs from the sample by a relative error of {error:.2e}"
        ));
    }
    Ok(outcome.wrote(out))
}
