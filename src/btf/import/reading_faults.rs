//! Images that cannot be used: all of them are reported, not only the first.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use crate::error::{Error, Result};

/// Width and height.
type Size = (u32, u32);

/// What is wrong with the images of a set.
#[derive(Debug, Default)]
pub(super) struct ReadingFaults {
    errors: Vec<Error>,
    sizes: BTreeMap<PathBuf, Size>,
    /// The size of the image that was read first.
    first: Option<Size>,
}

impl ReadingFaults {
    /// An image was read; whether it has the size of the first.
    pub(super) fn add_size(&mut self, path: &Path, size: Size) -> bool {
        self.sizes.insert(path.to_path_buf(), size);
        *self.first.get_or_insert(size) == size
    }

    /// An image could not be read. An option at fault, or an interruption, is handed back: no other image
    /// could tell more.
    pub(super) fn add(&mut self, error: Error) -> Result<()> {
        match error {
            Error::Data(_) | Error::Io { .. } => {
                self.errors.push(error);
                Ok(())
            }
            other => Err(other),
        }
    }

    /// Nothing, or all faults: a single one as it is.
    pub(super) fn into_result(mut self, source: &Path) -> Result<()> {
        let usual = self.usual_size();
        for (path, size) in &self.sizes {
            if Some(*size) != usual {
                self.errors
                    .push(of_size(path, *size, usual.unwrap_or(*size)));
            }
        }
        // An image from which others are interpolated is read more than once.
        let mut lines: Vec<String> = Vec::new();
        for line in self.errors.iter().map(first_line) {
            if !lines.contains(&line) {
                lines.push(line);
            }
        }
        match lines.len() {
            0 => Ok(()),
            1 => self.errors.pop().map_or(Ok(()), Err),
            _ => Err(Error::Faults {
                path: source.to_path_buf(),
                lines,
                usage: false,
            }),
        }
    }

    /// The size that most images have; of equally frequent ones that of the first image.
    fn usual_size(&self) -> Option<Size> {
        let mut counts: BTreeMap<Size, usize> = BTreeMap::new();
        for size in self.sizes.values() {
            *counts.entry(*size).or_default() += 1;
        }
        let rank = |(size, count): &(Size, usize)| (*count, Some(*size) == self.first);
        counts.into_iter().max_by_key(rank).map(|(size, _)| size)
    }
}

fn of_size(path: &Path, found: Size, usual: Size) -> Error {
    Error::data("size", format!("{} × {}", found.0, found.1))
        .expected(format!("{} × {}, as the other images", usual.0, usual.1))
        .advice("the images of a sample are rectified to one texel grid")
        .in_file(path)
}

/// An error without its hint.
fn first_line(error: &Error) -> String {
    let text = error.to_string();
    text.lines().next().unwrap_or_default().to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_image_at_fault_is_told() {
        let mut faults = ReadingFaults::default();
        for (name, size) in [("a", (5, 5)), ("b", (8, 6)), ("c", (8, 6))] {
            faults.add_size(Path::new(name), size);
        }
        let broken = Error::data("image", "cut off").in_file(Path::new("d"));
        faults.add(broken).unwrap();
        let error = faults
            .into_result(Path::new("set"))
            .unwrap_err()
            .to_string();
        assert!(error.starts_with("set: 2 faults"), "{error}");
        assert!(error.contains("d: image: cut off"), "{error}");
        assert!(error.contains("a: size: 5 × 5; expected 8 × 6"), "{error}");
        assert!(!error.contains("hint"), "{error}");
    }

    #[test]
    fn a_single_fault_is_told_as_it_is() {
        let mut faults = ReadingFaults::default();
        faults.add_size(Path::new("a"), (5, 5));
        assert!(!faults.add_size(Path::new("b"), (1, 2)));
        let error = faults
            .into_result(Path::new("set"))
            .unwrap_err()
            .to_string();
        assert!(
            error.starts_with("b: size: 1 × 2") && error.contains("hint"),
            "{error}"
        );
        assert!(
            ReadingFaults::default()
                .into_result(Path::new("set"))
                .is_ok()
        );
        let option = Error::option("crop", "x", "y");
        assert!(ReadingFaults::default().add(option).is_err());
    }
}
