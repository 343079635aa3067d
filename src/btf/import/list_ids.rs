//! Ids of image lists: of a whole list, and of the files of some of its images. No image is decoded.
//!
//! The id of a whole list covers names, lengths, directions, and the bytes of at most 64 images spread over the list,
//! so that no shard reads all files. Images in archives are known by the lengths and checksums that the directory
//! states.

use std::path::{Path, PathBuf};

use crate::btf::import::arrangement::{Arrangement, Slot};
use crate::btf::import::image_list::ImageList;
use crate::btf::import::near_field::NearPositions;
use crate::btf::import::prepare::inspected;
use crate::error::Result;
use crate::format::id::{ContentId, hash_file};
use crate::progress::Progress;

/// The place of an image that is interpolated.
const NONE: u64 = u64::MAX;

/// The id of a list as it is arranged.
pub(super) fn of_list(list: &ImageList, arrangement: &Arrangement) -> Result<ContentId> {
    let mut hasher = blake3::Hasher::new();
    // Names and sizes of all images.
    let root = common_folder(list.images.iter().map(|image| image.path.as_path()));
    for image in &list.images {
        let name = image.path.strip_prefix(&root).unwrap_or(&image.path);
        let name = name.to_string_lossy().replace('\\', "/");
        let stated = list.place.stated(&image.path)?;
        hasher.update(bytemuck::cast_slice(&[name.len() as u64, stated.length]));
        hasher.update(name.as_bytes());
        hasher.update(&stated.checksum.unwrap_or(0).to_le_bytes());
    }
    // Which of them stands for which directions.
    for slot in &arrangement.slots {
        let image = match slot {
            Slot::Read(image) => *image as u64,
            Slot::Fill(_) => NONE,
        };
        hasher.update(&image.to_le_bytes());
    }
    hasher.update(bytemuck::cast_slice(
        arrangement.pairs.as_deref().unwrap_or_default(),
    ));
    if let Some(positions) = &list.positions {
        add_positions(&mut hasher, positions);
    }
    // The bytes of some.
    let used = arrangement.read_images();
    for place in inspected(used.len()) {
        add_file(&mut hasher, list, used[place])?;
    }
    Ok(ContentId::of_hash(&hasher.finalize()))
}

/// The id of the files of some images.
pub(super) fn of_files(
    list: &ImageList,
    images: &[usize],
    progress: Progress<'_>,
) -> Result<ContentId> {
    let mut hasher = blake3::Hasher::new();
    progress.begin("comparing files", images.len() as u64);
    for &image in images {
        add_file(&mut hasher, list, image)?;
        progress.advance(1)?;
    }
    progress.end();
    Ok(ContentId::of_hash(&hasher.finalize()))
}

/// The bytes of an image's file, or what an archive states of them.
fn add_file(hasher: &mut blake3::Hasher, list: &ImageList, image: usize) -> Result<()> {
    let path = &list.images[image].path;
    let stated = list.place.stated(path)?;
    hasher.update(&stated.length.to_le_bytes());
    match stated.checksum {
        Some(checksum) => {
            hasher.update(&checksum.to_le_bytes());
            Ok(())
        }
        None => hash_file(hasher, path),
    }
}

fn add_positions(hasher: &mut blake3::Hasher, positions: &NearPositions) {
    for places in [&positions.cameras, &positions.lamps] {
        let numbers = places.iter().flatten().flat_map(|place| place.to_array());
        let numbers: Vec<f64> = numbers.collect();
        hasher.update(&(numbers.len() as u64).to_le_bytes());
        hasher.update(bytemuck::cast_slice(&numbers));
    }
    let patch = [positions.patch.width, positions.patch.height];
    hasher.update(bytemuck::cast_slice(&patch));
}

/// The deepest folder that holds all images, so that names do not depend on where a machine has them.
fn common_folder<'a>(mut images: impl Iterator<Item = &'a Path>) -> PathBuf {
    let first = images.next().and_then(Path::parent);
    let mut folder = first.unwrap_or(Path::new("")).to_path_buf();
    for image in images {
        while !image.starts_with(&folder) && folder.pop() {}
    }
    folder
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_begin_below_what_all_images_share() {
        let folder = |paths: &[&str]| common_folder(paths.iter().map(Path::new));
        assert_eq!(folder(&["a/b/1.png", "a/b/2.png"]), Path::new("a/b"));
        assert_eq!(folder(&["a/b/1.png", "a/c/2.png"]), Path::new("a"));
        assert_eq!(folder(&["/a/1.png", "/b/2.png"]), Path::new("/"));
        assert_eq!(folder(&["1.png", "b/2.png"]), Path::new(""));
        assert_eq!(folder(&[]), Path::new(""));
    }
}
