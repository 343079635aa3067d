//! A capture: its list, its images, its directions.

use std::path::Path;

use crate::btf::direction::Direction;
use crate::btf::direction_set::DirectionSet;
use crate::btf::import::{ImageList, ListOptions, MeasuredImage, SetOptions, read_source};
use crate::cli::info::sample::directions;
use crate::cli::outcome::Outcome;
use crate::error::Result;

/// Reads the list of a capture and describes its content.
pub fn describe(path: &Path) -> Result<Outcome> {
    let list = read_source(&[path], &ListOptions::default(), &SetOptions::default())?;
    // Look for images that are not there.
    let is_missing = |image: &&MeasuredImage| !list.place.file_of(&image.path).is_file();
    let missing: Vec<String> = list
        .images
        .iter()
        .filter(is_missing)
        .map(|image| image.path.display().to_string())
        .collect();
    // Tell what the list says.
    let mut outcome = Outcome::default()
        .line(headline(&list))
        .line(directions("views", &distinct(&list, |image| image.view)))
        .line(directions("lights", &distinct(&list, |image| image.light)))
        .figure("kind", "capture")
        .figure("name", list.name.as_str())
        .figure("list", list.path.to_string_lossy())
        .figure("source", list.kind)
        .figure("images", list.images.len())
        .figure("views", distinct(&list, |image| image.view).len())
        .figure("lights", distinct(&list, |image| image.light).len());
    for note in &list.notes {
        outcome = outcome.line(note.as_str());
    }
    if let Some(gaps) = gaps(&list) {
        outcome = outcome.line(gaps);
    }
    // Tell what can be done with it.
    outcome = match missing.first() {
        None => outcome.next(format!(
            "mesotex import {} -o {}.sample",
            path.display(),
            list.name
        )),
        Some(first) => outcome.line(format!(
            "cannot be imported: {} of {} images are missing, {first} first (import \
             --images FOLDER takes them from a folder)",
            missing.len(),
            list.images.len()
        )),
    };
    Ok(outcome
        .figure("notes", list.notes)
        .figure("missing", missing))
}

fn headline(list: &ImageList) -> String {
    format!(
        "capture `{}` ({}): {} images of {}",
        list.name,
        list.kind,
        list.images.len(),
        list.path.display()
    )
}

/// Says how many images a set lacks, where it is one with gaps.
fn gaps(list: &ImageList) -> Option<String> {
    let views = distinct(list, |image| image.view).len();
    let all = views * distinct(list, |image| image.light).len();
    let missing = all.saturating_sub(list.images.len());
    let has_gaps = list.is_set && missing > 0 && missing * 2 <= all;
    has_gaps.then(|| {
        format!("{missing} of {all} images are missing: import --fill interpolates them, --scattered leaves them out")
    })
}

fn distinct(list: &ImageList, of: impl Fn(&MeasuredImage) -> Direction) -> Vec<Direction> {
    let mut all: Vec<[f64; 3]> = list
        .images
        .iter()
        .map(|image| of(image).0.to_array())
        .collect();
    all.sort_by(|a, b| a.partial_cmp(b).unwrap_or(std::cmp::Ordering::Equal));
    all.dedup();
    all.into_iter().map(Direction::from).collect()
}

/// Reads a table of directions and describes its content.
pub fn describe_directions(path: &Path) -> Result<Outcome> {
    let set = DirectionSet::File(path.to_path_buf()).directions()?;
    Ok(Outcome::default()
        .line(directions("directions", &set))
        .figure("kind", "direction set")
        .figure("directions", set.len()))
}
