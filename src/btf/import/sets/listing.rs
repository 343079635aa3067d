//! The images of a folder, of the folders in it, or of a zip archive.

use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};

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

/// What a folder or an archive holds.
#[derive(Debug)]
pub(super) struct Listing {
    source: PathBuf,
    pub(super) place: Place,
    /// Sorted by name.
    pub(super) images: Vec<SetImage>,
    /// The names of other files.
    pub(super) others: Vec<String>,
}

impl Listing {
    /// Looks through a folder or the directory of an archive. Hidden files are left out.
    pub(super) fn of(source: &Path) -> Result<Self> {
        let (place, names) = match source.is_dir() {
            true => {
                let mut names = Vec::new();
                walk(source, "", DEEPEST, &mut names)?;
                (Place::Files, names)
            }
            false => {
                let archive = Archive::open(source)?;
                let names = archive.names().map(str::to_owned).collect();
                (Place::Archive(archive), names)
            }
        };
        let seen = names.into_iter().filter(|name| !is_hidden(name));
        let (mut images, others): (Vec<String>, Vec<String>) =
            seen.partition(|name| is_image(name));
        images.sort();
        let image = |name: String| SetImage {
            path: source.join(&name),
            name,
        };
        Ok(Self {
            source: source.to_path_buf(),
            place,
            images: images.into_iter().map(image).collect(),
            others,
        })
    }

    /// The set's own name: that of its folder or archive.
    pub(super) fn name(&self) -> String {
        let whole = fs::canonicalize(&self.source).unwrap_or_else(|_| self.source.clone());
        let name = match self.place {
            Place::Files => whole.file_name(),
            Place::Archive(_) => whole.file_stem(),
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
        let listing = Listing::of(folder.path()).unwrap();
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
