//! Files and folders that appear complete or not at all.
//!
//! A file is written under a hidden temporary name beside its target, `.NAME.RANDOM.partial`, and renamed when
//! complete: a killed run leaves no partial file and a reader never sees one. A folder is filled as `.NAME.partial`
//! and changes places with what stands there ([`folder`]). What a killed run left behind is removed by the next one
//! ([`leftovers`]).
//!
//! A link named as a target is followed; what stands at its end is replaced, the link stays. A device,
//! a pipe or a socket is never replaced.

pub(crate) mod folder;
pub(crate) mod leftovers;
pub(crate) mod names;
pub(crate) mod standing;

use std::fs;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

pub use crate::format::atomic::names::{hidden_name, parent};

use crate::error::{Error, Result};
use crate::format::atomic::standing::Standing;
use crate::format::lock;

/// The buffered temporary file a writer fills.
pub type Sink = BufWriter<NamedTempFile>;

/// What ends the name of everything that is not finished yet.
const PARTIAL: &str = ".partial";

/// Writes `path` through `fill`; on any failure the target stays as it was.
pub fn write_file(path: &Path, fill: impl FnOnce(&mut Sink) -> io::Result<()>) -> Result<()> {
    let target = file_target(path)?;
    let write = || -> io::Result<()> {
        let mut sink = BufWriter::with_capacity(1 << 20, temporary_beside(&target)?);
        fill(&mut sink)?;
        sink.flush()?;
        let file = sink.into_inner().map_err(io::IntoInnerError::into_error)?;
        file.persist(&target)?;
        Ok(())
    };
    write().map_err(Error::io(path, "write"))
}

/// The plain file that `path` stands for, links followed.
fn file_target(path: &Path) -> Result<PathBuf> {
    match Standing::of(path).map_err(Error::io(path, "write"))? {
        Standing::Nothing(target) | Standing::File(target) => Ok(target),
        other => Err(Error::data("output", other.describe())
            .expected("a plain file, or a name that is free")
            .in_file(path)),
    }
}

/// A temporary file in the target's folder, readable as any new file of the user.
///
/// It is locked while this process fills it, so that no other run takes it for a leftover.
fn temporary_beside(path: &Path) -> io::Result<NamedTempFile> {
    let prefix = hidden_name(path, ".");
    let mut builder = tempfile::Builder::new();
    builder.prefix(&prefix).suffix(PARTIAL);
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    loop {
        let file = builder.tempfile_in(parent(path))?;
        // Where the file system knows no locks, nothing is taken for a leftover either.
        let _ = file.as_file().lock();
        if lock::still_there(file.as_file(), file.path()) {
            return Ok(file);
        }
    }
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

    #[cfg(unix)]
    #[test]
    fn a_link_is_followed_and_stays() {
        let folder = tempfile::tempdir().unwrap();
        let (link, file) = (folder.path().join("link"), folder.path().join("file"));
        fs::write(&file, "old").unwrap();
        std::os::unix::fs::symlink(&file, &link).unwrap();
        write_file(&link, |sink| sink.write_all(b"new")).unwrap();
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::read(&file).unwrap(), b"new");
    }

    #[cfg(unix)]
    #[test]
    fn devices_and_links_to_nothing_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let link = folder.path().join("link");
        std::os::unix::fs::symlink("nowhere", &link).unwrap();
        for (path, says) in [(Path::new("/dev/null"), "device"), (&link, "nothing")] {
            let refused = write_file(path, |sink| sink.write_all(b"x")).unwrap_err();
            assert!(refused.to_string().contains(says), "{refused}");
            assert!(!fs::symlink_metadata(path).unwrap().is_file());
        }
    }
}
