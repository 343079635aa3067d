//! Images that the user names: by their names where the list has the same, else in natural order.

use std::cmp::Ordering;
use std::path::{Path, PathBuf};

use crate::btf::import::find_images::found::Found;
use crate::btf::import::find_images::names::{MOST, Names, by_name, entries};
use crate::btf::import::listed::Listed;
use crate::error::{Error, Result};

/// Images of these endings are taken from a folder.
const ENDINGS: [&str; 10] = [
    "png", "jpg", "jpeg", "tif", "tiff", "exr", "hdr", "bmp", "gif", "jpe",
];

/// Takes the images of `source`, a folder or a pattern: by name where their names are those of the list,
/// else in natural order.
pub(in crate::btf::import) fn from(listed: &[Listed], source: &Path) -> Result<Found> {
    let mut files = match source.is_dir() {
        true => images_in(source)?,
        false => matching(source)?,
    };
    // Go by name where all names are there.
    let names = Names::of_files(files.iter().cloned());
    if let Some(paths) = by_name(listed, &names) {
        return Ok(Found { paths, note: None });
    }
    // Refuse a folder that has some of them: their order would say nothing.
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
    // Go by order.
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
    use super::*;
    use crate::btf::import::find_images::fixtures::{ends, folder, listed};

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
