//! A rectangle of an image: `WIDTHxHEIGHT+LEFT+TOP`, in pixels from the top left corner.

use std::fmt;
use std::str::FromStr;

use serde::Serialize;

use crate::error::{Error, Result};

/// Whole pixels of an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(into = "String")]
pub struct Region {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Its first column.
    pub left: u32,
    /// Its first row.
    pub top: u32,
}

impl Region {
    /// Refuses a region that an image does not hold.
    pub(crate) fn check_inside(&self, option: &str, (width, height): (u32, u32)) -> Result<()> {
        let ends = |first: u32, length: u32| u64::from(first) + u64::from(length);
        let is_inside = ends(self.left, self.width) <= u64::from(width)
            && ends(self.top, self.height) <= u64::from(height);
        match is_inside {
            true => Ok(()),
            false => Err(Error::option(
                option,
                format!("{self} in images of {width} × {height}"),
                "a rectangle inside the images",
            )),
        }
    }

    /// The rows of a region in an image of `width` texels per row, each as a range of texels.
    pub(crate) fn rows(self, width: u32) -> impl Iterator<Item = std::ops::Range<usize>> {
        let (left, width) = (self.left as usize, width as usize);
        let rows = self.top as usize..(self.top + self.height) as usize;
        rows.map(move |row| row * width + left..row * width + left + self.width as usize)
    }
}

impl FromStr for Region {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let fault =
            || format!("`{text}`: expected WIDTHxHEIGHT+LEFT+TOP in pixels, as 256x256+40+60");
        let (size, place) = text.split_once('+').ok_or_else(fault)?;
        let (width, height) = size.split_once('x').ok_or_else(fault)?;
        let (left, top) = place.split_once('+').ok_or_else(fault)?;
        let number = |text: &str| text.parse::<u32>().ok().filter(|&n| n < 1 << 24);
        let numbers = [width, height, left, top].map(number);
        match numbers {
            [Some(width), Some(height), Some(left), Some(top)] if width > 0 && height > 0 => {
                Ok(Self {
                    width,
                    height,
                    left,
                    top,
                })
            }
            _ => Err(fault()),
        }
    }
}

impl fmt::Display for Region {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            width,
            height,
            left,
            top,
        } = self;
        write!(f, "{width}x{height}+{left}+{top}")
    }
}

impl From<Region> for String {
    fn from(region: Region) -> Self {
        region.to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn regions_round_trip() {
        let region: Region = "4x3+1+2".parse().unwrap();
        assert_eq!(
            region,
            Region {
                width: 4,
                height: 3,
                left: 1,
                top: 2
            }
        );
        assert_eq!(region.to_string(), "4x3+1+2");
        assert_eq!(region.rows(10).next(), Some(21..25));
        assert_eq!(region.rows(10).count(), 3);
        for text in [
            "",
            "4x3",
            "0x3+1+2",
            "4x3+1",
            "4x3+-1+2",
            "ax3+1+2",
            "4x3+99999999+0",
        ] {
            assert!(
                text.parse::<Region>().unwrap_err().contains("WIDTHxHEIGHT"),
                "{text}"
            );
        }
    }

    #[test]
    fn regions_lie_inside_their_images() {
        let region: Region = "4x3+1+2".parse().unwrap();
        assert!(region.check_inside("crop", (5, 5)).is_ok());
        let error = region.check_inside("crop", (5, 4)).unwrap_err().to_string();
        assert!(
            error.contains("--crop: 4x3+1+2 in images of 5 × 4"),
            "{error}"
        );
    }
}
