//! Which frames of a sweep are made, and what their files are called.

use std::fmt;
use std::str::FromStr;

use serde::Serialize;

use crate::error::{Error, Result};

/// Frame numbers: `24` is 1 to 24, `10-20` and `1-240x2` (every second) pick from a longer sweep.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(into = "String")]
pub struct FrameRange {
    first: u32,
    last: u32,
    step: u32,
    /// Whether it was given as a mere count.
    is_count: bool,
}

/// Frames of one run at most: camera and lights of all are planned before the first is made.
const MOST_FRAMES: u32 = 100_000;
/// The largest number of a frame, and of frames of a sweep.
pub const LAST_FRAME: u32 = 9_999_999;

impl From<FrameRange> for String {
    fn from(range: FrameRange) -> Self {
        range.to_string()
    }
}

impl FrameRange {
    /// Frames 1 to `count`.
    pub fn count(count: u32) -> Self {
        Self {
            first: 1,
            last: count,
            step: 1,
            is_count: true,
        }
    }

    /// The frame numbers, rising.
    pub fn numbers(self) -> impl Iterator<Item = u32> + Clone {
        (self.first..=self.last).step_by(self.step as usize)
    }

    /// The length of the sweep when nothing else says it: the range's end.
    pub fn last(self) -> u32 {
        self.last
    }
}

impl FromStr for FrameRange {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let number = |part: &str| {
            part.trim()
                .parse::<u32>()
                .map_err(|_| format!("`{text}` is neither a count nor a range as 1-240 or 1-240x2"))
        };
        // Read the range and its step.
        let (range, step) = match text.split_once('x') {
            Some((range, step)) => (range, number(step)?),
            None => (text, 1),
        };
        let (first, last, is_count) = match range.split_once('-') {
            Some((first, last)) => (number(first)?, number(last)?, false),
            None => (1, number(range)?, true),
        };
        // Check them.
        if last == 0 {
            return Err("no frame is asked for".into());
        }
        if last > LAST_FRAME {
            return Err(format!(
                "`{text}` goes beyond frame {LAST_FRAME}, the last number a sweep may have"
            ));
        }
        if first == 0 || first > last || step == 0 {
            return Err(format!(
                "`{text}` is not a range: frames count from 1, steps are 1 or more"
            ));
        }
        let count = (last - first) / step + 1;
        if count > MOST_FRAMES {
            return Err(format!(
                "`{text}` are {count} frames; at most {MOST_FRAMES} are planned in one run: give a range"
            ));
        }
        Ok(Self {
            first,
            last,
            step,
            is_count: is_count && step == 1,
        })
    }
}

impl fmt::Display for FrameRange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.is_count {
            return write!(f, "{}", self.last);
        }
        write!(f, "{}-{}", self.first, self.last)?;
        if self.step > 1 {
            write!(f, "x{}", self.step)?;
        }
        Ok(())
    }
}

/// File names with the frame's number in place of a run of `#`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(transparent)]
pub struct FramePattern(pub String);

impl Default for FramePattern {
    fn default() -> Self {
        Self("frame.####".into())
    }
}

impl FromStr for FramePattern {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        Ok(Self(text.into()))
    }
}

impl fmt::Display for FramePattern {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl FramePattern {
    /// Refuses patterns that cannot name all frames up to `last`.
    pub fn check(&self, frames: usize, last: u32) -> Result<()> {
        let fault =
            |expected: String| Err(Error::option("pattern", format!("`{}`", self.0), expected));
        if self.0.is_empty() || self.0.contains(['/', '\\']) {
            return fault("a file name without folders, as frame.####".into());
        }
        let room = self.0.matches('#').count();
        if room == 0 && frames > 1 {
            return fault(format!("room for {frames} frame numbers, as frame.####"));
        }
        let digits = last.to_string().len();
        if room > 0 && room < digits {
            return fault(format!("at least {digits} # for frame {last}"));
        }
        if room != self.run().len() {
            return fault("one run of #".into());
        }
        Ok(())
    }

    fn run(&self) -> &str {
        let from = self.0.find('#').unwrap_or(self.0.len());
        let rest = &self.0[from..];
        &rest[..rest.find(|c| c != '#').unwrap_or(rest.len())]
    }

    /// The name of a frame's files, without an ending.
    pub fn stem(&self, number: u32) -> String {
        let run = self.run();
        if run.is_empty() {
            return self.0.clone();
        }
        self.0
            .replacen(run, &format!("{number:0width$}", width = run.len()), 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn numbers(text: &str) -> Vec<u32> {
        text.parse::<FrameRange>().unwrap().numbers().collect()
    }

    #[test]
    fn counts_and_ranges() {
        assert_eq!(numbers("3"), [1, 2, 3]);
        assert_eq!(numbers("5-7"), [5, 6, 7]);
        assert_eq!(numbers("1-8x3"), [1, 4, 7]);
        for (text, says) in [
            ("0", "no frame"),
            ("7-5", "range"),
            ("a", "neither"),
            ("1-4x0", "range"),
        ] {
            let error = text.parse::<FrameRange>().unwrap_err();
            assert!(error.contains(says), "{error}");
        }
        for text in ["24", "5-7", "1-240x2"] {
            assert_eq!(text.parse::<FrameRange>().unwrap().to_string(), text);
        }
    }

    #[test]
    fn patterns_need_room_for_the_number() {
        let pattern = FramePattern::default();
        assert_eq!(pattern.stem(7), "frame.0007");
        assert!(pattern.check(24, 24).is_ok());
        let refused = |text: &str, frames, last| {
            let error = FramePattern(text.into()).check(frames, last).unwrap_err();
            error.to_string()
        };
        assert!(refused("frame", 2, 2).contains("room for 2"));
        assert!(refused("f#", 10, 10).contains("at least 2 #"));
        assert!(refused("a/#", 1, 1).contains("folders"));
        assert!(refused("#a#", 1, 1).contains("one run"));
        assert!(FramePattern("still".into()).check(1, 1).is_ok());
    }
}
