//! A stage before its options are parsed: a command, its files and the keys of its section.

use std::path::{Path, PathBuf};

use toml::Value;

use crate::cli::run::document::{Key, Section};

/// One stage before its options are parsed: a command, its files, and the section of its options.
#[derive(Clone, Debug, PartialEq)]
pub struct Draft {
    /// What the user reads: the command, and for renderings their name.
    pub name: String,
    /// The command.
    pub command: &'static str,
    /// The key of the section that names the inputs; empty where other stages make them.
    pub input_key: &'static str,
    /// Its inputs.
    pub inputs: Vec<PathBuf>,
    /// Its output.
    pub output: PathBuf,
    /// Its options.
    pub section: Section,
    /// Its seed, where it is not that of the whole run.
    pub seed: Option<u64>,
    /// The values of `[matrix]` that reach it, as names of outputs state them.
    pub variant: String,
}

impl Draft {
    /// The command line, without the program and without the options in `left_out`.
    pub fn words(&self, left_out: &[String]) -> Vec<String> {
        let mut words = vec![self.command.to_owned()];
        words.extend(self.inputs.iter().map(|path| path_word(path)));
        words.extend(["-o".into(), path_word(&self.output)]);
        for key in self.options().filter(|key| !left_out.contains(&key.name)) {
            push_option(&mut words, &key.name, &key.value);
        }
        words
    }

    /// The keys that are options of the command.
    pub fn options(&self) -> impl Iterator<Item = &Key> {
        let own = [
            self.input_key,
            if self.command == "render" { "name" } else { "" },
            "seed",
        ];
        self.section
            .keys
            .iter()
            .filter(move |key| !own.contains(&key.name.as_str()))
    }
}

/// A path as a word of a command line: one that begins with `-` is no option.
pub(in crate::cli) fn path_word(path: &Path) -> String {
    let text = path.to_string_lossy();
    match text.starts_with('-') {
        true => format!("./{text}"),
        false => text.into_owned(),
    }
}

fn push_option(words: &mut Vec<String>, key: &str, value: &Value) {
    match value {
        Value::Boolean(true) => words.push(format!("--{key}")),
        Value::Boolean(false) => {}
        Value::String(text) => words.push(format!("--{key}={text}")),
        Value::Array(values) => values
            .iter()
            .for_each(|value| push_option(words, key, value)),
        other => words.push(format!("--{key}={other}")),
    }
}
