//! What texton mask filtering can be asked.

use crate::error::{Error, Result};

/// The widest window, in pixels.
const WIDEST: u32 = 31;
/// The largest weight and preference.
const MOST: f64 = 1e6;

/// The options of texton mask filtering.
#[derive(Clone, Debug, PartialEq, clap::Args)]
#[command(next_help_heading = "Texton mask filtering")]
pub struct FilterOptions {
    /// Levels of the pyramid that is filtered; fewer if sides are short or cannot be halved
    #[arg(long, default_value_t = Self::default().filter_levels, value_name = "N")]
    pub filter_levels: u32,
    /// Width of the window in which masks are compared, in pixels; odd
    #[arg(long, default_value_t = Self::default().mask_window, value_name = "N")]
    pub mask_window: u32,
    /// Width of the window in which synthesized colours are compared, in pixels; odd
    #[arg(long, default_value_t = Self::default().color_window, value_name = "N")]
    pub color_window: u32,
    /// Width of both windows on the coarser level, in its pixels; odd
    #[arg(long, default_value_t = Self::default().parent_window, value_name = "N")]
    pub parent_window: u32,
    /// Weight of a difference of labels, relative to a difference from black to white in one colour channel
    #[arg(long, default_value_t = Self::default().mask_weight, value_name = "W")]
    pub mask_weight: f64,
    /// Preference for coherent pixels, κ of Hertzmann 2001: how much larger their distance may be, halved with every
    /// coarser level; 0 for none
    #[arg(long, default_value_t = Self::default().kappa, value_name = "K")]
    pub kappa: f64,
}

impl Default for FilterOptions {
    fn default() -> Self {
        Self {
            filter_levels: 3,
            mask_window: 9,
            color_window: 5,
            parent_window: 3,
            mask_weight: 2.0,
            kappa: 0.5,
        }
    }
}

impl FilterOptions {
    /// Checks every field by itself.
    pub fn validate(&self) -> Result<()> {
        if !(1..=16).contains(&self.filter_levels) {
            let found = self.filter_levels.to_string();
            return Err(Error::option("filter-levels", found, "1 to 16"));
        }
        for (name, width) in [
            ("mask-window", self.mask_window),
            ("color-window", self.color_window),
            ("parent-window", self.parent_window),
        ] {
            if width.is_multiple_of(2) || width > WIDEST {
                let expected = format!("an odd width from 1 to {WIDEST}");
                return Err(Error::option(name, width.to_string(), expected));
            }
        }
        for (name, number) in [("mask-weight", self.mask_weight), ("kappa", self.kappa)] {
            if !(0.0..=MOST).contains(&number) {
                return Err(Error::option(
                    name,
                    number.to_string(),
                    format!("0 to {MOST:e}"),
                ));
            }
        }
        Ok(())
    }

    /// What a coherent pixel's distance may be over the smallest, at a level.
    pub fn coherence_at(&self, level: usize) -> f32 {
        (1.0 + self.kappa / f64::from(1_u32 << level.min(16))) as f32
    }
}
