//! The outcome of a command, as text for a person or as JSON.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use serde_json::{Map, Value, json};

/// A finished command: what it found, what it wrote, what to type next.
#[derive(Debug, Default)]
pub struct Outcome {
    /// Figures for a person, one per line.
    pub lines: Vec<String>,
    /// The same and more for a program: the fields of the `--json` report.
    pub figures: Map<String, Value>,
    /// Files and folders written.
    pub wrote: Vec<PathBuf>,
    /// Every file put into the folders among them.
    pub inside: Vec<PathBuf>,
    /// The command to type next.
    pub next: Option<String>,
}

impl Outcome {
    /// Adds a line for a person.
    #[must_use]
    pub fn line(mut self, line: impl Into<String>) -> Self {
        self.lines.push(line.into());
        self
    }

    /// Adds a field for a program.
    #[must_use]
    pub fn figure(mut self, name: &str, value: impl Into<Value>) -> Self {
        self.figures.insert(name.into(), value.into());
        self
    }

    /// Names a file or folder that was written.
    #[must_use]
    pub fn wrote(mut self, path: &Path) -> Self {
        self.wrote.push(path.to_path_buf());
        self
    }

    /// Names the files that were put into a folder.
    #[must_use]
    pub fn put_inside(mut self, paths: impl IntoIterator<Item = PathBuf>) -> Self {
        self.inside.extend(paths);
        self
    }

    /// Says which command comes next.
    #[must_use]
    pub fn next(mut self, command: impl Into<String>) -> Self {
        self.next = Some(command.into());
        self
    }

    /// The report a person reads.
    pub fn text(&self) -> String {
        let mut text = String::new();
        for line in &self.lines {
            let _ = writeln!(text, "{line}");
        }
        for path in &self.wrote {
            let _ = writeln!(text, "wrote {}", path.display());
        }
        if let Some(next) = &self.next {
            let _ = writeln!(text, "next: {next}");
        }
        text
    }

    /// The report a program reads.
    pub fn json(&self, warnings: &[String]) -> Value {
        let mut report = self.figures.clone();
        let wrote: Vec<_> = self
            .wrote
            .iter()
            .map(|path| path.to_string_lossy())
            .collect();
        report.insert("wrote".into(), json!(wrote));
        report.insert("warnings".into(), json!(warnings));
        Value::Object(report)
    }
}

/// The command that finds the textons of a whole sample.
pub fn next_textons(sample: &Path) -> String {
    format!(
        "mesotex textons {} -o {}",
        sample.display(),
        sample.with_extension("textons.npz").display()
    )
}
