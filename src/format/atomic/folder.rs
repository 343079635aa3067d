//! A folder under construction: filled under a hidden name, then put in its target's place.
//!
//! Where the system can exchange two names in one step (Linux, macOS) the target is never absent. Where
//! it cannot, the old folder is set aside as `.NAME.replaced` for the moment between two renames;
//! [`repair`] puts it back when a run was killed just there.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use crate::error::{Error, Result};
use crate::format::atomic::standing::Standing;
use crate::format::atomic::{PARTIAL, hidden_name, leftovers, parent};

const REPLACED: &str = ".replaced";

/// Says why a folder must not be replaced; `None` where it may.
pub type Objection = fn(&Path) -> io::Result<Option<String>>;

/// A folder under construction.
///
/// Dropped unfinished it removes itself, unless it was opened to be [resumed](Self::resumable).
#[derive(Debug)]
pub struct FolderInProgress {
    target: PathBuf,
    partial: PathBuf,
    objection: Objection,
    keep_partial: bool,
    finished: bool,
}

impl FolderInProgress {
    /// An empty folder that will become `target`, and replace what stands there only where `objection`
    /// has none.
    pub fn create(target: &Path, objection: Objection) -> Result<Self> {
        let folder = Self::at(target, objection, false)?;
        if folder.partial.exists() {
            fs::remove_dir_all(&folder.partial).map_err(Error::io(&folder.partial, "remove"))?;
        }
        folder.make()
    }

    /// The folder an interrupted run left behind, or an empty one; kept when dropped unfinished.
    pub fn resumable(target: &Path, objection: Objection) -> Result<Self> {
        let folder = Self::at(target, objection, true)?.make()?;
        leftovers::remove(&folder.partial, &[]);
        Ok(folder)
    }

    fn at(target: &Path, objection: Objection, keep_partial: bool) -> Result<Self> {
        repair(target)?;
        let target = folder_target(target, objection)?;
        Ok(Self {
            partial: parent(&target).join(hidden_name(&target, PARTIAL)),
            target,
            objection,
            keep_partial,
            finished: false,
        })
    }

    fn make(self) -> Result<Self> {
        fs::create_dir_all(&self.partial).map_err(Error::io(&self.partial, "create"))?;
        Ok(self)
    }

    /// Removes the folder under construction, a resumable one too.
    pub fn discard(mut self) {
        self.keep_partial = false;
    }

    /// Where the folder lies while it is under construction.
    pub fn path(&self) -> &Path {
        &self.partial
    }

    /// Where to write a member of the folder while it is under construction.
    pub fn member(&self, name: &str) -> PathBuf {
        self.partial.join(name)
    }

    /// Puts the folder in its target's place; an earlier one is removed.
    pub fn finish(mut self) -> Result<()> {
        self.keep_partial = false;
        let io_error = |source| Error::io(&self.target, "replace")(source);
        if folder_target(&self.target, self.objection)?.exists() {
            let old = swap(&self.partial, &self.target).map_err(io_error)?;
            self.finished = true;
            fs::remove_dir_all(&old).map_err(Error::io(&old, "remove"))?;
        } else {
            fs::rename(&self.partial, &self.target).map_err(io_error)?;
            self.finished = true;
        }
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

/// The folder that `path` stands for, links followed; what stands there must be replaceable.
fn folder_target(path: &Path, objection: Objection) -> Result<PathBuf> {
    let fault = |found: String| {
        Error::data("output", found)
            .expected("a free name, an empty folder, or one that this program made")
            .in_file(path)
    };
    match Standing::of(path).map_err(Error::io(path, "write"))? {
        Standing::Nothing(target) => Ok(target),
        Standing::Folder(target) => {
            match objection(&target).map_err(Error::io(&target, "read"))? {
                None => Ok(target),
                Some(found) => Err(fault(found)),
            }
        }
        other => Err(fault(other.describe().into())),
    }
}

/// Puts `new` in the place of `old`; returns where the old one went.
fn swap(new: &Path, old: &Path) -> io::Result<PathBuf> {
    if exchange(new, old)? {
        return Ok(new.to_path_buf());
    }
    swap_in_two_steps(new, old)
}

fn swap_in_two_steps(new: &Path, old: &Path) -> io::Result<PathBuf> {
    let aside = set_aside(old);
    if aside.exists() {
        fs::remove_dir_all(&aside)?;
    }
    fs::rename(old, &aside)?;
    fs::rename(new, old)?;
    Ok(aside)
}

fn set_aside(target: &Path) -> PathBuf {
    parent(target).join(hidden_name(target, REPLACED))
}

/// Whether a run that was killed while it replaced `target` left the earlier folder aside.
pub fn is_set_aside(target: &Path) -> bool {
    set_aside(target).is_dir()
}

/// Exchanges two names in one step; false where the system or the file system cannot.
#[cfg(any(target_os = "linux", target_os = "macos"))]
fn exchange(a: &Path, b: &Path) -> io::Result<bool> {
    use rustix::fs::{CWD, RenameFlags, renameat_with};
    use rustix::io::Errno;
    match renameat_with(CWD, a, CWD, b, RenameFlags::EXCHANGE) {
        Ok(()) => Ok(true),
        Err(Errno::INVAL | Errno::NOSYS | Errno::OPNOTSUPP) => Ok(false),
        Err(error) => Err(error.into()),
    }
}

#[cfg(not(any(target_os = "linux", target_os = "macos")))]
fn exchange(_a: &Path, _b: &Path) -> io::Result<bool> {
    Ok(false)
}

/// Repairs what a run left that was killed between the two renames of a replacement: the old folder goes
/// back to its name. Returns whether it did. To be called by whoever holds the target's lock.
pub fn repair(target: &Path) -> Result<bool> {
    let aside = set_aside(target);
    if !aside.is_dir() {
        return Ok(false);
    }
    if target.exists() {
        // Killed after the second rename: the new folder is in place.
        fs::remove_dir_all(&aside).map_err(Error::io(&aside, "remove"))?;
        return Ok(false);
    }
    fs::rename(&aside, target).map_err(Error::io(target, "put back"))?;
    Ok(true)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn none(_: &Path) -> io::Result<Option<String>> {
        Ok(None)
    }

    fn content(target: &Path) -> String {
        fs::read_to_string(target.join("f")).unwrap()
    }

    fn fill(target: &Path, text: &str) {
        let folder = FolderInProgress::create(target, none).unwrap();
        fs::write(folder.member("f"), text).unwrap();
        folder.finish().unwrap();
    }

    #[test]
    fn a_folder_replaces_its_predecessor_only_when_finished() {
        let root = tempfile::tempdir().unwrap();
        let target = root.path().join("x.sample");
        for text in ["one", "two"] {
            fill(&target, text);
            assert_eq!(content(&target), text);
        }
        drop(FolderInProgress::create(&target, none).unwrap());
        assert_eq!(fs::read_dir(root.path()).unwrap().count(), 1);
        drop(FolderInProgress::resumable(&target, none).unwrap());
        assert_eq!(fs::read_dir(root.path()).unwrap().count(), 2);
        FolderInProgress::resumable(&target, none)
            .unwrap()
            .discard();
        assert_eq!(fs::read_dir(root.path()).unwrap().count(), 1);
    }

    #[test]
    fn an_objection_is_asked_before_and_after_the_work() {
        fn to_foreign_files(folder: &Path) -> io::Result<Option<String>> {
            let foreign = folder.join("letter").exists();
            Ok(foreign.then(|| "it holds a letter".into()))
        }
        let root = tempfile::tempdir().unwrap();
        let target = root.path().join("x.sample");
        fs::create_dir(&target).unwrap();
        let folder = FolderInProgress::create(&target, to_foreign_files).unwrap();
        fs::write(target.join("letter"), "dear").unwrap();
        assert!(folder.finish().unwrap_err().to_string().contains("letter"));
        assert!(FolderInProgress::create(&target, to_foreign_files).is_err());
        assert_eq!(fs::read(target.join("letter")).unwrap(), b"dear");
        assert_eq!(fs::read_dir(root.path()).unwrap().count(), 1);
    }

    #[cfg(unix)]
    #[test]
    fn a_link_to_a_folder_is_followed() {
        let root = tempfile::tempdir().unwrap();
        let (link, real) = (root.path().join("link"), root.path().join("real"));
        fs::create_dir(&real).unwrap();
        std::os::unix::fs::symlink("real", &link).unwrap();
        fill(&link, "new");
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(content(&real), "new");
    }

    #[test]
    fn files_in_the_way_are_refused() {
        let root = tempfile::tempdir().unwrap();
        let target = root.path().join("x.sample");
        fs::write(&target, "a letter").unwrap();
        let refused = FolderInProgress::create(&target, none).unwrap_err();
        assert!(refused.to_string().contains("a file"), "{refused}");
        assert_eq!(fs::read(&target).unwrap(), b"a letter");
    }

    #[test]
    fn a_replacement_killed_between_its_renames_is_mended() {
        let root = tempfile::tempdir().unwrap();
        let target = root.path().join("x.sample");
        fill(&target, "old");
        fs::rename(&target, set_aside(&target)).unwrap();
        assert!(repair(&target).unwrap());
        assert_eq!(content(&target), "old");
        // Both there: the new one is in place.
        fill(&set_aside(&target), "older");
        assert!(!repair(&target).unwrap());
        assert_eq!(content(&target), "old");
        assert_eq!(fs::read_dir(root.path()).unwrap().count(), 1);
    }

    #[test]
    fn without_an_exchange_two_renames_do() {
        let root = tempfile::tempdir().unwrap();
        let (new, old) = (root.path().join("new"), root.path().join("old"));
        for folder in [&new, &old] {
            fs::create_dir(folder).unwrap();
            fs::write(
                folder.join("f"),
                folder.file_name().unwrap().as_encoded_bytes(),
            )
            .unwrap();
        }
        let aside = swap_in_two_steps(&new, &old).unwrap();
        assert_eq!(content(&old), "new");
        assert_eq!(content(&aside), "old");
    }
}
