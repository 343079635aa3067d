//! What the progressive method can be asked beside what every method can.

use std::fmt;
use std::str::FromStr;

use serde::{Serialize, Serializer};

use crate::error::{Error, Result};
use crate::synthesis::own_options::OwnOptions;

/// The widest window, in texels.
const WIDEST: u32 = 31;
/// The largest weight of the mask.
const MOST_MASK_WEIGHT: f64 = 1e6;

/// The width of a window that grows with the transition: where the transition is 0, and where it is 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Widths {
    /// Where the transition is 0.
    pub first: u32,
    /// Where it is 1.
    pub last: u32,
}

impl Widths {
    /// The same width everywhere.
    pub const fn constant(width: u32) -> Self {
        Self {
            first: width,
            last: width,
        }
    }

    /// The larger of both.
    pub fn widest(self) -> u32 {
        self.first.max(self.last)
    }

    /// Rings of the window where the transition has some value: the width is interpolated and rounded up.
    pub fn rings(self, transition: f32) -> u32 {
        let [first, last] = [self.first, self.last].map(|width| width as f32);
        let width = first + (last - first) * transition;
        ((width - 1.0) / 2.0).ceil().max(0.0) as u32
    }
}

impl FromStr for Widths {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let (first, last) = text.split_once(',').unwrap_or((text, text));
        let width = |text: &str| text.trim().parse::<u32>();
        match (width(first), width(last)) {
            (Ok(first), Ok(last)) => Ok(Self { first, last }),
            _ => Err("expected a width, or two as 5,9".into()),
        }
    }
}

impl fmt::Display for Widths {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.first == self.last {
            true => write!(f, "{}", self.first),
            false => write!(f, "{},{}", self.first, self.last),
        }
    }
}

impl Serialize for Widths {
    fn serialize<S: Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

/// The options of the progressive method.
#[derive(Clone, Debug, PartialEq, Serialize, clap::Args)]
#[serde(rename_all = "kebab-case")]
#[command(next_help_heading = "Method progressive")]
pub struct ProgressiveOptions {
    /// Width of the window in which masks are compared to choose a label; two widths A,B are for a transition of
    /// 0 and of 1, with those between in proportion
    #[arg(long, default_value_t = Self::default().mask_window, value_name = "N|A,B")]
    pub mask_window: Widths,
    /// Width of the window in which colours and masks are compared to choose a texel; two widths as for --mask-window
    #[arg(long, default_value_t = Self::default().color_window, value_name = "N|A,B")]
    pub color_window: Widths,
    /// Weight of a difference of masks relative to one of colours, each divided by its variance; 0 leaves masks out
    #[arg(long, default_value_t = Self::default().mask_weight, value_name = "X")]
    pub mask_weight: f64,
    /// Width of the window of the last pass over the finest level; 0 leaves this pass out
    #[arg(long, default_value_t = Self::default().refine_window, value_name = "N")]
    pub refine_window: u32,
}

impl Default for ProgressiveOptions {
    fn default() -> Self {
        Self {
            mask_window: Widths::constant(9),
            color_window: Widths::constant(7),
            mask_weight: 1.0,
            refine_window: 5,
        }
    }
}

impl OwnOptions for ProgressiveOptions {
    fn validate(&self) -> Result<()> {
        let windows = [
            ("mask-window", self.mask_window),
            ("color-window", self.color_window),
        ];
        for (name, widths) in windows {
            let is_fit = |width: u32| width % 2 == 1 && (3..=WIDEST).contains(&width);
            if !(is_fit(widths.first) && is_fit(widths.last)) {
                let expected = format!("odd widths, 3 to {WIDEST}");
                return Err(Error::option(name, widths.to_string(), expected));
            }
        }
        if !(0.0..=MOST_MASK_WEIGHT).contains(&self.mask_weight) {
            let expected = format!("0 to {MOST_MASK_WEIGHT:e}");
            return Err(Error::option(
                "mask-weight",
                self.mask_weight.to_string(),
                expected,
            ));
        }
        let (width, widest) = (self.refine_window, self.color_window.widest());
        if width == 0 || (width % 2 == 1 && (3..=widest).contains(&width)) {
            return Ok(());
        }
        Err(Error::option(
            "refine-window",
            width.to_string(),
            format!("0, or an odd width, 3 to {widest}, the colour window's"),
        ))
    }

    fn changed(&self) -> Vec<(&'static str, bool)> {
        let default = Self::default();
        vec![
            ("mask-window", self.mask_window != default.mask_window),
            ("color-window", self.color_window != default.color_window),
            ("mask-weight", self.mask_weight != default.mask_weight),
            ("refine-window", self.refine_window != default.refine_window),
        ]
    }
}

impl ProgressiveOptions {
    /// The widest window that is compared.
    pub fn widest(&self) -> u32 {
        self.mask_window.widest().max(self.color_window.widest())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn widths_are_read_and_interpolated() {
        let widths: Widths = "5, 9".parse().unwrap();
        assert_eq!((widths.first, widths.last), (5, 9));
        assert_eq!(widths.to_string(), "5,9");
        assert_eq!(
            [0.0, 0.2, 0.5, 0.6, 1.0].map(|at| widths.rings(at)),
            [2, 3, 3, 4, 4]
        );
        assert_eq!("7".parse(), Ok(Widths::constant(7)));
        assert!("7,x".parse::<Widths>().is_err());
    }

    #[test]
    fn what_cannot_be_is_refused() {
        let refused = |change: fn(&mut ProgressiveOptions)| {
            let mut options = ProgressiveOptions::default();
            change(&mut options);
            options.validate().unwrap_err().to_string()
        };
        assert!(refused(|o| o.mask_window = Widths::constant(8)).contains("--mask-window: 8"));
        assert!(refused(|o| o.color_window.last = 33).contains("--color-window: 7,33"));
        assert!(refused(|o| o.mask_weight = f64::NAN).contains("--mask-weight: NaN"));
        assert!(refused(|o| o.refine_window = 9).contains("3 to 7, the colour window's"));
    }
}
