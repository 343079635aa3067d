//! The content of files, without reading those again that the system says have not changed.
//!
//! Trusted: a file whose size, times of change and inode are those it had when it was read, if its last
//! change was older by then than the file system's clock can blur. Everything else is read and hashed.

use std::collections::BTreeMap;
use std::fs::{self, Metadata};
use std::path::{Path, PathBuf};
use std::thread;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};
use crate::format::id::ContentId;

/// Changes closer together than this may show the same time, in nanoseconds.
const BLUR: i64 = 50_000_000;
/// The same on file systems that keep whole seconds.
const COARSE_BLUR: i64 = 2_100_000_000;

/// What is known of files.
#[derive(Debug, Default, Serialize, Deserialize)]
pub struct KnownFiles {
    #[serde(flatten)]
    files: BTreeMap<PathBuf, Known>,
    #[serde(skip)]
    has_news: bool,
}

/// A file as it was when it was read.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
struct Known {
    stamp: Stamp,
    /// When the stamp was taken, before the content was read.
    looked: i64,
    id: ContentId,
}

/// What the system says of a file; times in nanoseconds since 1970.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
struct Stamp {
    size: u64,
    modified: i64,
    changed: i64,
    inode: u64,
}

impl Stamp {
    fn of(metadata: &Metadata) -> Self {
        let modified = metadata.modified().map_or(0, nanoseconds);
        let (changed, inode) = status(metadata, modified);
        Self {
            size: metadata.len(),
            modified,
            changed,
            inode,
        }
    }

    /// When the file changed last, as far as the system says.
    fn latest(&self) -> i64 {
        self.modified.max(self.changed)
    }

    /// Whether a change after `looked` would show.
    fn is_settled(&self, looked: i64) -> bool {
        let is_coarse = self.latest() % 1_000_000_000 == 0;
        let blur = if is_coarse { COARSE_BLUR } else { BLUR };
        looked.saturating_sub(self.latest()) > blur
    }
}

#[cfg(unix)]
fn status(metadata: &Metadata, _modified: i64) -> (i64, u64) {
    use std::os::unix::fs::MetadataExt;
    let seconds = metadata.ctime().saturating_mul(1_000_000_000);
    (
        seconds.saturating_add(metadata.ctime_nsec()),
        metadata.ino(),
    )
}

#[cfg(not(unix))]
fn status(_metadata: &Metadata, modified: i64) -> (i64, u64) {
    (modified, 0)
}

fn nanoseconds(time: SystemTime) -> i64 {
    let since = time.duration_since(UNIX_EPOCH).unwrap_or_default();
    i64::try_from(since.as_nanos()).unwrap_or(i64::MAX)
}

impl KnownFiles {
    /// The id of a file's content, or of the list of a folder's visible files.
    pub fn content_of(&mut self, path: &Path) -> Result<ContentId> {
        let looked = nanoseconds(SystemTime::now());
        let metadata = fs::metadata(path).map_err(Error::io(path, "read"))?;
        if metadata.is_dir() {
            return list_of(path);
        }
        let stamp = Stamp::of(&metadata);
        let known = self.files.get(path);
        if let Some(known) =
            known.filter(|known| known.stamp == stamp && stamp.is_settled(known.looked))
        {
            return Ok(known.id.clone());
        }
        let id = ContentId::of_file(path)?;
        let known = Known {
            stamp,
            looked,
            id: id.clone(),
        };
        self.files.insert(path.to_path_buf(), known);
        self.has_news = true;
        Ok(id)
    }

    /// Waits until a change of files that were just written would show, so that they need not be read
    /// again by the next run.
    pub fn let_settle(&self, paths: &[PathBuf]) {
        let now = nanoseconds(SystemTime::now());
        let stamps = paths
            .iter()
            .filter_map(|path| Some(Stamp::of(&fs::metadata(path).ok()?)));
        let latest = stamps.map(|stamp| stamp.latest()).max().unwrap_or(0);
        let wait = latest.saturating_add(BLUR + 1_000_000).saturating_sub(now);
        if (1..=2 * BLUR).contains(&wait) {
            thread::sleep(Duration::from_nanos(wait.unsigned_abs()));
        }
    }

    /// Whether something was read since the record was written.
    pub fn has_news(&self) -> bool {
        self.has_news
    }

    /// Forgets every file that is not `named`; the rest is about to be written down.
    pub fn forget_but(&mut self, named: impl Fn(&Path) -> bool) {
        self.files.retain(|path, _| named(path));
        self.has_news = false;
    }
}

/// The id of the names of a folder's visible files.
fn list_of(folder: &Path) -> Result<ContentId> {
    let mut names = Vec::new();
    for entry in fs::read_dir(folder).map_err(Error::io(folder, "read"))? {
        let entry = entry.map_err(Error::io(folder, "read"))?;
        let name = entry.file_name();
        if entry.path().is_file() && !name.to_string_lossy().starts_with('.') {
            names.push(name.into_encoded_bytes());
        }
    }
    names.sort();
    Ok(ContentId::of_bytes(&names.join(&b'/')))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs::File;

    fn at(folder: &tempfile::TempDir) -> PathBuf {
        folder.path().join("file")
    }

    #[test]
    fn a_settled_file_is_not_read_again() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(at(&folder), "one").unwrap();
        let mut known = KnownFiles::default();
        known.let_settle(&[at(&folder)]);
        let id = known.content_of(&at(&folder)).unwrap();
        known.forget_but(|_| true);
        assert_eq!(known.content_of(&at(&folder)).unwrap(), id);
        assert!(!known.has_news());
    }

    #[test]
    fn a_change_of_equal_size_is_seen_however_its_time_is_set() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(at(&folder), "one").unwrap();
        let mut known = KnownFiles::default();
        known.let_settle(&[at(&folder)]);
        let id = known.content_of(&at(&folder)).unwrap();
        let time = fs::metadata(at(&folder)).unwrap().modified().unwrap();
        fs::write(at(&folder), "two").unwrap();
        File::options()
            .write(true)
            .open(at(&folder))
            .unwrap()
            .set_modified(time)
            .unwrap();
        assert_ne!(known.content_of(&at(&folder)).unwrap(), id);
    }

    #[test]
    fn a_file_read_within_the_blur_of_its_change_is_read_again() {
        let stamp = |latest| Stamp {
            size: 1,
            modified: latest,
            changed: latest,
            inode: 1,
        };
        let fine = 5_000_000_001;
        assert!(!stamp(fine).is_settled(fine + BLUR));
        assert!(stamp(fine).is_settled(fine + BLUR + 1));
        let coarse = 5_000_000_000;
        assert!(!stamp(coarse).is_settled(coarse + BLUR + 1));
        assert!(stamp(coarse).is_settled(coarse + COARSE_BLUR + 1));
        assert!(
            !stamp(fine).is_settled(fine - 1),
            "a clock that was set back proves nothing"
        );
    }

    #[test]
    fn a_folder_is_told_by_the_names_in_it() {
        let folder = tempfile::tempdir().unwrap();
        let before = list_of(folder.path()).unwrap();
        fs::write(folder.path().join(".hidden"), "").unwrap();
        fs::create_dir(folder.path().join("inner")).unwrap();
        assert_eq!(list_of(folder.path()).unwrap(), before);
        fs::write(folder.path().join("bark_rough.png"), "").unwrap();
        assert_ne!(list_of(folder.path()).unwrap(), before);
    }
}
