//! How round sites are prepared: the options, checked.

use crate::error::{Error, Result};
use crate::mesh::field::guides::GuideOptions;
use crate::sites::vertices::surface_options::check_texel;

/// The most circles per vertex.
const MOST_CIRCLES: u32 = 31;
/// The most levels.
const MOST_LEVELS: u32 = 12;

/// How round sites are prepared.
#[derive(Clone, Debug, PartialEq)]
pub struct RoundOptions {
    /// Circles per vertex, 1 to 31.
    pub rings: u32,
    /// Levels, 1 to 12; level l has circles of 2^l times the radius (Chen 2008 §6.2).
    pub levels: u32,
    /// Mesh units per texel of the finest level, the radius of its first circle. By default √(area / referenced
    /// vertices).
    pub texel: Option<f64>,
    /// What guides the orientation field.
    pub guides: GuideOptions,
    /// Seed of everything drawn at random.
    pub seed: u64,
}

impl Default for RoundOptions {
    fn default() -> Self {
        Self {
            rings: 3,
            levels: 4,
            texel: None,
            guides: GuideOptions::default(),
            seed: 0,
        }
    }
}

impl RoundOptions {
    /// Checks every field.
    pub fn validate(&self) -> Result<()> {
        check_circle_count(self.rings)?;
        if !(1..=MOST_LEVELS).contains(&self.levels) {
            let expected = format!("1 to {MOST_LEVELS}");
            return Err(Error::option("levels", self.levels.to_string(), expected));
        }
        check_texel(self.texel)?;
        self.guides.validate()
    }
}

/// Checks a number of circles per vertex.
pub(super) fn check_circle_count(rings: u32) -> Result<()> {
    match (1..=MOST_CIRCLES).contains(&rings) {
        true => Ok(()),
        false => Err(Error::option(
            "rings",
            rings.to_string(),
            format!("1 to {MOST_CIRCLES}"),
        )),
    }
}
