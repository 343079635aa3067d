//! Round-shaped neighbourhoods (Chen 2008 §4, §6.2): circles round every vertex of a mesh, cut out of the
//! surface by cylinders about the vertex's normal.
//!
//! | file | what it does |
//! | --- | --- |
//! | [`options`] | how round sites are prepared |
//! | [`frame`] | the surface, the axis of a vertex and the plane across it |
//! | `patch` | the triangles that belong to a vertex's patch |
//! | `march` | one circle over a patch |
//! | [`marching`] | all circles of all vertices |
//! | [`arcs`] | circles as they are stored and looked up |
//! | [`sampling`] | samples and neighbours for one orientation field |
//! | [`cache`] | circles in a file |
//! | [`sites`] | all of it for a user's mesh, level by level |
//!
//! In: a mesh, a radius per vertex, a number of circles; then an orientation field. Out: a
//! [`SiteHierarchy`](crate::sites::level::SiteHierarchy) on the same vertices at every level. Marching does not
//! depend on the field, so another field costs none.

mod arcs;
mod cache;
mod frame;
mod march;
pub mod marching;
mod options;
mod patch;
pub mod sampling;
mod sites;

#[cfg(test)]
mod tests;

pub use self::arcs::{Arc, Circle, Circles};
pub use self::frame::Manifold;
pub use self::options::RoundOptions;
pub use self::sites::{CircleSource, RoundSites, prepare};
