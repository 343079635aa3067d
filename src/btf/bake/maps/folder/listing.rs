//! The files of a folder: images that can be read, and the rest with the reason why not.

use std::fs;
use std::path::{Path, PathBuf};

use crate::btf::bake::maps::set::FileUse;
use crate::error::{Error, Result};

/// Images that are read, the more precise first: what a role takes where several files fit it.
const EXTENSIONS: [&str; 10] = [
    "exr", "hdr", "tif", "tiff", "png", "bmp", "gif", "jpg", "jpeg", "jpe",
];
/// Images of formats that are not read.
const UNREAD: [&str; 9] = [
    "tga", "webp", "psd", "dds", "jp2", "avif", "heic", "ktx", "ktx2",
];
/// Folders that hold the maps of a set beside its scene files, in lower case.
const MAP_FOLDERS: [&str; 4] = ["textures", "maps", "tex", "texture"];
/// The most files looked at.
const MOST_FILES: usize = 10_000;

/// What a folder holds; paths are relative to it.
pub(super) struct Listing {
    /// Images, sorted.
    pub(super) images: Vec<PathBuf>,
    /// Everything else that is not hidden.
    pub(super) others: Vec<FileUse>,
}

/// How precise an image of this name can be, 0 the most.
pub(super) fn precision(file: &Path) -> Option<usize> {
    let extension = extension(file);
    EXTENSIONS.iter().position(|&known| known == extension)
}

fn extension(file: &Path) -> String {
    file.extension()
        .unwrap_or_default()
        .to_string_lossy()
        .to_lowercase()
}

/// The files of a folder and of its folder of maps (`textures` in Poly Haven's archives); where it holds
/// no image at all, those of its only folder.
pub(super) fn of(folder: &Path) -> Result<Listing> {
    let mut found = Found::default();
    found.look_into(folder, Path::new(""))?;
    let inner = std::mem::take(&mut found.folders);
    let is_map_folder = |file: &PathBuf| {
        let name = file.to_string_lossy().to_lowercase();
        MAP_FOLDERS.contains(&name.as_str()) || (found.images.is_empty() && inner.len() == 1)
    };
    let (looked_into, left): (Vec<PathBuf>, Vec<PathBuf>) =
        inner.iter().cloned().partition(is_map_folder);
    for inside in looked_into {
        found.look_into(folder, &inside)?;
    }
    found.folders.extend(left);
    found.images.sort();
    let folders = found.folders.into_iter();
    found
        .others
        .extend(folders.map(|path| unused(path, "folder", "folders inside are not looked into")));
    Ok(Listing {
        images: found.images,
        others: found.others,
    })
}

#[derive(Default)]
struct Found {
    images: Vec<PathBuf>,
    others: Vec<FileUse>,
    folders: Vec<PathBuf>,
}

impl Found {
    fn look_into(&mut self, folder: &Path, inside: &Path) -> Result<()> {
        let place = folder.join(inside);
        for entry in fs::read_dir(&place).map_err(Error::io(&place, "read"))? {
            let entry = entry.map_err(Error::io(&place, "read"))?;
            let name = entry.file_name();
            if name.to_string_lossy().starts_with('.') {
                continue;
            }
            let file = inside.join(&name);
            let extension = extension(&file);
            if entry.path().is_dir() {
                self.folders.push(file);
            } else if precision(&file).is_some() {
                self.images.push(file);
            } else if UNREAD.contains(&extension.as_str()) {
                let why = format!(
                    "images of kind .{extension} are not read; convert it to PNG or OpenEXR"
                );
                self.others.push(unused(file, "unknown", why));
            } else {
                self.others
                    .push(unused(file, "no image", "it is not an image"));
            }
            if self.images.len() + self.others.len() > MOST_FILES {
                return Err(
                    Error::data("folder", format!("more than {MOST_FILES} files"))
                        .expected("the maps of one material"),
                );
            }
        }
        Ok(())
    }
}

/// Uses of files that are no candidates, with the reason.
fn unused(file: PathBuf, role: &str, why: impl Into<String>) -> FileUse {
    FileUse {
        file,
        role: role.to_owned(),
        used: false,
        why: why.into(),
    }
}
