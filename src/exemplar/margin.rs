//! Which texels are whole: those that are listed as others' neighbours, and that synthesis may pick. The one
//! definition, for the neighbour table and for every method.
//!
//! In: a texel grid and how far from its border a texel must lie. Out: a flag per texel.

use std::fmt;
use std::str::FromStr;

use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::error::{Error, Result};
use crate::grid::TexelGrid;
use crate::index::TexelIndex;

/// The widest margin: no sample has longer sides.
pub const WIDEST_MARGIN: u32 = 1 << 16;
/// What a margin of whole windows is called.
const FULL: &str = "full";

/// How far from the border of a sample that does not tile a whole texel lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Margin {
    /// So far that every sample of its windows, coarse ones included, is on the grid. The rule of tables that state
    /// none. It leaves coarse levels little more than their middle (10 × 10 of 16 × 16 texels), which finer levels
    /// inherit.
    Full,
    /// At least this many texels of its level.
    Texels(u32),
}

impl Default for Margin {
    fn default() -> Self {
        Self::Texels(1)
    }
}

impl Margin {
    /// Which texels of a level are whole; `fits` says whether all samples of a texel's windows are on the grid. On a
    /// level with fewer than `k` such texels every texel counts as whole.
    pub fn whole_texels(
        self,
        grid: TexelGrid,
        k: usize,
        fits: impl Fn(TexelIndex) -> bool,
    ) -> Vec<bool> {
        let texels = (0..grid.len() as u32).map(TexelIndex);
        let whole: Vec<bool> = match self {
            _ if grid.tileable => return vec![true; grid.len()],
            Self::Full => texels.map(fits).collect(),
            Self::Texels(least) => texels.map(|texel| inset(grid, texel) >= least).collect(),
        };
        match whole.iter().filter(|&&whole| whole).count() < k {
            true => vec![true; grid.len()],
            false => whole,
        }
    }

    /// Refuses a margin that leaves no texel of a sample's finest level.
    pub fn check(self, finest: TexelGrid) -> Result<()> {
        let side = finest.width.min(finest.height);
        match self {
            Self::Texels(least) if least >= side.div_ceil(2) => Err(Error::option(
                "margin",
                format!(
                    "{least} texels on each side of a sample of {} × {}",
                    finest.width, finest.height
                ),
                format!(
                    "at most {}, or `{FULL}`",
                    side.div_ceil(2).saturating_sub(1)
                ),
            )),
            _ => Ok(()),
        }
    }
}

/// How many texels lie between a texel and the nearest border.
fn inset(grid: TexelGrid, texel: TexelIndex) -> u32 {
    let (row, col) = grid.row_col(texel);
    let (below, right) = (grid.height - 1 - row, grid.width - 1 - col);
    row.min(below).min(col).min(right)
}

impl fmt::Display for Margin {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Full => out.write_str(FULL),
            Self::Texels(least) => least.fmt(out),
        }
    }
}

impl FromStr for Margin {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        if text == FULL {
            return Ok(Self::Full);
        }
        let least = text.parse().ok().filter(|&least| least <= WIDEST_MARGIN);
        least.map(Self::Texels).ok_or_else(|| {
            format!("`{text}` is neither `{FULL}` nor a number of texels, 0 to {WIDEST_MARGIN}")
        })
    }
}

impl Serialize for Margin {
    fn serialize<S: Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        match self {
            Self::Full => serializer.serialize_str(FULL),
            Self::Texels(least) => serializer.serialize_u32(*least),
        }
    }
}

impl<'de> Deserialize<'de> for Margin {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> std::result::Result<Self, D::Error> {
        #[derive(Deserialize)]
        #[serde(untagged)]
        enum Written {
            Number(u32),
            Word(String),
        }
        let text = match Written::deserialize(deserializer)? {
            Written::Number(number) => number.to_string(),
            Written::Word(word) => word,
        };
        text.parse().map_err(D::Error::custom)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GRID: TexelGrid = TexelGrid {
        width: 7,
        height: 5,
        tileable: false,
    };

    fn count(margin: Margin, grid: TexelGrid, k: usize) -> usize {
        let whole = margin.whole_texels(grid, k, |texel| texel.0 == 17);
        whole.iter().filter(|&&whole| whole).count()
    }

    #[test]
    fn a_whole_texel_lies_the_margin_from_every_border() {
        let counts = [0, 1, 2, 3].map(|least| count(Margin::Texels(least), GRID, 1));
        // Of 7 × 5: all, 5 × 3, 3 × 1, and none, for which all stand in.
        assert_eq!(counts, [35, 15, 3, 35]);
        let whole = Margin::Texels(2).whole_texels(GRID, 1, |_| false);
        assert!((16..19).all(|texel| whole[texel]));
        assert_eq!(count(Margin::Texels(2), GRID, 4), 35);
        assert_eq!(
            [count(Margin::Full, GRID, 1), count(Margin::Full, GRID, 2)],
            [1, 35]
        );
    }

    #[test]
    fn every_texel_of_a_tileable_sample_is_whole() {
        let tile = TexelGrid {
            tileable: true,
            ..GRID
        };
        for margin in [Margin::Full, Margin::Texels(3)] {
            assert_eq!(count(margin, tile, 1), 35);
        }
    }

    #[test]
    fn margins_are_numbers_or_a_word() {
        for (written, margin) in [("3", Margin::Texels(3)), ("\"full\"", Margin::Full)] {
            assert_eq!(serde_json::from_str::<Margin>(written).unwrap(), margin);
            assert_eq!(serde_json::to_string(&margin).unwrap(), written);
        }
        for wrong in ["-1", "\"all\"", "65537", "null", "1.5"] {
            assert!(serde_json::from_str::<Margin>(wrong).is_err(), "{wrong}");
        }
        assert!(
            "some"
                .parse::<Margin>()
                .unwrap_err()
                .contains("neither `full`")
        );
    }

    #[test]
    fn a_margin_wider_than_the_sample_is_refused() {
        Margin::Texels(2).check(GRID).unwrap();
        Margin::Full.check(GRID).unwrap();
        let text = Margin::Texels(3).check(GRID).unwrap_err().to_string();
        assert!(
            text.contains("sample of 7 × 5") && text.contains("at most 2"),
            "{text}"
        );
    }
}
