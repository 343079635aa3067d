//! The synthesis engine: from an exemplar and a hierarchy of sites to a texture coordinate and a texton for
//! every site.
//!
//! In: [`Space`](crate::exemplar::space::Space), [`NeighborTable`](crate::exemplar::neighbor_table::NeighborTable)
//! and [`SiteHierarchy`](crate::sites::level::SiteHierarchy). Out: [`LevelMap`]s, and
//! [`quality`] figures.
//!
//! A paper is a [recipe](recipes): a file that builds a [`rule`] and hands it to [drivers](drive).
//!
//! | idea | file |
//! | --- | --- |
//! | how one site is decided | [`rule`] |
//! | which sites are visited, and when | [`drive`], skipping what has [not changed](changes) |
//! | what the sites hold | [`state`] |
//! | which texels are tried | [`candidates`] |
//! | how neighbourhoods are compared | [`metric`] |
//! | which candidate is kept | [`keep`] |
//! | the whole way, from files' contents to a map | [`map`]; what becomes of [controls](pattern_controls) |
//! | how a finished map is improved, patch by patch | [`polish`] |
//! | how good the result is | [`quality`] |
//! | textures on faces, which have no such sites: from a space to a face map, and how that is drawn | [`faces`] |
//! | how many levels a mesh has by default | [`level_choice`] |
//! | what can be asked, and whether it fits | [`options`] in their [ranges](option_ranges), [`check`], [`memory`] |
//! | what a method answers about itself | [`method`], [`own_options`]; which options it [uses](option_use) |
//!
//! Not handled here: preparing targets (`sites`), building neighbour tables (`exemplar`), and files other
//! than the [checkpoint] of an interrupted run.

pub(crate) mod all_levels;
pub(crate) mod atlas_map;
mod candidates;
mod changes;
pub(crate) mod check;
pub(crate) mod checkpoint;
pub(crate) mod drive;
pub mod faces;
pub(crate) mod inputs;
mod keep;
pub(crate) mod level_choice;
pub(crate) mod map;
pub(crate) mod memory;
pub(crate) mod method;
mod metric;
mod option_ranges;
mod option_use;
pub(crate) mod options;
pub(crate) mod own_options;
pub(crate) mod pattern_controls;
mod polish;
pub(crate) mod quality;
pub mod recipes;
pub(crate) mod rule;
pub(crate) mod state;

pub use all_levels::synthesize;
pub use atlas_map::atlas_map;
pub use check::neighborhoods;
pub use checkpoint::Checkpoint;
pub use inputs::{Inputs, LevelMap};
pub use level_choice::LevelChoice;
pub use map::synthesize_map;
pub use method::{Figure, MethodDescription, MethodSites, SharedOption, Workload};
pub use options::{CandidateSearch, KCoherenceOptions, MetricKind, SynthesisOptions};
pub use own_options::OwnOptions;
pub use polish::Effort;
pub use quality::figures::QualityFigure;
pub use recipes::Method;
pub use recipes::adaptive::options::{AdaptiveOptions, Similarity};
pub use recipes::multiscale::options::MultiscaleOptions;
pub use recipes::progressive::options::{ProgressiveOptions, Widths};

#[cfg(test)]
pub(crate) mod tests;
