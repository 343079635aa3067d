//! Directions that the user states, for sources that have none of their own.

use std::path::PathBuf;

use crate::btf::direction::Direction;
use crate::btf::direction_set::DirectionSet;
use crate::btf::import::list_options::Handedness;
use crate::error::{Error, Result};

/// Views and lights of sources that do not state them.
#[derive(Clone, Debug, Default, PartialEq, clap::Args)]
pub struct StatedDirections {
    /// The views of an array (.npy), in its order: 12x5, bonn81, bonn151, fibonacci:N, rings of any kind as for
    /// `bake`, FILE.csv or FILE.lp.
    #[arg(long, value_name = "SET")]
    pub views: Option<DirectionSet>,
    /// The lights of an array (.npy), in its order, or those that a fit (.ptm, .rti) is evaluated at:
    /// sets as of --views; FILE.lp is the list of a capture.
    #[arg(long, value_name = "SET")]
    pub lights: Option<DirectionSet>,
}

impl StatedDirections {
    /// The files that hold the directions.
    pub fn files(&self) -> impl Iterator<Item = &PathBuf> {
        [&self.views, &self.lights]
            .into_iter()
            .flatten()
            .filter_map(DirectionSet::file)
    }

    /// The views; an error where none are stated.
    pub fn views(&self, handedness: Handedness) -> Result<Vec<Direction>> {
        stated("views", self.views.as_ref(), handedness)
    }

    /// The lights; an error where none are stated.
    pub fn lights(&self, handedness: Handedness) -> Result<Vec<Direction>> {
        stated("lights", self.lights.as_ref(), handedness)
    }

    /// The flag of a set that was given, if any was.
    pub fn given(&self) -> Option<&'static str> {
        self.given_views()
            .or(self.lights.as_ref().map(|_| "lights"))
    }

    /// The flag of views, where they were given: a fit has one view alone.
    pub fn given_views(&self) -> Option<&'static str> {
        self.views.as_ref().map(|_| "views")
    }
}

fn stated(
    option: &str,
    set: Option<&DirectionSet>,
    handedness: Handedness,
) -> Result<Vec<Direction>> {
    let Some(set) = set else {
        let found = "not given, and the source states none";
        return Err(Error::option(option, found, DirectionSet::FORMS));
    };
    let directions = set.directions()?.into_iter();
    Ok(directions
        .map(|direction| handedness.applied_to(direction))
        .collect())
}
