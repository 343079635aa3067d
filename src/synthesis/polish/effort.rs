//! How much of a map is polished.

use std::fmt;
use std::str::FromStr;

use serde::Serialize;

use crate::error::Result;
use crate::synthesis::option_ranges::few_rounds;

/// What `--polish` asks for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Effort {
    /// Of a sample that does not tile, one round over the regions in which texels are repeated: where a patch reaches
    /// the sample's border, choosing site by site goes back a few texels over and over. Of one that tiles, nothing.
    #[default]
    Auto,
    /// So many rounds over all regions, 0 to 1000.
    Rounds(u32),
}

impl Effort {
    /// Refuses more rounds than any run needs.
    pub fn validate(self) -> Result<()> {
        match self {
            Self::Auto => Ok(()),
            Self::Rounds(rounds) => few_rounds("polish", rounds, 0),
        }
    }

    /// The rounds that a sample's map takes.
    pub fn rounds(self, tileable: bool) -> u32 {
        match self {
            Self::Auto => u32::from(!tileable),
            Self::Rounds(rounds) => rounds,
        }
    }
}

impl FromStr for Effort {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        if text == "auto" {
            return Ok(Self::Auto);
        }
        let rounds = text.parse().map(Self::Rounds);
        rounds.map_err(|_| "expected a number of rounds, or auto".to_owned())
    }
}

impl fmt::Display for Effort {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Auto => f.write_str("auto"),
            Self::Rounds(rounds) => write!(f, "{rounds}"),
        }
    }
}

/// As typed: `auto` or a number.
impl Serialize for Effort {
    fn serialize<S: serde::Serializer>(
        &self,
        serializer: S,
    ) -> std::result::Result<S::Ok, S::Error> {
        match self {
            Self::Auto => serializer.serialize_str("auto"),
            Self::Rounds(rounds) => serializer.serialize_u32(*rounds),
        }
    }
}
