//! What synthesis reads, and what a finished level is.

use crate::exemplar::neighbor_table::NeighborTable;
use crate::exemplar::space::Space;
use crate::grid::TexCoord;
use crate::index::Level;
use crate::sites::controls::SiteControls;
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
    /// What a texture that changes follows on level 0.
    pub controls: Option<&'a SiteControls>,
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
    /// Choices of a method that admits only some texels, for which none of those proposed was admitted.
    pub searched: u64,
}

/// What a level comes to hold.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LevelContent {
    /// As in [`LevelMap`].
    pub coords: Vec<TexCoord>,
    /// As in [`LevelMap`].
    pub searched: u64,
}

impl From<Vec<TexCoord>> for LevelContent {
    fn from(coords: Vec<TexCoord>) -> Self {
        Self {
            coords,
            ..Self::default()
        }
    }
}
