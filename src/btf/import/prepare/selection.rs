//! A choice of directions: by their numbers, or by how far they lie from the normal.

use std::fmt;
use std::str::FromStr;

use serde::Serialize;

use crate::btf::direction::Direction;

/// Degrees that a direction may lie beyond a stated angle.
const TOLERANCE_DEG: f64 = 1e-6;
/// What a choice may be.
const FORMS: &str = "numbers from 0 and ranges, as 0,4-11, or theta:60 in degrees";

/// Directions that are kept: those that one of the items names.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(into = "String")]
pub struct Selection(Vec<Item>);

#[derive(Clone, Copy, Debug, PartialEq)]
enum Item {
    /// From one number to another, both kept.
    Range(usize, usize),
    /// Not further from the normal, in degrees.
    Within(f64),
}

impl Selection {
    /// Whether the direction of a number is kept.
    pub(in crate::btf::import) fn keeps(&self, number: usize, direction: Direction) -> bool {
        self.0.iter().any(|item| match *item {
            Item::Range(first, last) => (first..=last).contains(&number),
            Item::Within(theta) => direction.theta().to_degrees() <= theta + TOLERANCE_DEG,
        })
    }

    /// A number of the choice that `count` directions do not have.
    pub(in crate::btf::import) fn beyond(&self, count: usize) -> Option<usize> {
        let lasts = self.0.iter().filter_map(|item| match *item {
            Item::Range(_, last) => Some(last),
            Item::Within(_) => None,
        });
        lasts.filter(|&last| last >= count).max()
    }
}

impl FromStr for Item {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let fault = || format!("`{text}`: expected {FORMS}");
        if let Some(theta) = text.strip_prefix("theta:") {
            let theta = theta
                .parse()
                .ok()
                .filter(|theta| (0.0..=90.0).contains(theta));
            return theta.map(Self::Within).ok_or_else(fault);
        }
        let (first, last) = text.split_once('-').unwrap_or((text, text));
        match (first.parse(), last.parse()) {
            (Ok(first), Ok(last)) if first <= last => Ok(Self::Range(first, last)),
            _ => Err(fault()),
        }
    }
}

impl fmt::Display for Item {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Range(first, last) if first == last => write!(f, "{first}"),
            Self::Range(first, last) => write!(f, "{first}-{last}"),
            Self::Within(theta) => write!(f, "theta:{theta}"),
        }
    }
}

impl FromStr for Selection {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let items = text.split(',').map(|item| item.trim().parse());
        items.collect::<Result<_, _>>().map(Self)
    }
}

impl fmt::Display for Selection {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let items: Vec<String> = self.0.iter().map(Item::to_string).collect();
        f.write_str(&items.join(","))
    }
}

impl From<Selection> for String {
    fn from(selection: Selection) -> Self {
        selection.to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_are_kept_by_number_and_angle() {
        let selection: Selection = "0, 4-6,theta:30".parse().unwrap();
        assert_eq!(selection.to_string(), "0,4-6,theta:30");
        let at = |degrees: f64| Direction::from_angles(degrees.to_radians(), 1.0);
        let kept: Vec<usize> = (0..9).filter(|&n| selection.keeps(n, at(80.0))).collect();
        assert_eq!(kept, [0, 4, 5, 6]);
        assert!(selection.keeps(8, at(30.0)) && !selection.keeps(8, at(30.1)));
        assert_eq!((selection.beyond(7), selection.beyond(6)), (None, Some(6)));
    }

    #[test]
    fn other_words_are_refused() {
        for text in ["", "x", "5-3", "theta:95", "theta:nan", "1,,2", "-1"] {
            let error = text.parse::<Selection>().unwrap_err();
            assert!(error.contains("theta:60"), "{text}: {error}");
        }
    }
}
