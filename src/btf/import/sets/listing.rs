//! The images of folders, of the folders in them, and of zip archives.

use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};

use crate::btf::import::lists::is_list;
use crate::btf::import::place::Place;
use crate::error::{Error, Result};
use crate::format::archive::Archive;

/// Ends of the names of images.
const IMAGES: [&str; 11] = [
    "png", "jpg", "jpeg", "jpe", "tif", "tiff", "exr", "hdr", "pic", "bmp", "gif",
];
/// The end of what `compress` packed, behind an image's own.
const PACKED: &str = ".z";
/// How deep folders in folders are looked into.
const DEEPEST: usize = 8;
/// The most files looked at.
const MOST: usize = 1_000_000;

/// An image of a set.
#[derive(Clone, Debug)]
pub(super) struct SetImage {
    /// Its path below the folder or in the archive, with `/`.
    pub(super) name: String,
    /// Where it is read from.
    pub(super) path: PathBuf,
}

/// What folders and archives hold.
#[derive(Debug)]
pub(super) struct Listing {
    /// The first of them.
    source: PathBuf,
    pub(super) place: Place,
    /// Sorted by name.
    pub(super) images: Vec<SetImage>,
    /// The names of other files.
    pub(super) others: Vec<String>,
    /// Files in archives that list images, by their paths.
    pub(super) lists: Vec<PathBuf>,
}

impl Listing {
    /// Looks through folders and the directories of archives: together they hold one set. Hidden files are left out.
    pub(super) fn of(sources: &[impl AsRef<Path>]) -> Result<Self> {
        let mut listing = Self {
            source: sources
                .first()
                .map(|s| s.as_ref().to_path_buf())
                .unwrap_or_default(),
            place: Place::default(),
            images: Vec::new(),
            others: Vec::new(),
            lists: Vec::new(),
        };
        sources
            .iter()
            .try_for_each(|source| listing.add(source.as_ref()))?;
        listing
            .images
            .sort_by(|a, b| a.name.cmp(&b.name).then_with(|| a.path.cmp(&b.path)));
        Ok(listing)
    }

    /// Adds what a folder or an archive holds.
    fn add(&mut self, source: &Path) -> Result<()> {
        let mut names = Vec::new();
        let is_archive = !source.is_dir();
        if is_archive {
            let archive = Archive::open(source)?;
            names.extend(archive.names().map(str::to_owned));
            self.place.archives.push(archive);
        } else {
            walk(source, "", DEEPEST, &mut names)?;
        }
        for name in names.into_iter().filter(|name| !is_hidden(name)) {
            let path = source.join(&name);
            if is_image(&name) {
                self.images.push(SetImage { name, path });
                continue;
            }
            if is_archive && is_list(&path) {
                self.lists.push(path);
            }
            self.others.push(name);
        }
        Ok(())
    }

    /// The set's own name: that of its first folder or archive.
    pub(super) fn name(&self) -> String {
        let whole = fs::canonicalize(&self.source).unwrap_or_else(|_| self.source.clone());
        let name = match whole.is_dir() {
            true => whole.file_name(),
            false => whole.file_stem(),
        };
        name.unwrap_or(OsStr::new("set"))
            .to_string_lossy()
            .into_owned()
    }

    /// The name of some image.
    pub(super) fn example(&self) -> &str {
        self.images.first().map_or("", |image| image.name.as_str())
    }
}

/// The files below a folder.
fn walk(folder: &Path, prefix: &str, deeper: usize, names: &mut Vec<String>) -> Result<()> {
    for entry in fs::read_dir(folder).map_err(Error::io(folder, "read"))? {
        let entry = entry.map_err(Error::io(folder, "read"))?;
        let path = entry.path();
        let name = format!("{prefix}{}", entry.file_name().to_string_lossy());
        if names.len() == MOST {
            return Err(Error::data("files", format!("more than {MOST}"))
                .expected("a folder of one image set")
                .in_file(folder));
        }
        match path.is_dir() {
            true if deeper > 0 && !is_hidden(&name) => {
                walk(&path, &format!("{name}/"), deeper - 1, names)?;
            }
            true => {}
            false => names.push(name),
        }
    }
    Ok(())
}

/// Whether a file is called as images are, packed or not.
fn is_image(name: &str) -> bool {
    let lower = name.to_lowercase();
    let plain = lower.strip_suffix(PACKED).unwrap_or(&lower);
    let extension = plain.rsplit_once('.').map_or("", |(_, end)| end);
    IMAGES.contains(&extension)
}

/// Whether a file is hidden, or what an operating system leaves in archives.
fn is_hidden(name: &str) -> bool {
    name.split('/')
        .any(|part| part.starts_with('.') || part == "__MACOSX")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn images_of_all_folders_are_listed() {
        let folder = tempfile::tempdir().unwrap();
        for name in [
            "b/2.PNG",
            "a.bmp.Z",
            "b/c/3.exr",
            "b/.x.png",
            "__MACOSX/y.png",
            "z.txt",
        ] {
            let path = folder.path().join(name);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, "").unwrap();
        }
        let listing = Listing::of(&[folder.path()]).unwrap();
        let names: Vec<&str> = listing
            .images
            .iter()
            .map(|image| image.name.as_str())
            .collect();
        assert_eq!(names, ["a.bmp.Z", "b/2.PNG", "b/c/3.exr"]);
        assert_eq!(listing.others, ["z.txt"]);
        assert!(listing.images[1].path.is_file());
    }
}
