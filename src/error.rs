//! The one error type of the crate: what was wrong, where, and who must act.
//!
//! Three kinds, by who must act: the *data* (a file or array does not hold what it should), an
//! *option* (the caller asked for something impossible), the *machine* (reading, writing, memory).

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

/// The result of every fallible function of the crate.
pub type Result<T> = std::result::Result<T, Error>;

/// Why a step could not do its job.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The data is at fault: a file, a field of it, or an array handed to the library.
    #[error("{0}")]
    Data(Box<DataFault>),
    /// An option is at fault; `option` is the name of its flag and its field.
    #[error("--{option}: {found}; expected {expected}")]
    Option {
        /// Flag and field name, without dashes.
        option: String,
        /// What was asked.
        found: String,
        /// What would do.
        expected: String,
    },
    /// The machine is at fault: a file could not be read or written.
    #[error("{}: cannot {action}: {source}", path.display())]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// The verb, as in "cannot *read*".
        action: &'static str,
        /// The system's own word.
        source: io::Error,
    },
    /// Several faults of one file, found together.
    #[error("{}: {}", path.display(), listed(lines))]
    Faults {
        /// The file.
        path: PathBuf,
        /// A fault in each, with its place.
        lines: Vec<String>,
        /// Whether options are among them.
        usage: bool,
    },
    /// The caller asked to stop (Ctrl-C); no half-written file is left under a final name.
    #[error("interrupted")]
    Interrupted,
}

/// One fault as it stands, several below their number.
fn listed(lines: &[String]) -> String {
    match lines {
        [only] => only.clone(),
        _ => format!("{} faults\n  {}", lines.len(), lines.join("\n  ")),
    }
}

/// What a file or array holds against what it should hold.
#[derive(Debug, Default)]
pub struct DataFault {
    /// The file, where one is known.
    pub path: Option<PathBuf>,
    /// Field, line, index: where in the file or array.
    pub place: String,
    /// What is there.
    pub found: String,
    /// What should be there; may be empty when `found` says it all.
    pub expected: String,
    /// What the user can do; may be empty.
    pub advice: String,
}

impl fmt::Display for DataFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(path) = &self.path {
            write!(f, "{}: ", path.display())?;
        }
        if !self.place.is_empty() {
            write!(f, "{}: ", self.place)?;
        }
        write!(f, "{}", self.found)?;
        if !self.expected.is_empty() {
            write!(f, "; expected {}", self.expected)?;
        }
        if !self.advice.is_empty() {
            write!(f, "\n  hint: {}", self.advice)?;
        }
        Ok(())
    }
}

impl Error {
    /// A data fault at `place`; add the rest with [`expected`](Self::expected),
    /// [`advice`](Self::advice) and [`in_file`](Self::in_file).
    pub fn data(place: impl Into<String>, found: impl Into<String>) -> Self {
        Self::Data(Box::new(DataFault {
            place: place.into(),
            found: found.into(),
            ..DataFault::default()
        }))
    }

    /// An option that cannot be met.
    pub fn option(
        option: impl Into<String>,
        found: impl Into<String>,
        expected: impl Into<String>,
    ) -> Self {
        Self::Option {
            option: option.into(),
            found: found.into(),
            expected: expected.into(),
        }
    }

    /// A failed system call on `path`; for `map_err`.
    pub fn io(path: &Path, action: &'static str) -> impl FnOnce(io::Error) -> Self + use<> {
        let path = path.to_path_buf();
        move |source| Self::Io {
            path,
            action,
            source,
        }
    }

    /// Says what a data fault should have found instead.
    #[must_use]
    pub fn expected(mut self, expected: impl Into<String>) -> Self {
        if let Self::Data(fault) = &mut self {
            fault.expected = expected.into();
        }
        self
    }

    /// Says what the user can do about a data fault.
    #[must_use]
    pub fn advice(mut self, advice: impl Into<String>) -> Self {
        if let Self::Data(fault) = &mut self {
            fault.advice = advice.into();
        }
        self
    }

    /// Names the file of a data fault, unless it is named already.
    #[must_use]
    pub fn in_file(mut self, path: &Path) -> Self {
        if let Self::Data(fault) = &mut self {
            fault.path.get_or_insert_with(|| path.to_path_buf());
        }
        self
    }
}
