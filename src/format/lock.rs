//! One writer for each output: a second run on the same target is refused instead of mixed in.
//!
//! A lock is a hidden file beside the target that its holder has locked; the lock goes with the
//! process. A link, a pipe or anything else under that name is refused, never followed or waited for.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io;
use std::path::{Path, PathBuf};

use crate::error::{Error, Result};
use crate::format::atomic::names::{hidden_name, parent};

/// The right to write one target; given back when dropped or when the process dies.
#[derive(Debug)]
pub struct OutputLock {
    path: PathBuf,
    file: File,
}

impl OutputLock {
    /// Claims `target`, by a locked hidden file beside it.
    pub fn acquire(target: &Path) -> Result<Self> {
        let path = parent(target).join(hidden_name(target, ".lock"));
        loop {
            let file = open_plain(&path, true).map_err(|error| match error.kind() {
                io::ErrorKind::InvalidInput => {
                    Error::data("lock", format!("{} is not a regular file", path.display()))
                        .advice("remove it; this program makes it again")
                        .in_file(target)
                }
                _ => Error::io(target, "write")(error),
            })?;
            match file.try_lock() {
                Ok(()) if still_there(&file, &path) => return Ok(Self { path, file }),
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

/// The plain file at `path`, locked; `None` where another process holds it or it is no plain file.
pub(super) fn try_hold(path: &Path) -> Option<File> {
    let file = open_plain(path, false).ok()?;
    file.try_lock().ok()?;
    Some(file)
}

/// Opens a plain file without following a link, waiting for a pipe's other end, or cutting its content;
/// anything else is [`io::ErrorKind::InvalidInput`].
fn open_plain(path: &Path, create: bool) -> io::Result<File> {
    let no_file = || io::Error::from(io::ErrorKind::InvalidInput);
    let mut options = OpenOptions::new();
    options.write(true).create(create).truncate(false);
    #[cfg(unix)]
    {
        use std::os::unix::fs::OpenOptionsExt;
        let flags = rustix::fs::OFlags::NOFOLLOW | rustix::fs::OFlags::NONBLOCK;
        options.custom_flags(flags.bits() as i32);
    }
    let stands = fs::symlink_metadata(path);
    if stands.is_ok_and(|metadata| !metadata.is_file()) {
        return Err(no_file());
    }
    let file = options.open(path)?;
    // What stood there may have changed meanwhile.
    match file.metadata()?.is_file() {
        true => Ok(file),
        false => Err(no_file()),
    }
}

/// Whether the opened file is still the one under its name (another run may have removed it).
#[cfg(unix)]
pub(super) fn still_there(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    match (file.metadata(), fs::symlink_metadata(path)) {
        (Ok(held), Ok(named)) => held.ino() == named.ino() && held.dev() == named.dev(),
        _ => false,
    }
}

#[cfg(not(unix))]
pub(super) fn still_there(_file: &File, _path: &Path) -> bool {
    true
}

impl Drop for OutputLock {
    fn drop(&mut self) {
        // Locks of ours are empty; a file with content was there before and is not ours to remove.
        if self
            .file
            .metadata()
            .is_ok_and(|metadata| metadata.len() == 0)
        {
            let _ = fs::remove_file(&self.path);
        }
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

    #[cfg(unix)]
    #[test]
    fn links_and_pipes_are_neither_followed_nor_waited_for() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("out.npz");
        let lock = folder.path().join(".out.npz.lock");
        let letter = folder.path().join("letter");
        fs::write(&letter, "dear").unwrap();
        std::os::unix::fs::symlink(&letter, &lock).unwrap();
        let refused = OutputLock::acquire(&target).unwrap_err().to_string();
        assert!(refused.contains("not a regular file"), "{refused}");
        assert_eq!(fs::read(&letter).unwrap(), b"dear");
        fs::remove_file(&lock).unwrap();
        let made = std::process::Command::new("mkfifo").arg(&lock).status();
        assert!(made.unwrap().success());
        let refused = OutputLock::acquire(&target).unwrap_err().to_string();
        assert!(refused.contains("not a regular file"), "{refused}");
        fs::remove_file(&lock).unwrap();
        // A file of the user under that name keeps its content while the lock is held.
        fs::write(&lock, "mine").unwrap();
        let held = OutputLock::acquire(&target).unwrap();
        assert_eq!(fs::read(&lock).unwrap(), b"mine");
        drop(held);
        assert_eq!(fs::read(&lock).unwrap(), b"mine");
    }
}
