//! What the multiscale method can be asked beside what every method can.

use serde::Serialize;

use crate::error::{Error, Result};
use crate::neighborhood::Neighborhood;
use crate::synthesis::own_options::OwnOptions;

/// The widest window, in texels: a pattern of it has thousands of numbers.
const WIDEST: u32 = 31;
/// Matches at most.
const MOST_MATCHES: u32 = 1000;
/// A Gaussian's standard deviation over the width of its window (Efros and Leung 1999).
const DEVIATION: f32 = 1.0 / 6.4;

/// The options of the multiscale method.
#[derive(Clone, Debug, PartialEq, Serialize, clap::Args)]
#[serde(rename_all = "kebab-case")]
#[command(next_help_heading = "Method multiscale")]
pub struct MultiscaleOptions {
    /// Width of the window on the level itself, in texels
    #[arg(long, default_value_t = Self::default().window)]
    pub window: u32,
    /// Width of the window on the coarser level, in its texels; the first pass of a level compares only this window
    #[arg(long, default_value_t = Self::default().parent_window)]
    pub parent_window: u32,
    /// Nearest texels among which one is drawn at random, on all levels but the coarsest
    #[arg(long, default_value_t = Self::default().matches)]
    pub matches: u32,
    /// Matches are drawn only if their distance is at most 1 + MATCH_MARGIN times the smallest
    #[arg(long, default_value_t = Self::default().match_margin)]
    pub match_margin: f64,
}

impl Default for MultiscaleOptions {
    fn default() -> Self {
        Self {
            window: 9,
            parent_window: 5,
            matches: 8,
            match_margin: 0.1,
        }
    }
}

impl OwnOptions for MultiscaleOptions {
    fn validate(&self) -> Result<()> {
        check_width("window", self.window, 3)?;
        check_width("parent-window", self.parent_window, 1)?;
        if !(1..=MOST_MATCHES).contains(&self.matches) {
            let expected = format!("1 to {MOST_MATCHES}");
            return Err(Error::option("matches", self.matches.to_string(), expected));
        }
        if !(0.0..=1.0).contains(&self.match_margin) {
            return Err(Error::option(
                "match-margin",
                self.match_margin.to_string(),
                "0 to 1",
            ));
        }
        Ok(())
    }

    fn changed(&self) -> Vec<(&'static str, bool)> {
        let default = Self::default();
        vec![
            ("window", self.window != default.window),
            ("parent-window", self.parent_window != default.parent_window),
            ("matches", self.matches != default.matches),
            ("match-margin", self.match_margin != default.match_margin),
        ]
    }
}

impl MultiscaleOptions {
    /// What a squared distance may be over the smallest.
    pub fn factor(&self) -> f64 {
        (1.0 + self.match_margin).powi(2)
    }

    /// The widest window on a level: the coarser windows of the level below count too.
    pub fn widest_on(&self, level: usize) -> u32 {
        match level {
            0 => self.window,
            _ => self.window.max(self.parent_window),
        }
    }

    /// The windows of this many levels, finest first.
    pub fn neighborhoods(&self, levels: usize) -> Vec<Neighborhood> {
        let of_level = |level| self.neighborhood(level + 1 == levels);
        (0..levels).map(of_level).collect()
    }

    /// The windows of a level that is not the coarsest, or of the coarsest, whose samples weigh less the
    /// farther they are from the centre.
    fn neighborhood(&self, is_coarsest: bool) -> Neighborhood {
        if !is_coarsest {
            return Neighborhood::square(self.window, self.parent_window);
        }
        let mut neighborhood = Neighborhood::square(self.window, 0);
        let deviation = DEVIATION * self.window as f32;
        let weight = |&[drow, dcol]: &[i32; 2]| {
            (-((drow * drow + dcol * dcol) as f32) / (2.0 * deviation * deviation)).exp()
        };
        neighborhood.weights = neighborhood.offsets.iter().map(weight).collect();
        neighborhood
    }
}

fn check_width(option: &str, width: u32, least: u32) -> Result<()> {
    if width % 2 == 1 && (least..=WIDEST).contains(&width) {
        return Ok(());
    }
    let expected = format!("an odd width, {least} to {WIDEST}");
    Err(Error::option(option, width.to_string(), expected))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_cannot_be_is_refused() {
        let refused = |change: fn(&mut MultiscaleOptions)| {
            let mut options = MultiscaleOptions::default();
            change(&mut options);
            options.validate().unwrap_err().to_string()
        };
        assert!(refused(|o| o.window = 8).contains("--window: 8; expected an odd width, 3 to 31"));
        assert!(refused(|o| o.window = 1).contains("--window: 1"));
        assert!(refused(|o| o.parent_window = u32::MAX).contains("--parent-window"));
        assert!(refused(|o| o.matches = 0).contains("--matches: 0; expected 1 to 1000"));
        assert!(refused(|o| o.match_margin = f64::NAN).contains("--match-margin: NaN"));
    }

    #[test]
    fn the_coarsest_windows_are_gaussian() {
        let coarsest = MultiscaleOptions::default().neighborhood(true);
        assert!(coarsest.coarse_offsets.is_empty());
        assert_eq!(coarsest.weights[40], 1.0);
        // Two texels right and one down: exp(−5 / 2σ²) with σ = 9 / 6.4.
        let expected = (-5.0 / (2.0 * (9.0f64 / 6.4).powi(2))).exp();
        assert_eq!(coarsest.offsets[51], [1, 2]);
        assert!((f64::from(coarsest.weights[51]) - expected).abs() < 1e-6);
        let finer = MultiscaleOptions::default().neighborhood(false);
        assert_eq!(finer, Neighborhood::square(9, 5));
    }
}
