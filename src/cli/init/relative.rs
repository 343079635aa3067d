//! Paths as a scene writes them: relative to its folder.

use std::fs;
use std::path::{Component, Path, PathBuf};

use crate::error::{Error, Result};

/// A path that leads to `path` from `folder`; an absolute one stays as it is.
pub(super) fn relative_to(path: &Path, folder: &Path) -> Result<PathBuf> {
    if path.is_absolute() || folder.as_os_str().is_empty() {
        return Ok(path.to_path_buf());
    }
    let real = |path: &Path| fs::canonicalize(path).map_err(Error::io(path, "find"));
    Ok(way(&real(folder)?, &real(path)?))
}

/// The way from one absolute path to another.
fn way(from: &Path, to: &Path) -> PathBuf {
    let (from, to): (Vec<Component<'_>>, Vec<Component<'_>>) =
        (from.components().collect(), to.components().collect());
    let shared = from.iter().zip(&to).take_while(|(a, b)| a == b).count();
    let up = std::iter::repeat_n(Component::ParentDir, from.len() - shared);
    up.chain(to[shared..].iter().copied()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_way_leads_up_and_down() {
        let way = |from: &str, to: &str| way(Path::new(from), Path::new(to));
        assert_eq!(way("/a/scenes", "/a/maps/bark"), Path::new("../maps/bark"));
        assert_eq!(way("/a", "/a/maps/bark"), Path::new("maps/bark"));
    }
}
