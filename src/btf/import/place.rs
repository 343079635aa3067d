//! Where the images of a list are: files of their own, or members of an archive.

use std::fs;
use std::path::Path;

use crate::error::{Error, Result};
use crate::format::archive::Archive;
use crate::format::compress;
use crate::format::guard::guarded;

/// Where images are read from.
#[derive(Clone, Debug, Default)]
pub enum Place {
    /// Files by their paths.
    #[default]
    Files,
    /// A zip archive; an image's path is the archive's, then the member's name.
    Archive(Archive),
}

impl Place {
    /// The bytes of an image's file, expanded where it is packed by `compress`.
    pub(super) fn read(&self, image: &Path) -> Result<Vec<u8>> {
        let bytes = match self {
            Self::Files => fs::read(image).map_err(Error::io(image, "read"))?,
            Self::Archive(archive) => {
                let name = image.strip_prefix(archive.path()).unwrap_or(image);
                archive.read(&name.to_string_lossy().replace('\\', "/"))?
            }
        };
        match compress::is_compressed(&bytes) {
            true => guarded(image, || compress::expand(&bytes)),
            false => Ok(bytes),
        }
    }
}
