//! What a method of synthesis answers about itself.
//!
//! Every [recipe](crate::synthesis::recipes) has one [`MethodDescription`]. Engine and command line ask it, so that
//! nothing outside the recipe has to know the method.

use clap::ValueEnum;
use clap::builder::PossibleValue;
use serde::{Serialize, Serializer};

use crate::error::Result;
use crate::exemplar::neighbor_table::NeighborTable;
use crate::exemplar::space::Space;
use crate::neighborhood::Neighborhood;
use crate::synthesis::check::table_plan::{Plan, plan, table_windows};
use crate::synthesis::options::SynthesisOptions;
use crate::synthesis::own_options::OwnOptions;
use crate::synthesis::recipes::Method;

/// The description of a method. A recipe states what differs from [`PLAIN`](Self::PLAIN).
#[derive(Debug)]
pub struct MethodDescription {
    /// Its name on the command line, in reports and in maps.
    pub name: &'static str,
    /// Its help text: the paper, and what the method does.
    pub help: &'static str,
    /// The sites that it visits.
    pub sites: MethodSites,
    /// Completes the options by the exemplar, and checks that they fit it.
    pub plan: fn(&Space, &NeighborTable, &SynthesisOptions) -> Result<Plan>,
    /// Whether the number of levels of a mesh is chosen by its vertices, where none is asked for.
    pub chooses_levels: bool,
    /// The shared options that it does not use, each with what it has in place of it.
    pub unused: &'static [(SharedOption, &'static str)],
    /// The options that it alone has.
    pub own_options: Option<fn(&SynthesisOptions) -> &dyn OwnOptions>,
    /// Refuses values of shared options that do not suit it.
    pub check_options: fn(&SynthesisOptions) -> Result<()>,
    /// Whether it follows the controls of exemplar and surface: transition, mask and orientation.
    pub follows_controls: bool,
    /// The figures that its report has beside those of every method.
    pub figures: &'static [Figure],
    /// Microseconds that a site takes on one thread, its preparation included.
    pub microseconds: fn(Workload, &SynthesisOptions) -> f64,
    /// Bytes that it takes beside what every method does, for so many sites.
    pub bytes: fn(&Space, u64, &SynthesisOptions) -> u64,
}

/// The sites of a method, and what decides their neighbourhoods.
#[derive(Clone, Copy, Debug)]
pub enum MethodSites {
    /// Sites with square windows: those of every level of a plan, finest first.
    Windows(fn(&NeighborTable, &Plan, &SynthesisOptions) -> Vec<Neighborhood>),
    /// The same sites on every level, with round neighbourhoods of so many rings.
    Circles(fn(&SynthesisOptions) -> u32),
    /// Faces, which have an entry of their own:
    /// [`synthesize_faces`](crate::synthesis::recipes::choosy::synthesize_faces).
    Faces,
}

/// An option that several methods share.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SharedOption {
    /// `--levels`, any number of them.
    Levels,
    /// `--levels` above 1.
    SeveralLevels,
    /// `--metric`.
    Metric,
    /// `--neighborhood`.
    Neighborhood,
    /// `--passes`.
    Passes,
}

impl SharedOption {
    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Levels | Self::SeveralLevels => "levels",
            Self::Metric => "metric",
            Self::Neighborhood => "neighborhood",
            Self::Passes => "passes",
        }
    }
}

/// A figure of the report that only some methods have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Figure {
    /// The nearest texels that are tried with each coherent one.
    K,
    /// How often the metric chooses as Φ does.
    MetricAgreement,
    /// Choices for which all admitted texels were compared.
    Searched,
}

/// What the time per site depends on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Workload {
    /// Texels of the exemplar's finest level.
    pub texels: f64,
    /// Whether sites are texels of an atlas.
    pub onto_atlas: bool,
}

impl Workload {
    /// Microseconds per site of a search of the whole exemplar with the table's windows.
    pub fn full_search(self) -> f64 {
        63.0 + 0.9 * self.texels.sqrt()
    }
}

impl MethodDescription {
    /// A method of the plainest kind: it compares the neighbour table's windows on all levels, searches the whole
    /// exemplar and has no options of its own. Name and help are left to the recipe.
    pub const PLAIN: Self = Self {
        name: "",
        help: "",
        sites: MethodSites::Windows(|table, plan, _| table_windows(table, plan)),
        plan,
        chooses_levels: true,
        unused: &[],
        own_options: None,
        check_options: |_| Ok(()),
        follows_controls: false,
        figures: &[],
        microseconds: |work, _| work.full_search(),
        bytes: |_, _, _| 0,
    };
}

impl Method {
    /// Its name on the command line and in maps.
    pub fn name(self) -> &'static str {
        self.description().name
    }

    /// Whether it writes on faces.
    pub fn writes_faces(self) -> bool {
        matches!(self.description().sites, MethodSites::Faces)
    }

    /// Whether it takes any exemplar onto any sites but faces: one that follows no controls.
    pub fn is_ordinary(self) -> bool {
        !self.writes_faces() && !self.description().follows_controls
    }

    /// Whether its neighbourhoods are round.
    pub fn is_round(self) -> bool {
        matches!(self.description().sites, MethodSites::Circles(_))
    }

    /// Whether it makes coarser meshes of the one it is given.
    pub fn retiles(self) -> bool {
        let mut unused = self.description().unused.iter();
        !self.is_round() && unused.all(|(option, _)| *option != SharedOption::SeveralLevels)
    }

    /// Whether its report has a figure.
    pub fn reports(self, figure: Figure) -> bool {
        self.description().figures.contains(&figure)
    }
}

impl Serialize for Method {
    fn serialize<S: Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}

impl ValueEnum for Method {
    fn value_variants<'a>() -> &'a [Self] {
        Self::ALL
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        let MethodDescription { name, help, .. } = self.description();
        Some(PossibleValue::new(*name).help(*help))
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn every_method_has_a_name_and_a_help_text() {
        let names: BTreeSet<_> = Method::ALL.iter().map(|method| method.name()).collect();
        assert_eq!(names.len(), Method::ALL.len());
        for method in Method::ALL {
            let MethodDescription { name, help, .. } = method.description();
            let is_kebab_case = |letter: char| letter == '-' || letter.is_ascii_lowercase();
            assert!(
                !name.is_empty() && name.chars().all(is_kebab_case),
                "{name:?}"
            );
            assert!(!help.is_empty() && !help.ends_with('.'), "{name}: {help:?}");
        }
    }

    #[test]
    fn meshes_are_retiled_for_square_windows_on_several_levels() {
        let methods = Method::ALL.iter().copied();
        let retiling = methods.filter(|method| method.retiles());
        let retiling: Vec<_> = retiling.map(Method::name).collect();
        assert!(retiling.contains(&"k-coherence") && retiling.contains(&"multiscale"));
        assert!(!retiling.contains(&"adaptive") && !retiling.contains(&"coherent"));
    }
}
