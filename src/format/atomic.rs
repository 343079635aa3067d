//! Files and folders that appear whole or not at all.
//!
//! A file is written under a hidden temporary name beside its target and renamed when complete,
//! so that a killed run leaves no half file and a reader never sees one.

use std::fs;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

use crate::error::{Error, Result};

/// The buffered temporary file a writer fills.
pub type Sink = BufWriter<NamedTempFile>;

/// Writes `path` through `fill`; on any failure the target stays as it was.
pub fn write_file(path: &Path, fill: impl FnOnce(&mut Sink) -> io::Result<()>) -> Result<()> {
    let write = || -> io::Result<()> {
        let mut sink = BufWriter::with_capacity(1 << 20, temporary_beside(path)?);
        fill(&mut sink)?;
        sink.flush()?;
        let file = sink.into_inner().map_err(io::IntoInnerError::into_error)?;
        file.persist(path)?;
        Ok(())
    };
    write().map_err(Error::io(path, "write"))
}

/// A temporary file in the target's folder, readable as any new file of the user.
fn temporary_beside(path: &Path) -> io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    let prefix = hidden_name(path, "");
    builder.prefix(&prefix).suffix(".partial");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    builder.tempfile_in(parent(path))
}

/// A folder under construction: filled under a hidden name, then renamed to its target.
///
/// Dropped unfinished it removes itself, unless it was opened to be [resumed](Self::resumable).
#[derive(Debug)]
pub struct FolderInProgress {
    target: PathBuf,
    partial: PathBuf,
    keep_partial: bool,
    finished: bool,
}

impl FolderInProgress {
    /// An empty folder that will become `target`.
    pub fn create(target: &Path) -> Result<Self> {
        let folder = Self::at(target, false);
        if folder.partial.exists() {
            fs::remove_dir_all(&folder.partial).map_err(Error::io(&folder.partial, "remove"))?;
        }
        folder.make()
    }

    /// The folder an interrupted run left behind, or an empty one; kept when dropped unfinished.
    pub fn resumable(target: &Path) -> Result<Self> {
        Self::at(target, true).make()
    }

    fn at(target: &Path, keep_partial: bool) -> Self {
        let partial = parent(target).join(hidden_name(target, ".partial"));
        Self {
            target: target.to_path_buf(),
            partial,
            keep_partial,
            finished: false,
        }
    }

    fn make(self) -> Result<Self> {
        fs::create_dir_all(&self.partial).map_err(Error::io(&self.partial, "create"))?;
        Ok(self)
    }

    /// Removes the folder under construction, a resumable one too.
    pub fn discard(mut self) {
        self.keep_partial = false;
    }

    /// Where to write a member of the folder while it is under construction.
    pub fn member(&self, name: &str) -> PathBuf {
        self.partial.join(name)
    }

    /// Renames the folder to its target, replacing an earlier one.
    pub fn finish(mut self) -> Result<()> {
        self.keep_partial = false;
        let replaced = parent(&self.target).join(hidden_name(&self.target, ".replaced"));
        let io_error = |source| Error::io(&self.target, "replace")(source);
        if self.target.exists() {
            if replaced.exists() {
                fs::remove_dir_all(&replaced).map_err(io_error)?;
            }
            fs::rename(&self.target, &replaced).map_err(io_error)?;
        }
        fs::rename(&self.partial, &self.target).map_err(io_error)?;
        if replaced.exists() {
            fs::remove_dir_all(&replaced).map_err(io_error)?;
        }
        self.finished = true;
        Ok(())
    }
}

impl Drop for FolderInProgress {
    fn drop(&mut self) {
        if !self.finished && !self.keep_partial {
            let _ = fs::remove_dir_all(&self.partial);
        }
    }
}

/// The folder a path lies in, `.` for a bare name.
pub fn parent(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

/// `.NAME` + suffix: the hidden companion of a path's last part.
pub fn hidden_name(path: &Path, suffix: &str) -> String {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    format!(".{name}{suffix}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failed_write_leaves_the_old_file_and_no_other() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        write_file(&path, |sink| sink.write_all(b"old")).unwrap();
        let failed = write_file(&path, |sink| {
            sink.write_all(b"new")?;
            Err(io::Error::other("disk full"))
        });
        assert!(failed.unwrap_err().to_string().contains("a.txt"));
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn a_folder_replaces_its_predecessor_only_when_finished() {
        let root = tempfile::tempdir().unwrap();
        let target = root.path().join("x.sample");
        for content in ["one", "two"] {
            let folder = FolderInProgress::create(&target).unwrap();
            fs::write(folder.member("f"), content).unwrap();
            folder.finish().unwrap();
            assert_eq!(fs::read_to_string(target.join("f")).unwrap(), content);
        }
        drop(FolderInProgress::create(&target).unwrap());
        assert_eq!(fs::read_dir(root.path()).unwrap().count(), 1);
        drop(FolderInProgress::resumable(&target).unwrap());
        assert_eq!(fs::read_dir(root.path()).unwrap().count(), 2);
        FolderInProgress::resumable(&target).unwrap().discard();
        assert_eq!(fs::read_dir(root.path()).unwrap().count(), 1);
    }
}
