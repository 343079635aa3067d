//! The crate's source as a tree of modules: each file, the module it is, and the paths it names outside
//! its tests.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use regex_lite::Regex;

use crate::paths::{Named, Paths, tokens};

/// A file of the source.
pub struct SourceFile {
    /// Its path below `src`, with `/`.
    pub name: String,
    /// Its text.
    pub text: String,
    /// Whether it is compiled for tests alone.
    is_test: bool,
    /// The module it is: the names from the crate's root on.
    module: Vec<String>,
    named: Paths,
}

impl SourceFile {
    /// Its text up to its module of tests; none of it where it is compiled for tests alone.
    pub fn text_without_tests(&self) -> &str {
        let tests = Regex::new(r"#\[cfg\(test\)\]\n(?:pub(?:\([a-z]+\))? )?mod \w+ \{").unwrap();
        let end = tests.find(&self.text).map(|found| found.start());
        match self.is_test {
            true => "",
            false => &self.text[..end.unwrap_or(self.text.len())],
        }
    }
}

/// All files.
pub struct Source {
    /// In order of their names.
    pub files: Vec<SourceFile>,
}

impl Source {
    /// Reads the source of this crate.
    pub fn of_this_crate() -> Self {
        let source = Self::of_texts(texts_below("src"));
        assert!(source.files.len() > 30, "the source was not found");
        source
    }

    /// The source whose files have these names and texts.
    pub fn of_texts(texts: impl IntoIterator<Item = (String, String)>) -> Self {
        let file = |(name, text): (String, String)| SourceFile {
            module: module_of(&name),
            is_test: false,
            named: Paths::of(&tokens(&text)),
            name,
            text,
        };
        let mut files: Vec<SourceFile> = texts.into_iter().map(file).collect();
        files.sort_by(|a, b| a.name.cmp(&b.name));
        let tests: BTreeSet<Vec<String>> = files
            .iter()
            .flat_map(|file| {
                let below = |name: &String| [&file.module[..], std::slice::from_ref(name)].concat();
                file.named.test_modules.iter().map(below)
            })
            .collect();
        for file in &mut files {
            file.is_test = tests.iter().any(|module| file.module.starts_with(module));
        }
        Self { files }
    }

    /// What a file names of the crate, as paths from the root on.
    fn named_by<'a>(
        &'a self,
        file: &'a SourceFile,
    ) -> impl Iterator<Item = (&'a Named, Vec<String>)> {
        let resolved = |named: &'a Named| Some((named, self.resolve(file, named)?));
        file.named.paths.iter().filter_map(resolved)
    }

    /// The rooms a file names: the first part of every path.
    pub fn rooms_named_by(&self, file: &SourceFile) -> BTreeSet<String> {
        let paths = self.named_by(file).map(|(_, path)| path);
        paths.filter_map(|path| path.into_iter().next()).collect()
    }

    /// The room a file lies in.
    pub fn room_of(file: &SourceFile) -> &str {
        let first = file.name.split('/').next().unwrap();
        first.trim_end_matches(".rs")
    }

    /// Every file, tests apart, with the files that its `use` declarations lead to, itself apart.
    pub fn uses(&self) -> BTreeMap<&str, BTreeSet<&str>> {
        let of_file = |file| {
            let used = self.named_by(file).filter(|(named, _)| named.in_use);
            let files = used.filter_map(|(_, path)| self.file_of(&path));
            let others = files.filter(|other: &&str| *other != file.name);
            (file.name.as_str(), others.collect())
        };
        let files = self.files.iter().filter(|file| !file.is_test);
        files.map(of_file).collect()
    }

    /// A path from the crate's root on; `None` for one that leads to another crate.
    fn resolve(&self, file: &SourceFile, named: &Named) -> Option<Vec<String>> {
        let mut from = [&file.module[..], &named.within[..]].concat();
        let mut rest = &named.path[..];
        match rest.first()?.as_str() {
            "crate" => from.clear(),
            "self" => {}
            "super" => {
                while rest.first().is_some_and(|name| name == "super") {
                    from.pop()?;
                    rest = &rest[1..];
                }
                return Some([&from[..], rest].concat());
            }
            child => {
                from.push(child.to_owned());
                let is_module = self.files.iter().any(|file| file.module == from);
                return is_module.then(|| [&from[..], &rest[1..]].concat());
            }
        }
        Some([&from[..], &rest[1..]].concat())
    }

    /// The file whose module is the longest beginning of a path.
    fn file_of(&self, path: &[String]) -> Option<&str> {
        let holds = self
            .files
            .iter()
            .filter(|file| path.starts_with(&file.module));
        let deepest = holds.max_by_key(|file| file.module.len())?;
        (!deepest.module.is_empty()).then_some(deepest.name.as_str())
    }
}

/// The Rust files in a folder of this crate: their paths below it, with `/`, and their texts.
pub fn texts_below(folder: &str) -> impl Iterator<Item = (String, String)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
    rust_files(&root).into_iter().map(move |path| {
        let below = path.strip_prefix(&root).unwrap();
        let names: Vec<_> = below.iter().map(|name| name.to_str().unwrap()).collect();
        (names.join("/"), fs::read_to_string(&path).unwrap())
    })
}

fn rust_files(root: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
    let mut folders = vec![root.to_path_buf()];
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
    files
}

fn module_of(name: &str) -> Vec<String> {
    let mut names: Vec<String> = name
        .trim_end_matches(".rs")
        .split('/')
        .map(str::to_owned)
        .collect();
    if matches!(
        names.last().map(String::as_str),
        Some("mod" | "lib" | "main")
    ) {
        names.pop();
    }
    names
}
