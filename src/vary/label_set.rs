//! Which labels of a mask an operation works on.

use std::fmt;
use std::str::FromStr;

use crate::exemplar::controls::MASK_LABELS;

/// A set of the labels 0 to 3.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LabelSet([bool; MASK_LABELS as usize]);

impl LabelSet {
    /// Every label but 0, which marks what is no feature.
    pub const FEATURES: Self = Self([false, true, true, true]);

    /// A set of one label.
    pub fn of(label: u8) -> Self {
        let mut set = [false; MASK_LABELS as usize];
        set[usize::from(label % MASK_LABELS)] = true;
        Self(set)
    }

    /// Whether a label belongs to it.
    pub fn has(self, label: u8) -> bool {
        self.0.get(usize::from(label)).copied().unwrap_or(false)
    }
}

impl Default for LabelSet {
    fn default() -> Self {
        Self::FEATURES
    }
}

impl FromStr for LabelSet {
    type Err = String;

    /// Reads labels joined by `+`, as `1+2`.
    fn from_str(text: &str) -> Result<Self, String> {
        let mut set = [false; MASK_LABELS as usize];
        for part in text.split('+') {
            match part.trim().parse::<u8>() {
                Ok(label) if label < MASK_LABELS => set[usize::from(label)] = true,
                _ => return Err(format!("`{part}`; expected labels 0 to 3, as 1+2")),
            }
        }
        match set.iter().all(|&has| has) {
            true => Err("all labels; expected some, for the others surround them".into()),
            false => Ok(Self(set)),
        }
    }
}

impl fmt::Display for LabelSet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let labels = (0..MASK_LABELS).filter(|&label| self.has(label));
        let labels: Vec<String> = labels.map(|label| label.to_string()).collect();
        write!(f, "{}", labels.join("+"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sets_are_read_as_they_are_shown() {
        for text in ["1", "1+2", "0+3"] {
            assert_eq!(text.parse::<LabelSet>().unwrap().to_string(), text);
        }
        assert_eq!(LabelSet::default().to_string(), "1+2+3");
        for wrong in ["", "4", "1+", "a", "0+1+2+3"] {
            assert!(wrong.parse::<LabelSet>().is_err(), "{wrong}");
        }
    }
}
