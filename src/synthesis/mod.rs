//! The synthesis engine (Tong 2002 §5): from an exemplar and a hierarchy of sites to a texture
//! coordinate and a texton for every site.
//!
//! In: [`Space`](crate::exemplar::space::Space), [`NeighborTable`](crate::exemplar::neighbor_table::NeighborTable)
//! and [`SiteHierarchy`](crate::mesh::hierarchy::SiteHierarchy) — of a mesh, or of the
//! [flat grid](grid_target). Out: [`LevelMap`](engine::LevelMap)s, and [`quality`] figures.
//!
//! The engine is a few small ideas, a file each, and a paper is a choice of each:
//!
//! | idea | file |
//! | --- | --- |
//! | the exemplar's texels, windows, neighbours | [`exemplar_level`], [`windows`] |
//! | what a site's neighbourhood holds | [`site_samples`] |
//! | distance of a site's and a texel's neighbourhood | [`metric`]: [`gram`] (through Φ), [`embedded`] (through a factor of it), [`picture`] (of plain images) |
//! | which texels to try | [`candidates`] that neighbours [propose](proposals), or all; [`bounds`] rule most of them out |
//! | which of them to take | [`choice`], after [`usage`] on the coarsest level |
//! | in which order to visit | [`order`] (growing), [`coloring`] (in parallel) |
//! | how a level starts and is refined | [`passes`], sparing what has [not changed](changes) |
//! | how the finest level ends | [`mending`] |
//!
//! Not handled here: preparing meshes (`mesh`), building neighbour tables (`exemplar`), drawing
//! and files other than the [checkpoint](checkpoint) of an interrupted run.

pub mod bounds;
pub mod candidates;
pub mod changes;
pub mod check;
pub mod checkpoint;
pub mod choice;
pub mod coloring;
pub mod embedded;
pub mod embedding;
pub mod engine;
pub mod exemplar_level;
pub mod gram;
pub mod grid_target;
pub mod memory;
pub mod mending;
pub mod metric;
pub mod options;
pub mod order;
pub mod passes;
pub mod picture;
pub mod pictures;
pub mod proposals;
pub mod quality;
pub mod site_samples;
pub mod usage;
pub mod windows;

#[cfg(test)]
mod fixtures;
#[cfg(test)]
mod oracles;
