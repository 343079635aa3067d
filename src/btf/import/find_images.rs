//! Where the images of a list are: captures are moved, their lists keep old folders, and the list of a
//! calibrated dome names other images altogether.

use std::cmp::Ordering;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use crate::btf::import::Listed;
use crate::error::{Error, Result};

/// Images of these endings are taken from a folder.
const ENDINGS: [&str; 10] = [
    "png", "jpg", "jpeg", "tif", "tiff", "exr", "hdr", "bmp", "gif", "jpe",
];
/// The most files looked at in one folder.
const MOST: usize = 200_000;
/// Where more folders than this lie beside each other, none of them is looked into.
const MOST_FOLDERS: usize = 200;

/// The files of a list's images, in its order.
#[derive(Debug)]
pub(super) struct Found {
    pub(super) paths: Vec<PathBuf>,
    /// What the user should know of how they were found.
    pub(super) note: Option<String>,
}

/// Finds the images of the list that lies in `folder`, where the user said nothing.
///
/// First as each line names it, or beside the list. Where some are missing, one folder that holds all of
/// them by name, whatever its case: in the list's folder, beside it, or around it.
pub(super) fn find(listed: &[Listed], folder: &Path) -> Result<Found> {
    if let Some(nameless) = listed.iter().find(|image| image.file.is_empty()) {
        return Err(
            Error::data(format!("line {}", nameless.line), "no file name")
                .expected("file x y z")
                .advice("for a list without names, say where the images are: --images FOLDER|GLOB"),
        );
    }
    let paths: Vec<PathBuf> = listed
        .iter()
        .map(|image| near(&image.file, folder))
        .collect();
    if paths.iter().all(|path| path.exists()) {
        return Ok(Found { paths, note: None });
    }
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
        .advice("say which: --images FOLDER")),
    }
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

/// The last part of a path of any system.
fn base_name(named: &str) -> &str {
    named.rsplit(['/', '\\']).next().unwrap_or(named)
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
    let is_other = |place: &PathBuf| !same(place, here);
    places.extend(
        folders_in(&around)
            .unwrap_or_default()
            .into_iter()
            .filter(is_other),
    );
    let mut complete = Vec::new();
    for place in places {
        if let Some(paths) = by_name(listed, &Names::of(&place).unwrap_or_default()) {
            complete.push((place, paths));
        }
    }
    let wanted = listed.first().and_then(|image| named_folder(&image.file));
    let has_name = |(place, _): &&(PathBuf, Vec<PathBuf>)| {
        place.file_name().and_then(|name| name.to_str()) == wanted && wanted.is_some()
    };
    let named: Vec<_> = complete.iter().filter(has_name).cloned().collect();
    Ok(if named.len() == 1 { named } else { complete })
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

fn entries(folder: &Path) -> Result<Vec<PathBuf>> {
    let mut paths = Vec::new();
    for entry in fs::read_dir(folder)
        .map_err(Error::io(folder, "read"))?
        .take(MOST)
    {
        paths.push(entry.map_err(Error::io(folder, "read"))?.path());
    }
    Ok(paths)
}

/// Files by their names, and by their names in lower case where only one has it.
#[derive(Default)]
struct Names {
    exact: BTreeMap<String, PathBuf>,
    in_lower_case: BTreeMap<String, Option<PathBuf>>,
}

impl Names {
    fn of(folder: &Path) -> Result<Self> {
        Ok(Self::of_files(
            entries(folder)?.into_iter().filter(|path| path.is_file()),
        ))
    }

    fn of_files(files: impl IntoIterator<Item = PathBuf>) -> Self {
        let mut names = Self::default();
        for path in files {
            let Some(name) = path
                .file_name()
                .and_then(|name| name.to_str())
                .map(str::to_owned)
            else {
                continue;
            };
            let lower = names.in_lower_case.entry(name.to_lowercase());
            lower
                .and_modify(|other| *other = None)
                .or_insert_with(|| Some(path.clone()));
            names.exact.insert(name, path);
        }
        names
    }

    fn get(&self, named: &str) -> Option<&PathBuf> {
        let name = base_name(named);
        let lower = || self.in_lower_case.get(&name.to_lowercase())?.as_ref();
        self.exact.get(name).or_else(lower)
    }
}

fn by_name(listed: &[Listed], names: &Names) -> Option<Vec<PathBuf>> {
    let path = |image: &Listed| names.get(&image.file).cloned();
    listed.iter().map(path).collect()
}

/// Takes the images of `source`, a folder or a pattern: by name where their names are those of the list,
/// else in natural order.
pub(super) fn from(listed: &[Listed], source: &Path) -> Result<Found> {
    let mut files = match source.is_dir() {
        true => images_in(source)?,
        false => matching(source)?,
    };
    let names = Names::of_files(files.iter().cloned());
    if let Some(paths) = by_name(listed, &names) {
        return Ok(Found { paths, note: None });
    }
    let lines = listed.iter();
    let is_there = |image: &&Listed| !image.file.is_empty() && names.get(&image.file).is_some();
    let there = lines.filter(is_there).count();
    let missing = listed.iter().find(|image| !is_there(image));
    if let Some(missing) = missing.filter(|_| there > 0) {
        return Err(Error::data(
            format!("line {}", missing.line),
            format!(
                "no image `{}` in {}, where {there} others are",
                missing.file,
                source.display()
            ),
        )
        .expected("all images of the list there, or none of them (then their order counts)"));
    }
    if files.len() != listed.len() {
        return Err(
            Error::data("images", format!("{} in {}", files.len(), source.display()))
                .expected(format!("{}, one for each line of the list", listed.len())),
        );
    }
    files.sort_by(|a, b| natural(&a.to_string_lossy(), &b.to_string_lossy()).then(a.cmp(b)));
    let ends = |files: &[PathBuf]| match files {
        [first, .., last] => format!("{} to {}", first.display(), last.display()),
        _ => String::new(),
    };
    let note = format!(
        "images taken in their order, {}: the list has other names",
        ends(&files)
    );
    Ok(Found {
        paths: files,
        note: Some(note),
    })
}

fn images_in(folder: &Path) -> Result<Vec<PathBuf>> {
    let is_image = |path: &PathBuf| {
        let ending = path
            .extension()
            .unwrap_or_default()
            .to_string_lossy()
            .to_lowercase();
        path.is_file() && ENDINGS.contains(&ending.as_str())
    };
    Ok(entries(folder)?.into_iter().filter(is_image).collect())
}

fn matching(pattern: &Path) -> Result<Vec<PathBuf>> {
    let expected = "a folder, or a pattern with * and ? in quotes";
    let text = pattern.to_string_lossy();
    let found = glob::glob(&text)
        .map_err(|error| Error::option("images", format!("`{text}`: {error}"), expected))?;
    let files: Vec<PathBuf> = found
        .flatten()
        .filter(|path| path.is_file())
        .take(MOST)
        .collect();
    match files.is_empty() {
        true => Err(Error::option(
            "images",
            format!("`{text}` matches no file"),
            expected,
        )),
        false => Ok(files),
    }
}

/// The order a person puts names in: runs of digits by their number.
fn natural(a: &str, b: &str) -> Ordering {
    let (mut a, mut b) = (a, b);
    loop {
        let (Some(left), Some(right)) = (a.chars().next(), b.chars().next()) else {
            return a.len().cmp(&b.len());
        };
        let order = if left.is_ascii_digit() && right.is_ascii_digit() {
            let (number, rest) = leading_number(a);
            let (other, other_rest) = leading_number(b);
            (a, b) = (rest, other_rest);
            number.len().cmp(&other.len()).then(number.cmp(other))
        } else {
            (a, b) = (&a[left.len_utf8()..], &b[right.len_utf8()..]);
            left.cmp(&right)
        };
        if order != Ordering::Equal {
            return order;
        }
    }
}

/// The digits a text begins with, without zeros before them, and the rest.
fn leading_number(text: &str) -> (&str, &str) {
    let end = text
        .find(|c: char| !c.is_ascii_digit())
        .unwrap_or(text.len());
    (text[..end].trim_start_matches('0'), &text[end..])
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::btf::direction::Direction;

    fn listed(names: &[&str]) -> Vec<Listed> {
        let image = |(line, name): (usize, &&str)| Listed {
            line: line as u64 + 1,
            file: (*name).into(),
            view: Direction(DVec3::Z),
            light: Direction(DVec3::Z),
        };
        names.iter().enumerate().map(image).collect()
    }

    fn folder(files: &[&str]) -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        for file in files {
            let path = folder.path().join(file);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, "").unwrap();
        }
        folder
    }

    fn ends(found: &Found) -> Vec<String> {
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
        let twice = folder(&["cap/x", "one/a.jpg", "one/b.jpg", "two/a.jpg", "two/b.jpg"]);
        let error = find(&list, &twice.path().join("cap"))
            .unwrap_err()
            .to_string();
        assert!(
            error.contains("one") && error.contains("two") && error.contains("--images"),
            "{error}"
        );
    }

    #[test]
    fn images_of_other_names_are_taken_in_order() {
        let root = folder(&[
            "shots/img10.tif",
            "shots/img2.tif",
            "shots/img1.tif",
            "shots/notes.txt",
        ]);
        let shots = root.path().join("shots");
        let list = listed(&["ball_0.jpg", "ball_1.jpg", ""]);
        for source in [shots.clone(), shots.join("img*.tif")] {
            let found = from(&list, &source).unwrap();
            assert_eq!(
                ends(&found),
                ["shots/img1.tif", "shots/img2.tif", "shots/img10.tif"]
            );
            assert!(found.note.unwrap().contains("in their order"));
        }
        let error = from(&list[..2], &shots).unwrap_err().to_string();
        assert!(
            error.contains("3 in") && error.contains("expected 2"),
            "{error}"
        );
        let error = from(&list, &shots.join("*.jpg")).unwrap_err().to_string();
        assert!(error.contains("matches no file"), "{error}");
    }

    #[test]
    fn images_of_the_lists_names_go_by_name() {
        let root = folder(&[
            "shots/a1.jpg",
            "shots/a2.jpg",
            "shots/a10.jpg",
            "shots/b.jpg",
        ]);
        let shots = root.path().join("shots");
        let found = from(&listed(&["x\\a1.jpg", "x\\a10.jpg", "x\\A2.jpg"]), &shots).unwrap();
        assert_eq!(
            ends(&found),
            ["shots/a1.jpg", "shots/a10.jpg", "shots/a2.jpg"]
        );
        let error = from(&listed(&["a1.jpg", "c.jpg"]), &shots)
            .unwrap_err()
            .to_string();
        assert!(error.contains("line 2: no image `c.jpg`"), "{error}");
    }

    #[test]
    fn numbers_count_in_the_order_of_names() {
        let mut names = ["a10", "a2", "a02b", "a1", "b", "a"];
        names.sort_by(|a, b| natural(a, b));
        assert_eq!(names, ["a", "a1", "a2", "a02b", "a10", "b"]);
    }
}
