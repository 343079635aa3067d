//! What stands at a path before it is written.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// What a path names, links followed to their end.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Standing {
    /// Nothing: the name is free.
    Nothing(PathBuf),
    /// A plain file, by its own path.
    File(PathBuf),
    /// A folder, by its own path.
    Folder(PathBuf),
    /// A link whose end does not exist.
    LooseLink,
    /// A device, a pipe or a socket.
    Special,
}

impl Standing {
    /// Looks what stands at `path`.
    pub fn of(path: &Path) -> io::Result<Self> {
        let named = match fs::symlink_metadata(path) {
            Ok(metadata) => metadata,
            Err(error) if error.kind() == io::ErrorKind::NotFound => {
                return Ok(Self::Nothing(path.to_path_buf()));
            }
            Err(error) => return Err(error),
        };
        let end = match fs::metadata(path) {
            Ok(metadata) => metadata,
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Self::LooseLink),
            Err(error) => return Err(error),
        };
        if !(end.is_file() || end.is_dir()) {
            return Ok(Self::Special);
        }
        let own = match named.is_symlink() {
            true => fs::canonicalize(path)?,
            false => path.to_path_buf(),
        };
        Ok(match end.is_file() {
            true => Self::File(own),
            false => Self::Folder(own),
        })
    }

    /// The kind in words, as a message names it.
    pub fn describe(&self) -> &'static str {
        match self {
            Self::Nothing(_) => "nothing",
            Self::File(_) => "a file",
            Self::Folder(_) => "a folder",
            Self::LooseLink => "a link to nothing",
            Self::Special => "a device, a pipe or a socket",
        }
    }
}
