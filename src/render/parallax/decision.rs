//! Whether views are blended with their parallax, and why.

use serde::Serialize;

use crate::btf::HeightMap;
use crate::btf::sample::Sample;
use crate::error::{Error, Result};
use crate::progress::Progress;
use crate::render::nearest::{DirectionSet, Weighting};
use crate::render::parallax::trial::Trial;

/// Whether views are blended with their parallax.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Parallax {
    /// If the sample has heights, and left-out views are predicted better with it.
    #[default]
    Auto,
    /// Always; the sample must have heights and more than one view.
    On,
    /// Never: all views are read at the same texel.
    Off,
}

/// What was decided.
#[derive(Clone, Debug)]
pub struct Decision {
    /// The heights that views are blended over; `None` for plain blending.
    pub heights: Option<HeightMap>,
    /// The reason, in words.
    pub reason: String,
}

/// Views that are left out to decide it.
const TRIED_VIEWS: usize = 8;

impl Decision {
    /// Decides for a sample whose images are weighted in this way.
    pub fn of(
        sample: &Sample,
        wanted: Parallax,
        weighting: Weighting,
        progress: Progress<'_>,
    ) -> Result<Self> {
        // Do without where it is not wanted.
        let plain = |reason: &str| Self {
            heights: None,
            reason: reason.into(),
        };
        if wanted == Parallax::Off {
            return Ok(plain("as requested"));
        }
        // Refuse samples that cannot have it, where it is demanded.
        let refused = |found: &str| {
            let expected = "a sample of every view with every light, of more than one view, with heights: `mesotex \
                            heights` adds them";
            Error::option("parallax", format!("on for a sample {found}"), expected)
        };
        let heights = match without(sample) {
            Some(found) if wanted == Parallax::On => return Err(refused(found)),
            Some(found) => return Ok(plain(&format!("the sample is one {found}"))),
            None => sample.heights()?,
        };
        // Decide by a trial where nothing is demanded.
        match (heights, wanted) {
            (None, Parallax::On) => Err(refused("without heights")),
            (None, _) => Ok(plain(
                "the sample has no heights; `mesotex heights` adds them",
            )),
            (Some(heights), Parallax::On) => Ok(Self {
                heights: Some(heights),
                reason: "as requested".into(),
            }),
            (Some(heights), _) => {
                let trial = Trial::of(sample, &heights, weighting, TRIED_VIEWS, progress)?;
                Ok(Self::by_trial(heights, trial))
            }
        }
    }

    fn by_trial(heights: HeightMap, trial: Option<Trial>) -> Self {
        let Some(trial) = trial else {
            return Self {
                heights: None,
                reason: "too few views to try it".into(),
            };
        };
        Self {
            heights: trial.helps().then_some(heights),
            reason: trial.describe(),
        }
    }

    /// The decision and its reason, as a report has it.
    pub fn describe(&self) -> String {
        let state = match self.heights {
            Some(_) => "on",
            None => "off",
        };
        format!("parallax {state}: {}", self.reason)
    }
}

/// What a sample lacks for parallax, its heights apart.
fn without(sample: &Sample) -> Option<&'static str> {
    let description = sample.description();
    match &description.pairs {
        Some(_) => Some("of scattered pairs"),
        None if DirectionSet::new(&description.views, Weighting::default()).len() < 2 => {
            Some("of one view")
        }
        None => None,
    }
}
