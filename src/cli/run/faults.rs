//! What is wrong with a scene: all of it at once, each fault with its line.

use std::path::Path;

use crate::error::{Error, Result};

/// The faults found so far.
#[derive(Debug, Default)]
pub struct Faults {
    lines: Vec<(usize, String)>,
    usage: bool,
}

/// Where a fault is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// The line of the scene, from 1; 0 for the scene as a whole.
    pub line: usize,
    /// Section and key in words, as `[knn] k`; may be empty.
    pub name: String,
}

impl Place {
    /// A line of the scene.
    pub fn new(line: usize, name: impl Into<String>) -> Self {
        Self {
            line,
            name: name.into(),
        }
    }
}

impl Faults {
    /// A fault of the file: what it holds is not a scene.
    pub fn data(&mut self, place: &Place, says: impl AsRef<str>) {
        let line = match place.line {
            0 => String::new(),
            line => format!("line {line}: "),
        };
        let name = match place.name.as_str() {
            "" => String::new(),
            name => format!("{name}: "),
        };
        let fault = (place.line, format!("{line}{name}{}", says.as_ref()));
        if !self.lines.contains(&fault) {
            self.lines.push(fault);
        }
    }

    /// A fault of usage: an option that the stage's command does not take.
    pub fn option(&mut self, place: &Place, says: impl AsRef<str>) {
        self.usage = true;
        self.data(place, says);
    }

    /// What a command said against its part of the scene.
    pub fn error(&mut self, place: &Place, error: &Error) {
        match error {
            Error::Option { .. } => self.option(place, error.to_string()),
            other => self.data(place, other.to_string()),
        }
    }

    /// Whether none was found.
    pub fn is_empty(&self) -> bool {
        self.lines.is_empty()
    }

    /// All faults as one error, in the order of their lines.
    pub fn into_result(mut self, scene: &Path) -> Result<()> {
        if self.is_empty() {
            return Ok(());
        }
        self.lines.sort_by_key(|(line, _)| *line);
        Err(Error::Faults {
            path: scene.to_path_buf(),
            lines: self.lines.into_iter().map(|(_, text)| text).collect(),
            usage: self.usage,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faults_come_in_the_order_of_their_lines() {
        let mut faults = Faults::default();
        faults.data(&Place::new(9, "[knn] k"), "no number");
        faults.option(&Place::new(2, ""), "twice");
        faults.option(&Place::new(2, ""), "twice");
        let error = faults.into_result(Path::new("scene.toml")).unwrap_err();
        assert_eq!(
            error.to_string(),
            "scene.toml: 2 faults\n  line 2: twice\n  line 9: [knn] k: no number"
        );
        assert!(matches!(error, Error::Faults { usage: true, .. }));
    }
}
