//! The directory of a zip archive, checked before anything is read by it.

use std::fs::File;
use std::io::BufReader;

use zip::ZipArchive;

use crate::error::{Error, Result};

/// Reads and checks an archive's directory: no name stands in it twice, no two members share bytes. `kind`
/// is what the file should be, with its article.
pub(in crate::format) fn open(file: File, kind: &str) -> Result<ZipArchive<BufReader<File>>> {
    let fault = |found: String| {
        Error::data("zip directory", found)
            .expected(kind)
            .advice("the file is truncated, damaged, or something else")
    };
    let mut archive =
        ZipArchive::new(BufReader::new(file)).map_err(|error| fault(error.to_string()))?;
    if archive.has_duplicate_names() {
        return Err(fault("a member is listed twice".into()));
    }
    match archive.has_overlapping_entries() {
        Ok(false) => Ok(archive),
        Ok(true) => Err(fault("members that share bytes".into())),
        Err(error) => Err(fault(error.to_string())),
    }
}
