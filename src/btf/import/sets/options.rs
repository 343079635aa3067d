//! What a user can say of an image set.

use clap::ValueEnum;
use serde::Serialize;

/// How the images of a set state their directions.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, clap::Args)]
#[serde(rename_all = "kebab-case")]
pub struct SetOptions {
    /// Where the angles are in the images' names, in degrees: {tl} and {pl} are θ and φ of the light, {tv} and {pv}
    /// those of the view, * is any text. A pattern with a / is matched with the path below the folder. Without {tv}
    /// and {pv} the view is directly above.
    #[arg(long, value_name = "PATTERN")]
    pub pattern: Option<String>,
    /// The table of directions that the numbers of images refer to; for names without angles.
    #[arg(long, value_enum)]
    pub directions: Option<Numbering>,
}

impl SetOptions {
    /// The flag of an option that was given, if any was.
    pub fn given(&self) -> Option<&'static str> {
        let pattern = self.pattern.as_ref().map(|_| "pattern");
        pattern.or(self.directions.map(|_| "directions"))
    }
}

/// A table of directions for numbered images.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Numbering {
    /// The 205 pairs of view and light of CUReT.
    Curet,
}
