//! Between files and choosy sampling: the part of an exemplar that is sampled, the map of what comes of it, and that
//! map with a texture coordinate at every corner, as it is drawn.
//!
//! | file | what it does |
//! | --- | --- |
//! | [`exemplar`] | a square of the exemplar's finest level |
//! | [`map`] | the face map of a finished texture |
//! | [`source_places`] | where the sources of a face map lie on the sample |
//! | [`decorated`] | a face map as a surface texton map whose vertices are corners or centres of faces |
//! | [`levels_file`] | the pyramids in one archive |
//! | [`histograms`] | whether the surface's numbers are distributed as the sample's |
//! | [`memory`] | the memory that this takes |

pub(crate) mod decorated;
pub(crate) mod exemplar;
pub(crate) mod histograms;
pub(crate) mod levels_file;
pub(crate) mod map;
pub(crate) mod memory;
mod source_places;

pub use decorated::{CornerPlaces, at_centers, with_own_corners};
pub use exemplar::SquareExemplar;
pub use map::face_map;
