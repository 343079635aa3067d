//! The conventions of docs/architecture.md that a machine can check: imports follow the rooms,
//! every file says what it is, none grows crowded.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// What every room may use.
const GROUND: [&str; 7] = [
    "error",
    "format",
    "grid",
    "index",
    "neighborhood",
    "progress",
    "random",
];

/// Each room and what it may import beside itself and the ground (docs/architecture.md).
const ROOMS: [(&str, &[&str]); 10] = [
    ("btf", &[]),
    ("texton", &["btf"]),
    ("exemplar", &["btf", "texton"]),
    ("mesh", &[]),
    ("sites", &["mesh"]),
    ("maps", &["mesh"]),
    ("synthesis", &["exemplar", "mesh", "sites", "maps"]),
    ("render", &["btf", "mesh", "maps"]),
    ("report", &[]),
    (
        "cli",
        &[
            "btf",
            "texton",
            "exemplar",
            "mesh",
            "sites",
            "maps",
            "synthesis",
            "render",
            "report",
        ],
    ),
];

const MOST_LINES: usize = 600;

fn source_files() -> Vec<PathBuf> {
    let mut files = Vec::new();
    let mut folders = vec![Path::new(env!("CARGO_MANIFEST_DIR")).join("src")];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                files.push(path);
            }
        }
    }
    assert!(files.len() > 30, "the source was not found");
    files
}

/// The room a source file lies in: the first part of its path below `src`.
fn room_of(file: &Path) -> String {
    let below = file
        .strip_prefix(Path::new(env!("CARGO_MANIFEST_DIR")).join("src"))
        .unwrap();
    let first = below.iter().next().unwrap().to_string_lossy();
    first.trim_end_matches(".rs").to_owned()
}

/// Every room a source text names as `crate::room`, outside its tests.
fn rooms_named_in(text: &str) -> BTreeSet<&str> {
    let code = text.lines().take_while(|line| *line != "#[cfg(test)]");
    code.filter(|line| !line.trim_start().starts_with("//"))
        .flat_map(|line| line.split("crate::").skip(1))
        .map(|rest| {
            let end = rest.find(|c: char| !c.is_alphanumeric() && c != '_');
            &rest[..end.unwrap_or(rest.len())]
        })
        .filter(|name| !name.is_empty())
        .collect()
}

#[test]
fn imports_follow_the_rooms() {
    let mut faults = Vec::new();
    for file in source_files() {
        let room = room_of(&file);
        let text = fs::read_to_string(&file).unwrap();
        let allowed: Vec<&str> = match ROOMS.iter().find(|(name, _)| *name == room) {
            Some((_, others)) => GROUND.iter().chain(*others).copied().collect(),
            None => GROUND.to_vec(),
        };
        for named in rooms_named_in(&text) {
            if named != room && !allowed.contains(&named) && room != "lib" {
                faults.push(format!("{} imports {named}", file.display()));
            }
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn every_file_says_what_it_is() {
    let mute: Vec<PathBuf> = source_files()
        .into_iter()
        .filter(|file| !fs::read_to_string(file).unwrap().starts_with("//! "))
        .collect();
    assert!(mute.is_empty(), "no //! at the top of {mute:?}");
}

#[test]
fn no_file_grows_crowded() {
    for file in source_files() {
        let lines = fs::read_to_string(&file).unwrap().lines().count();
        assert!(lines <= MOST_LINES, "{} has {lines} lines", file.display());
    }
}
