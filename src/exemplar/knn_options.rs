//! What a user may choose about the neighbour table.

use serde::Serialize;

use crate::error::{Error, Result};
use crate::exemplar::margin::Margin;
use crate::grid::TexelGrid;

/// The least separation of listed neighbours, as a share of the level's shorter side.
const SEPARATION_SHARE: f64 = 0.05;
/// The widest window, beyond any use.
pub const WIDEST: u32 = 255;

/// Neighbours a texel at most: 512 MiB for the table of 128 × 128 texels.
const MOST_NEIGHBORS: u32 = 4096;
/// Parents considered at most.
const MOST_CANDIDATES: u32 = 1 << 20;
/// The largest separation, in texels.
const LARGEST_SEPARATION: u32 = 16_384;

/// Texels up to which exact search is cheap: 128 × 128.
const CHEAP_TEXELS: usize = 1 << 14;

/// How neighbours are searched.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum NeighborSearch {
    /// Exact up to 128 × 128 texels, two-level for larger samples.
    #[default]
    Auto,
    /// Every texel is compared with every other.
    Exact,
    /// Through the parent level's nearest (Tong 2002 §5.2); the coarsest level stays exact.
    TwoLevel,
}

/// Options of the neighbour table.
#[derive(Clone, Debug, PartialEq, Serialize, clap::Args)]
#[serde(rename_all = "kebab-case")]
pub struct KnnOptions {
    /// Neighbours per texel, itself included (Tong 2002 §5.2: 11).
    #[arg(long, default_value_t = Self::default().k, value_name = "N")]
    pub k: u32,
    /// Width of the window on the level itself, in texels; odd.
    #[arg(long, default_value_t = Self::default().neighborhood, value_name = "N")]
    pub neighborhood: u32,
    /// Width of the window on the parent level, in its texels; odd.
    #[arg(long, default_value_t = Self::default().coarse_neighborhood, value_name = "N")]
    pub coarse_neighborhood: u32,
    /// Least distance between listed neighbours at level 0, in texels (max norm), halved with every coarser level.
    /// [default: 5 % of the level's shorter side, at least 1]
    #[arg(long, value_name = "N")]
    pub min_separation: Option<u32>,
    /// Texels nearer than this to the border of a sample that does not tile are neither listed nor picked by synthesis.
    /// `full`: neither are texels whose windows cross the border.
    #[arg(long, default_value_t = Self::default().margin, value_name = "N|full")]
    pub margin: Margin,
    /// How neighbours are searched.
    #[arg(long, value_enum, default_value_t = Self::default().search)]
    pub search: NeighborSearch,
    /// Parents that the two-level search considers first (Tong 2002 §5.2: 100).
    #[arg(long, default_value_t = Self::default().candidates, value_name = "N")]
    pub candidates: u32,
    /// List only texels whose transition differs by less than this (Zhang 2003 eq. 1: 0.1), 0 to 1; for a space
    /// with a transition [default: any texel]
    #[arg(long, value_name = "E")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub transition_tolerance: Option<f64>,
}

impl Default for KnnOptions {
    fn default() -> Self {
        Self {
            k: 11,
            neighborhood: 7,
            coarse_neighborhood: 3,
            min_separation: None,
            margin: Margin::default(),
            search: NeighborSearch::Auto,
            candidates: 100,
            transition_tolerance: None,
        }
    }
}

impl KnnOptions {
    /// Refuses numbers no table can have.
    pub fn validate(&self) -> Result<()> {
        // Check the counts.
        for (name, value, least, most, why) in [
            (
                "k",
                self.k,
                1,
                MOST_NEIGHBORS,
                "a table has k entries for each texel, itself included",
            ),
            (
                "candidates",
                self.candidates,
                1,
                MOST_CANDIDATES,
                "those of each texel are sorted",
            ),
            (
                "min-separation",
                self.min_separation.unwrap_or(0),
                0,
                LARGEST_SEPARATION,
                "no sample has longer sides",
            ),
        ] {
            if !(least..=most).contains(&value) {
                return Err(Error::option(
                    name,
                    value.to_string(),
                    format!("{least} to {most}: {why}"),
                ));
            }
        }
        check_tolerance(self.transition_tolerance)?;
        // Check the widths.
        for (name, width) in [
            ("neighborhood", self.neighborhood),
            ("coarse-neighborhood", self.coarse_neighborhood),
        ] {
            if width.is_multiple_of(2) || width > WIDEST {
                return Err(Error::option(
                    name,
                    width.to_string(),
                    format!("an odd width from 1 to {WIDEST}"),
                ));
            }
        }
        Ok(())
    }

    /// Widths of the window and of the parent's, 0 where there is no parent level.
    pub fn widths(&self, has_parent: bool) -> (u32, u32) {
        (
            self.neighborhood,
            if has_parent {
                self.coarse_neighborhood
            } else {
                0
            },
        )
    }

    /// The search of a level.
    pub fn search_at(&self, grid: TexelGrid, has_parent: bool) -> NeighborSearch {
        match self.search {
            NeighborSearch::TwoLevel if has_parent => NeighborSearch::TwoLevel,
            NeighborSearch::Auto if has_parent && grid.len() > CHEAP_TEXELS => {
                NeighborSearch::TwoLevel
            }
            _ => NeighborSearch::Exact,
        }
    }

    /// The least separation at a level.
    pub fn separation(&self, grid: TexelGrid, level: usize) -> u32 {
        let texels = match self.min_separation {
            None => SEPARATION_SHARE * f64::from(grid.width.min(grid.height)),
            Some(0) => return 0,
            Some(texels) => f64::from(texels) / 2_f64.powi(level as i32),
        };
        (texels.round() as u32).max(1)
    }
}

/// Refuses a tolerance that no transition can meet.
pub fn check_tolerance(tolerance: Option<f64>) -> Result<()> {
    match tolerance {
        Some(tolerance) if !(tolerance > 0.0 && tolerance <= 1.0) => Err(Error::option(
            "transition-tolerance",
            tolerance.to_string(),
            "a difference above 0, at most 1",
        )),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(side: u32) -> TexelGrid {
        TexelGrid {
            width: side,
            height: side,
            tileable: true,
        }
    }

    #[test]
    fn separation_is_a_twentieth_of_the_side_or_halves() {
        let options = KnnOptions::default();
        let sides = [64, 32, 16, 8].map(|side| options.separation(square(side), 0));
        assert_eq!(sides, [3, 2, 1, 1]);
        let options = KnnOptions {
            min_separation: Some(6),
            ..options
        };
        assert_eq!(
            [0, 1, 2, 3].map(|level| options.separation(square(64), level)),
            [6, 3, 2, 1]
        );
    }

    #[test]
    fn even_windows_are_refused() {
        for options in [
            KnnOptions {
                neighborhood: 6,
                ..Default::default()
            },
            KnnOptions {
                coarse_neighborhood: 0,
                ..Default::default()
            },
            KnnOptions {
                k: 0,
                ..Default::default()
            },
        ] {
            assert!(options.validate().is_err());
        }
    }
}
