//! Where the images of a list are: captures are moved, their lists have outdated folders, and the list of a
//! calibrated dome names other images.

mod found;
mod given;
mod names;

use std::borrow::Cow;
use std::fs;
use std::path::{Path, PathBuf};

pub(super) use crate::btf::import::find_images::found::Found;
pub(super) use crate::btf::import::find_images::given::from;

use crate::btf::import::find_images::names::{Names, base_name, by_name, entries};
use crate::btf::import::listed::Listed;
use crate::error::{Error, Result};

/// Names of folders that hold the images of a capture beside its lists, in lower case.
const IMAGE_FOLDERS: [&str; 13] = [
    "images",
    "image",
    "img",
    "imgs",
    "photos",
    "photographs",
    "jpg",
    "jpeg",
    "png",
    "tif",
    "tiff",
    "exr",
    "jpeg-exports",
];
/// Where more folders than this lie beside each other, none of them is looked into.
const MOST_FOLDERS: usize = 200;

/// Finds the images of the list that lies in `folder`, where the user said nothing.
///
/// First as each line names it, or beside the list. Where some are missing, one folder that holds all of
/// them by name, whatever its case: inside the list's folder, around it, or beside it where its name says
/// that it holds images.
pub(super) fn find(listed: &[Listed], folder: &Path) -> Result<Found> {
    // Go by the names of the lines.
    if let Some(nameless) = listed.iter().find(|image| image.file.is_empty()) {
        return Err(
            Error::data(format!("line {}", nameless.line), "no file name")
                .expected("file x y z")
                .advice("for a list without names, give the images: --images FOLDER|GLOB"),
        );
    }
    let paths: Vec<PathBuf> = listed
        .iter()
        .map(|image| near(&image.file, folder))
        .collect();
    if paths.iter().all(|path| path.exists()) {
        return Ok(Found { paths, note: None });
    }
    // Look for one folder that has them all.
    let complete = complete_folders(listed, folder)?;
    match complete.as_slice() {
        [] => Ok(Found { paths, note: None }),
        [(place, paths)] => Ok(Found {
            paths: paths.clone(),
            note: Some(format!("images found in {}", place.display())),
        }),
        [(one, _), (other, _), ..] => Err(Error::data(
            "images",
            format!(
                "all of them are in {} and in {}",
                one.display(),
                other.display()
            ),
        )
        .expected("one folder that holds them")
        .advice("choose one: --images FOLDER")),
    }
}

/// Finds the images of a list among files, by the last part of their names; all that are missing are told.
pub(super) fn by_last_names(
    listed: &[Listed],
    files: impl IntoIterator<Item = PathBuf>,
) -> Result<Vec<PathBuf>> {
    let names = Names::of_files(files);
    if let Some(paths) = by_name(listed, &names) {
        return Ok(paths);
    }
    let missing = listed
        .iter()
        .filter(|image| names.get(&image.file).is_none());
    let told: Vec<String> = missing
        .map(|image| format!("`{}` (line {})", image.file, image.line))
        .collect();
    Err(
        Error::data("images", format!("missing: {}", told.join(", ")))
            .expected("a file for each line"),
    )
}

/// The file as a line names it, or one of that name beside the list.
fn near(named: &str, folder: &Path) -> PathBuf {
    let as_named = folder.join(named.replace('\\', "/"));
    if as_named.exists() {
        return as_named;
    }
    let beside = folder.join(base_name(named));
    if beside.exists() { beside } else { as_named }
}

/// The folder part that a line names, as `jpg` of `C:\old\jpg\a.jpg`.
fn named_folder(named: &str) -> Option<&str> {
    named
        .rsplit(['/', '\\'])
        .nth(1)
        .filter(|part| !part.is_empty())
}

/// Folders near the list that hold all images, with the images. One that has the name lines give alone
/// counts where several do.
fn complete_folders(listed: &[Listed], folder: &Path) -> Result<Vec<(PathBuf, Vec<PathBuf>)>> {
    let here = match folder.as_os_str().is_empty() {
        true => Path::new("."),
        false => folder,
    };
    let around = here.join("..");
    let mut places = vec![here.to_path_buf()];
    places.extend(folders_in(here)?);
    places.push(around.clone());
    // Other captures may lie beside this one, with images of the same names.
    let wanted = listed.first().and_then(|image| named_folder(&image.file));
    let holds_images = |place: &PathBuf| {
        let name = name_of(place).to_lowercase();
        let is_named = wanted.is_some_and(|wanted| wanted.to_lowercase() == name);
        (is_named || IMAGE_FOLDERS.contains(&name.as_str())) && !same(place, here)
    };
    places.extend(
        folders_in(&around)
            .unwrap_or_default()
            .into_iter()
            .filter(holds_images),
    );
    let mut complete = Vec::new();
    for place in places {
        if let Some(paths) = by_name(listed, &Names::of(&place).unwrap_or_default()) {
            complete.push((place, paths));
        }
    }
    let has_name = |(place, _): &&(PathBuf, Vec<PathBuf>)| wanted == Some(name_of(place).as_ref());
    let named: Vec<_> = complete.iter().filter(has_name).cloned().collect();
    Ok(if named.len() == 1 { named } else { complete })
}

fn name_of(folder: &Path) -> Cow<'_, str> {
    folder.file_name().unwrap_or_default().to_string_lossy()
}

fn same(a: &Path, b: &Path) -> bool {
    matches!((fs::canonicalize(a), fs::canonicalize(b)), (Ok(a), Ok(b)) if a == b)
}

fn folders_in(folder: &Path) -> Result<Vec<PathBuf>> {
    let mut folders: Vec<PathBuf> = entries(folder)?
        .into_iter()
        .filter(|path| path.is_dir())
        .collect();
    folders.sort();
    match folders.len() {
        0..=MOST_FOLDERS => Ok(folders),
        _ => Ok(Vec::new()),
    }
}

/// Lists and folders for tests.
#[cfg(test)]
mod fixtures {
    use glam::DVec3;

    use super::*;
    use crate::btf::direction::Direction;

    pub(super) fn listed(names: &[&str]) -> Vec<Listed> {
        let image = |(line, name): (usize, &&str)| Listed {
            line: line as u64 + 1,
            file: (*name).into(),
            view: Direction(DVec3::Z),
            light: Direction(DVec3::Z),
        };
        names.iter().enumerate().map(image).collect()
    }

    pub(super) fn folder(files: &[&str]) -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        for file in files {
            let path = folder.path().join(file);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, "").unwrap();
        }
        folder
    }

    pub(super) fn ends(found: &Found) -> Vec<String> {
        let end = |path: &PathBuf| {
            let parts: Vec<_> = path
                .iter()
                .rev()
                .take(2)
                .map(|p| p.to_string_lossy())
                .collect();
            format!("{}/{}", parts[1], parts[0])
        };
        found.paths.iter().map(end).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::btf::import::find_images::fixtures::{ends, folder, listed};

    #[test]
    fn moved_captures_are_found_as_a_whole() {
        let list = listed(&["C:\\dome\\jpg\\A.JPG", "C:\\dome\\jpg\\b.jpg"]);
        for (files, place) in [
            (vec!["cap/A.JPG", "cap/b.jpg"], "cap"),
            (vec!["cap/photos/a.jpg", "cap/photos/b.jpg"], "photos"),
            (vec!["cap/x", "jpg/A.jpg", "jpg/b.JPG"], "jpg"),
            (
                vec![
                    "cap/x",
                    "jpg/a.jpg",
                    "jpg/b.jpg",
                    "small/a.jpg",
                    "small/b.jpg",
                ],
                "jpg",
            ),
        ] {
            let root = folder(&files);
            let found = find(&list, &root.path().join("cap")).unwrap();
            let ends = ends(&found);
            assert!(
                ends[0].starts_with(place) && ends[1].starts_with(place),
                "{files:?}: {ends:?}"
            );
            assert!(found.paths.iter().all(|path| path.exists()));
        }
        let other = folder(&["cap/x", "vase/a.jpg", "vase/b.jpg"]);
        let found = find(&list, &other.path().join("cap")).unwrap();
        assert!(found.paths.iter().all(|path| !path.exists()));
        let twice = folder(&[
            "cap/one/a.jpg",
            "cap/one/b.jpg",
            "cap/two/a.jpg",
            "cap/two/b.jpg",
        ]);
        let error = find(&list, &twice.path().join("cap"))
            .unwrap_err()
            .to_string();
        assert!(
            error.contains("one") && error.contains("two") && error.contains("--images"),
            "{error}"
        );
    }
}
