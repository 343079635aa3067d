//! Where the images of a list are: files of their own, or members of archives.

use std::fs;
use std::path::Path;

use crate::error::{Error, Result};
use crate::format::archive::Archive;
use crate::format::compress;
use crate::format::guard::guarded;

/// Where images are read from: zip archives, where an image's path is that of an archive and then the member's name,
/// and files for all other paths.
#[derive(Clone, Debug, Default)]
pub struct Place {
    pub(super) archives: Vec<Archive>,
}

/// What is known of an image's file without reading it.
pub(super) struct Stated {
    /// Bytes.
    pub(super) length: u64,
    /// The checksum in the directory of an archive.
    pub(super) checksum: Option<u32>,
}

impl Place {
    /// The file that holds an image: its own, or an archive.
    pub fn file_of<'a>(&'a self, image: &'a Path) -> &'a Path {
        self.archive_of(image).map_or(image, Archive::path)
    }

    fn archive_of(&self, image: &Path) -> Option<&Archive> {
        self.archives
            .iter()
            .find(|archive| image.starts_with(archive.path()))
    }

    /// What is known of an image's file without reading it.
    pub(super) fn stated(&self, image: &Path) -> Result<Stated> {
        match self.archive_of(image) {
            Some(archive) => {
                let (length, checksum) = archive.stated(&member_name(archive, image))?;
                Ok(Stated {
                    length,
                    checksum: Some(checksum),
                })
            }
            None => Ok(Stated {
                length: fs::metadata(image).map_err(Error::io(image, "read"))?.len(),
                checksum: None,
            }),
        }
    }

    /// The bytes of an image's file, expanded where it is packed by `compress`.
    pub(super) fn read(&self, image: &Path) -> Result<Vec<u8>> {
        let bytes = match self.archive_of(image) {
            Some(archive) => archive.read(&member_name(archive, image))?,
            None => fs::read(image).map_err(Error::io(image, "read"))?,
        };
        match compress::is_compressed(&bytes) {
            true => guarded(image, || compress::expand(&bytes)),
            false => Ok(bytes),
        }
    }
}

/// The name of an image in its archive.
fn member_name(archive: &Archive, image: &Path) -> String {
    let name = image.strip_prefix(archive.path()).unwrap_or(image);
    name.to_string_lossy().replace('\\', "/")
}
