//! The conventions of docs/architecture.md that a machine can check: imports follow the rooms, no files
//! use each other in a circle, every file says what it is, no file and no function grows crowded. And those
//! of docs/glossary.md: one word per idea.

mod circles;
mod functions;
mod language;
mod paths;
mod source;

use functions::Function;
use source::Source;

/// What every room may use.
const GROUND: [&str; 13] = [
    "byte_size",
    "error",
    "false_color",
    "format",
    "grid",
    "index",
    "lanes",
    "matrix",
    "neighborhood",
    "progress",
    "radial_basis",
    "random",
    "shard",
];

/// Each room and what it may import beside itself and the ground (docs/architecture.md).
const ROOMS: [(&str, &[&str]); 12] = [
    ("btf", &[]),
    ("texton", &["btf"]),
    ("exemplar", &["btf", "texton"]),
    ("mesh", &[]),
    ("sites", &["mesh"]),
    ("maps", &["mesh"]),
    ("textures", &["exemplar", "mesh", "maps"]),
    ("synthesis", &["exemplar", "mesh", "sites", "maps"]),
    ("vary", &["btf", "exemplar", "sites", "synthesis"]),
    ("render", &["btf", "mesh", "maps"]),
    ("report", &["btf", "mesh", "maps", "synthesis", "render"]),
    (
        "cli",
        &[
            "btf",
            "texton",
            "exemplar",
            "mesh",
            "sites",
            "maps",
            "textures",
            "synthesis",
            "vary",
            "render",
            "report",
        ],
    ),
];

/// Lines of a file, and lines of a function beside its comments.
const MOST_LINES: usize = 600;
const MOST_OF_A_FUNCTION: usize = 70;

/// Columns of a comment; rows of tables may be wider.
const MOST_COLUMNS: usize = 120;

#[test]
fn imports_follow_the_rooms() {
    let source = Source::of_this_crate();
    let mut faults = Vec::new();
    for file in &source.files {
        let room = Source::room_of(file);
        let allowed: Vec<&str> = match ROOMS.iter().find(|(name, _)| *name == room) {
            Some((_, others)) => GROUND.iter().chain(*others).copied().collect(),
            None => GROUND.to_vec(),
        };
        for named in source.rooms_named_by(file) {
            if named != room
                && !allowed.contains(&named.as_str())
                && !["lib", "main"].contains(&room)
            {
                faults.push(format!("{} imports {named}", file.name));
            }
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

/// No circle of `use` between files; `mod` declarations do not count.
#[test]
fn no_files_use_each_other_in_a_circle() {
    let source = Source::of_this_crate();
    let circle = circles::find(&source.uses()).map(|circle| circle.join("\n  uses "));
    assert_eq!(circle, None);
}

/// The circle among files of these names and texts.
fn circle_of(texts: &[(&str, &str)]) -> Option<String> {
    let owned = |&(name, text): &(&str, &str)| (name.to_owned(), text.to_owned());
    let source = Source::of_texts(texts.iter().map(owned));
    circles::find(&source.uses()).map(|circle| circle.join(" "))
}

#[test]
fn circles_are_found_however_they_are_written() {
    let with_last = |last: &str| {
        circle_of(&[
            ("lib.rs", "mod a; mod b;"),
            ("a/mod.rs", "mod one; mod two; pub use one::One;"),
            ("a/one.rs", "use crate::{b::B};"),
            ("a/two.rs", "use super::one;"),
            ("b.rs", last),
        ])
    };
    assert_eq!(with_last("use std::fs; mod c { use super::d; }"), None);
    assert_eq!(
        with_last("#[cfg(test)] mod tests { use crate::a::two::Two; }"),
        None
    );
    let through_two = with_last("use crate::{a::{two::Two}, error};");
    assert_eq!(through_two.unwrap(), "a/one.rs b.rs a/two.rs a/one.rs");
    let through_parent = with_last("use super::a::{self};");
    assert_eq!(through_parent.unwrap(), "a/mod.rs a/one.rs b.rs a/mod.rs");
    let twins = [("x.rs", "mod y; use y::Y;"), ("x/y.rs", "use super::{X};")];
    assert_eq!(circle_of(&twins).unwrap(), "x.rs x/y.rs x.rs");
}

#[test]
fn every_file_says_what_it_is() {
    let source = Source::of_this_crate();
    let mute = source
        .files
        .iter()
        .filter(|file| !file.text.starts_with("//! "));
    let mute: Vec<&str> = mute.map(|file| file.name.as_str()).collect();
    assert!(mute.is_empty(), "no //! at the top of {mute:?}");
}

#[test]
fn no_file_grows_crowded() {
    for (name, text) in source::texts_below("src").chain(source::texts_below("tests")) {
        let lines = text.lines().count();
        assert!(lines <= MOST_LINES, "{name} has {lines} lines");
    }
}

#[test]
fn comments_are_at_most_120_columns_wide() {
    let mut faults = Vec::new();
    for (name, text) in source::texts_below("src") {
        for (line, number) in text.lines().zip(1..) {
            let comment = line.trim_start().strip_prefix("//");
            let is_row =
                |comment: &str| comment.trim_start_matches(['/', '!', ' ']).starts_with('|');
            if line.chars().count() > MOST_COLUMNS && comment.is_some_and(|text| !is_row(text)) {
                faults.push(format!("{name}:{number}"));
            }
        }
    }
    assert!(faults.is_empty(), "wider: {}", faults.join(", "));
}

#[test]
fn no_function_grows_long() {
    let mut faults = Vec::new();
    for file in &Source::of_this_crate().files {
        let functions = functions::of(file.text_without_tests()).into_iter();
        let long = functions.filter(|function| function.lines > MOST_OF_A_FUNCTION);
        let fault =
            |long: Function| format!("{}: {} has {} lines", file.name, long.name, long.lines);
        faults.extend(long.map(fault));
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

fn faults_of(pattern: &regex_lite::Regex) -> Vec<String> {
    let prose = language::prose();
    assert!(prose.len() > 10_000, "pages and sources were not found");
    let found = prose.iter().filter(|prose| pattern.is_match(&prose.line));
    found
        .map(|prose| format!("{}: {}", prose.place, prose.line.trim()))
        .collect()
}

#[test]
fn the_words_are_those_of_the_glossary() {
    let replaced = language::replaced_words();
    assert!(replaced.len() > 10, "{replaced:?}");
    let faults = faults_of(&language::any_of(&replaced));
    assert!(
        faults.is_empty(),
        "docs/glossary.md has other words:\n{}",
        faults.join("\n")
    );
}

/// Quantities stand per unit: one label per texel.
#[test]
fn quantities_are_per_unit() {
    let faults = faults_of(&quantities_of_a_unit());
    assert!(faults.is_empty(), "per, not a:\n{}", faults.join("\n"));
}

/// Forms as "one label a texel", "3 an image", and "samples a pixel" at the end of a clause.
fn quantities_of_a_unit() -> regex_lite::Regex {
    let unit = "an? (texel|site|vertex|face|label|level|subcommand|pixel|frame|image|line|stage|view|light|row|\
                thread|triangle|file|pair)";
    let plural = "(samples|numbers|bytes|rays|texels|images|values|seconds|vertices)";
    let forms = [
        format!(r"\b(a|an|one|few) [a-z]+ {unit}\b"),
        format!(r"\b(one|[0-9]+) {unit}\b"),
        format!(r"\b{plural} {unit}[.:;,)]"),
    ];
    regex_lite::Regex::new(&format!("(?i){}", forms.join("|"))).unwrap()
}

#[test]
fn quantities_of_a_unit_are_found() {
    let pattern = quantities_of_a_unit();
    for fault in [
        "one label a texel",
        "RGB: 3 an image",
        "Samples a pixel.",
        "one a line",
    ] {
        assert!(pattern.is_match(fault), "{fault}");
    }
    for fine in [
        "samples per pixel",
        "how many samples a texel takes",
        "3 on a line",
    ] {
        assert!(!pattern.is_match(fine), "{fine}");
    }
}

/// Help texts end with their default as clap writes it: `[default: …]`.
#[test]
fn defaults_are_written_as_clap_does() {
    let mut faults = Vec::new();
    for file in Source::of_this_crate().files {
        let mut comment = String::new();
        for line in file.text.lines().map(str::trim) {
            match line.strip_prefix("///") {
                Some(text) => comment += text,
                None if line.starts_with("#[arg") && comment.contains("Default:") => {
                    faults.push(format!("{}:{comment}", file.name));
                }
                None if line.starts_with("#[") => {}
                None => comment.clear(),
            }
        }
    }
    assert!(faults.is_empty(), "[default: …]:\n{}", faults.join("\n"));
}
