//! What a user should know of how images were read, each matter once however many images share it.

use std::path::{Path, PathBuf};

use crate::progress::Progress;

/// Something about an image that does not keep it from being read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Note {
    /// The matter, the same for every image it concerns.
    pub subject: &'static str,
    /// What is so, in words.
    pub text: String,
}

impl Note {
    /// A note on a matter.
    pub fn new(subject: &'static str, text: impl Into<String>) -> Self {
        Self {
            subject,
            text: text.into(),
        }
    }

    /// A note where pixels per length across and down are not the same. Many writers state them without
    /// meaning it, so the image is read all the same.
    pub(super) fn of_resolution(across: f64, down: f64) -> Option<Self> {
        let differs = across > 0.0 && down > 0.0 && (across / down - 1.0).abs() > 0.005;
        differs.then(|| {
            let text = format!(
                "it states {across} pixels per length across and {down} down; pixels are taken as square"
            );
            Self::new("resolution", text)
        })
    }
}

/// The notes of many images.
#[derive(Debug, Default)]
pub struct Notes {
    /// The first image of each matter, its note, and how many more there are.
    matters: Vec<(PathBuf, Note, usize)>,
}

impl Notes {
    /// Adds the notes of one image.
    pub fn add(&mut self, path: &Path, notes: Vec<Note>) {
        for note in notes {
            let known = |(_, other, _): &&mut (PathBuf, Note, usize)| other.subject == note.subject;
            match self.matters.iter_mut().find(known) {
                Some((_, _, more)) => *more += 1,
                None => self.matters.push((path.to_path_buf(), note, 0)),
            }
        }
    }

    /// Tells the user, one warning for each matter.
    pub fn warn(&self, progress: Progress<'_>) {
        for (path, note, more) in &self.matters {
            let others = match more {
                0 => String::new(),
                1 => " (and so in 1 more image)".into(),
                more => format!(" (and so in {more} more images)"),
            };
            progress.warn(format!("{}: {}{others}", path.display(), note.text));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::Event;
    use std::sync::Mutex;

    #[test]
    fn a_matter_is_told_once() {
        let mut notes = Notes::default();
        for index in 0..3 {
            let path = format!("{index}.png");
            notes.add(
                Path::new(&path),
                vec![Note::new("alpha", format!("{index} texels"))],
            );
        }
        notes.add(Path::new("9.png"), vec![Note::new("gamut", "wide")]);
        let told = Mutex::new(Vec::new());
        let listener = |event| {
            if let Event::Warn(text) = event {
                told.lock().unwrap().push(text);
            }
        };
        notes.warn(Progress::new(&listener, None));
        assert_eq!(
            *told.lock().unwrap(),
            ["0.png: 0 texels (and so in 2 more images)", "9.png: wide"]
        );
    }
}
