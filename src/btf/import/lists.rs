//! Files that list images, by the ends of their names.

use std::path::{Path, PathBuf};

use crate::error::{Error, Result};

/// The end of a file's name, in lower case.
pub(super) fn extension(path: &Path) -> String {
    path.extension()
        .unwrap_or_default()
        .to_string_lossy()
        .to_lowercase()
}

/// Whether a file is called as lists are.
pub(super) fn is_list(path: &Path) -> bool {
    matches!(extension(path).as_str(), "lp" | "csv" | "tsv")
}

/// The lists that lie in a folder, sorted.
pub fn lists_in(folder: &Path) -> Result<Vec<PathBuf>> {
    let entries = std::fs::read_dir(folder).map_err(Error::io(folder, "read"))?;
    let mut lists: Vec<PathBuf> = entries
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|path| is_list(path))
        .collect();
    lists.sort();
    Ok(lists)
}

/// The list of a folder; `None` where it has none.
pub(super) fn only_list_in(folder: &Path) -> Result<Option<PathBuf>> {
    let mut lists = lists_in(folder)?;
    match lists.len() {
        0 | 1 => Ok(lists.pop()),
        count => Err(Error::data("source", format!("{count} .lp and .csv files"))
            .expected("just one")
            .advice("name the file itself: mesotex import FOLDER/FILE.csv")
            .in_file(folder)),
    }
}
