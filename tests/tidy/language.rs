//! The words of docs/glossary.md: those of its last column stand in no page, help text, message or comment.

use std::fs;
use std::path::{Path, PathBuf};

use regex_lite::Regex;

/// A text that people read, with where it stands.
pub struct Prose {
    /// File and line.
    pub place: String,
    /// One line of it.
    pub line: String,
}

/// The words that the glossary's tables replace.
pub fn replaced_words() -> Vec<String> {
    let glossary = fs::read_to_string(root().join("docs/glossary.md")).unwrap();
    let rows = glossary.lines().filter(|line| line.starts_with("| "));
    let cells = rows.map(|row| row.trim_matches('|').split('|').map(str::trim).collect());
    let instead = cells.map(|cells: Vec<&str>| {
        assert_eq!(cells.len(), 3, "docs/glossary.md: {cells:?}");
        cells[2].to_owned()
    });
    instead
        .filter(|words| !["not", "---"].contains(&words.as_str()))
        .flat_map(|words| words.split(", ").map(str::to_owned).collect::<Vec<_>>())
        .filter(|word| !word.is_empty())
        .collect()
}

/// Any of some words, whole, in upper or lower case.
pub fn any_of(words: &[String]) -> Regex {
    let words: Vec<String> = words.iter().map(|word| regex_lite::escape(word)).collect();
    Regex::new(&format!(r"(?i)\b({})\b", words.join("|"))).unwrap()
}

/// Lines of the pages, the glossary apart, and the comments and literals of the sources.
pub fn prose() -> Vec<Prose> {
    let mut all = Vec::new();
    let pages = files_below(&root().join("docs"), "md");
    for page in pages.into_iter().chain([root().join("README.md")]) {
        if !page.ends_with("glossary.md") {
            collect(&page, |line| line.to_owned(), &mut all);
        }
    }
    for source in files_below(&root().join("src"), "rs") {
        collect(&source, comment_and_literals, &mut all);
    }
    all
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn collect(file: &Path, readable: impl Fn(&str) -> String, all: &mut Vec<Prose>) {
    let name = file.strip_prefix(root()).unwrap().display();
    let text = fs::read_to_string(file).unwrap();
    all.extend(text.lines().enumerate().map(|(at, line)| Prose {
        place: format!("{name}:{}", at + 1),
        line: readable(line),
    }));
}

/// What people read of a line of code: its comment, and what stands in quotes.
fn comment_and_literals(line: &str) -> String {
    let (code, comment) = line.split_once("//").unwrap_or((line, ""));
    let literals: Vec<&str> = code.split('"').skip(1).step_by(2).collect();
    // A line without code signs continues a literal.
    let is_continued = !code.trim().is_empty() && code.trim_end().ends_with('\\');
    let continued = if is_continued { code } else { "" };
    format!("{} {continued} {comment}", literals.join(" "))
}

fn files_below(folder: &Path, ending: &str) -> Vec<PathBuf> {
    let mut files = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            files.extend(files_below(&path, ending));
        } else if path.extension().is_some_and(|found| found == ending) {
            files.push(path);
        }
    }
    files.sort();
    files
}
