//! What synthesis reads, and what a finished level is.

use crate::exemplar::neighbor_table::NeighborTable;
use crate::exemplar::space::Space;
use crate::grid::TexCoord;
use crate::index::Level;
use crate::sites::level::SiteHierarchy;

/// What synthesis reads.
#[derive(Debug)]
pub struct Inputs<'a, S> {
    /// The exemplar's features.
    pub space: &'a Space,
    /// The nearest neighbours of its texels.
    pub table: &'a NeighborTable,
    /// Where synthesis writes.
    pub sites: &'a SiteHierarchy<S>,
}

impl<S> Clone for Inputs<'_, S> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<S> Copy for Inputs<'_, S> {}

/// One finished level.
#[derive(Clone, Debug, PartialEq)]
pub struct LevelMap {
    /// Which.
    pub level: Level,
    /// A texture coordinate per site, in texels of the level: texel centres on the finest, but for the coherent
    /// method's, which are real.
    pub coords: Vec<TexCoord>,
}
