//! What killed runs left behind: `.NAME.RANDOM.partial` beside the outputs.
//!
//! A run removes them from every folder it writes to. A file that a live process still fills is
//! locked by it, and stays.

use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};

use crate::format::atomic::PARTIAL;
use crate::format::lock;

/// Letters and digits that the name of a temporary file ends with.
const RANDOM_LETTERS: usize = 6;
/// Endings of the files this program writes: with another ending, a file counts as a leftover only of
/// the very output it is named after.
const OUR_ENDINGS: [&str; 11] = [
    "btf", "exr", "gif", "glb", "json", "npy", "npz", "obj", "ply", "png", "resume",
];

/// Removes the temporary files in `folder` that no live process holds; `targets` are the names of what
/// this run writes there. What cannot be removed stays: it is in nobody's way.
pub fn remove(folder: &Path, targets: &[&OsStr]) {
    for path in candidates(folder, targets) {
        if let Some(held) = lock::try_hold(&path)
            && lock::still_there(&held, &path)
        {
            let _ = fs::remove_file(&path);
        }
    }
}

fn candidates(folder: &Path, targets: &[&OsStr]) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let is_ours = |name: &OsStr| {
        let name = name.to_str().and_then(target_of);
        name.is_some_and(|name| {
            let ending = Path::new(name).extension().and_then(OsStr::to_str);
            ending.is_some_and(|ending| OUR_ENDINGS.contains(&ending))
                || targets.iter().any(|target| target.to_str() == Some(name))
        })
    };
    entries
        .filter(|entry| is_ours(&entry.file_name()))
        .filter(|entry| entry.file_type().is_ok_and(|kind| kind.is_file()))
        .map(|entry| entry.path())
        .collect()
}

/// NAME of `.NAME.RANDOM.partial`.
fn target_of(name: &str) -> Option<&str> {
    let (name, random) = name
        .strip_prefix('.')?
        .strip_suffix(PARTIAL)?
        .rsplit_once('.')?;
    let is_random =
        random.len() == RANDOM_LETTERS && random.bytes().all(|byte| byte.is_ascii_alphanumeric());
    is_random.then_some(name)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs::File;

    #[test]
    fn leftovers_go_and_what_is_held_or_not_ours_stays() {
        let folder = tempfile::tempdir().unwrap();
        let names = [
            ".a.npz.Ab12Cd.partial",
            ".new.Ab12Cd.partial",
            ".film.Ab12Cd.partial",
            ".b.npz.Ab12Cd.partial",
            ".a.npz.toolong9.partial",
            ".a.npz.lock",
            "c.npz.Ab12Cd.partial",
        ];
        for name in names {
            fs::write(folder.path().join(name), "x").unwrap();
        }
        let held = File::open(folder.path().join(names[3])).unwrap();
        held.lock().unwrap();
        remove(folder.path(), &[OsStr::new("new")]);
        let left: Vec<bool> = names
            .iter()
            .map(|name| folder.path().join(name).exists())
            .collect();
        assert_eq!(left, [false, false, true, true, true, true, true]);
        drop(held);
        remove(folder.path(), &[]);
        assert!(!folder.path().join(names[3]).exists());
    }
}
