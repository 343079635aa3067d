//! Images by their names, whatever the case and whatever folders a list puts before them.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use crate::btf::import::listed::Listed;
use crate::error::{Error, Result};

/// The most files looked at in one folder.
pub(super) const MOST: usize = 200_000;

/// The last part of a path of any system.
pub(super) fn base_name(named: &str) -> &str {
    named.rsplit(['/', '\\']).next().unwrap_or(named)
}

pub(super) fn entries(folder: &Path) -> Result<Vec<PathBuf>> {
    let mut paths = Vec::new();
    for entry in fs::read_dir(folder)
        .map_err(Error::io(folder, "read"))?
        .take(MOST)
    {
        paths.push(entry.map_err(Error::io(folder, "read"))?.path());
    }
    Ok(paths)
}

/// Files by their names, and by their names in lower case where only one has it.
#[derive(Default)]
pub(super) struct Names {
    exact: BTreeMap<String, PathBuf>,
    in_lower_case: BTreeMap<String, Option<PathBuf>>,
}

impl Names {
    pub(super) fn of(folder: &Path) -> Result<Self> {
        Ok(Self::of_files(
            entries(folder)?.into_iter().filter(|path| path.is_file()),
        ))
    }

    pub(super) fn of_files(files: impl IntoIterator<Item = PathBuf>) -> Self {
        let mut names = Self::default();
        for path in files {
            let Some(name) = path
                .file_name()
                .and_then(|name| name.to_str())
                .map(str::to_owned)
            else {
                continue;
            };
            let lower = names.in_lower_case.entry(name.to_lowercase());
            lower
                .and_modify(|other| *other = None)
                .or_insert_with(|| Some(path.clone()));
            names.exact.insert(name, path);
        }
        names
    }

    pub(super) fn get(&self, named: &str) -> Option<&PathBuf> {
        let name = base_name(named);
        let lower = || self.in_lower_case.get(&name.to_lowercase())?.as_ref();
        self.exact.get(name).or_else(lower)
    }
}

pub(super) fn by_name(listed: &[Listed], names: &Names) -> Option<Vec<PathBuf>> {
    let path = |image: &Listed| names.get(&image.file).cloned();
    listed.iter().map(path).collect()
}
