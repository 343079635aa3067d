//! One writer an output: a second run on the same target is refused instead of mixed in.

use std::fs::{self, File, TryLockError};
use std::path::{Path, PathBuf};

use crate::error::{Error, Result};
use crate::format::atomic::{hidden_name, parent};

/// The right to write one target; given back when dropped or when the process dies.
#[derive(Debug)]
pub struct OutputLock {
    path: PathBuf,
    _file: File,
}

impl OutputLock {
    /// Claims `target`, by a locked hidden file beside it.
    pub fn acquire(target: &Path) -> Result<Self> {
        let path = parent(target).join(hidden_name(target, ".lock"));
        loop {
            let file = File::create(&path).map_err(Error::io(target, "write"))?;
            match file.try_lock() {
                Ok(()) if still_there(&file, &path) => return Ok(Self { path, _file: file }),
                Ok(()) => {}
                Err(TryLockError::WouldBlock) => {
                    return Err(Error::data("output", "another run is writing it")
                        .advice("wait for the other run to end, or choose another output")
                        .in_file(target));
                }
                Err(TryLockError::Error(source)) => {
                    return Err(Error::io(target, "lock")(source));
                }
            }
        }
    }
}

/// Whether the locked file is still the one under its name (another run may have removed it).
#[cfg(unix)]
fn still_there(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    match (file.metadata(), fs::metadata(path)) {
        (Ok(held), Ok(named)) => held.ino() == named.ino() && held.dev() == named.dev(),
        _ => false,
    }
}

#[cfg(not(unix))]
fn still_there(_file: &File, _path: &Path) -> bool {
    true
}

impl Drop for OutputLock {
    fn drop(&mut self) {
        let _ = fs::remove_file(&self.path);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_second_writer_is_refused_until_the_first_is_done() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("out.npz");
        let first = OutputLock::acquire(&target).unwrap();
        let refused = OutputLock::acquire(&target).unwrap_err().to_string();
        assert!(refused.contains("another run"), "{refused}");
        drop(first);
        OutputLock::acquire(&target).unwrap();
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}
