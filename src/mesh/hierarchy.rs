//! The hierarchy of sites that synthesis writes: per level the stencils, the neighbours of each
//! site, and its parent point. A mesh prepares one (vertices); a flat grid is another.

use either::Either;

pub use crate::mesh::neighbor::Neighbor;

use crate::mesh::grid_window::GridNeighbors;
use crate::mesh::stencil::Stencils;

/// The neighbours of every site of a level.
#[derive(Clone, Debug, PartialEq)]
pub enum NeighborLists {
    /// Those of a mesh's patches.
    OfPatches(PatchNeighbors),
    /// Those of a flat grid.
    OfGrid(GridNeighbors),
}

/// The neighbours of every vertex of a mesh, in compressed rows.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PatchNeighbors {
    /// Where each site's list begins; one more entry than sites.
    pub starts: Vec<u32>,
    /// The lists, one after the other; the site itself is not in its own.
    pub entries: Vec<Neighbor>,
}

impl NeighborLists {
    /// The neighbours of one site, nearest first.
    #[inline(always)]
    pub fn of_site(&self, site: usize) -> impl Iterator<Item = Neighbor> + '_ {
        match self {
            Self::OfPatches(lists) => Either::Left(lists.of_site(site)),
            Self::OfGrid(neighbors) => Either::Right(neighbors.of_site(site)),
        }
    }

    /// Sites that have a list.
    pub fn site_count(&self) -> usize {
        match self {
            Self::OfPatches(lists) => lists.starts.len().saturating_sub(1),
            Self::OfGrid(neighbors) => neighbors.site_count(),
        }
    }
}

impl PatchNeighbors {
    /// The neighbours of one site, nearest first.
    #[inline(always)]
    pub fn of_site(&self, site: usize) -> impl Iterator<Item = Neighbor> + '_ {
        let list = self.starts[site] as usize..self.starts[site + 1] as usize;
        self.entries[list].iter().copied()
    }
}

/// Where a site lies on the next coarser level: the coarse site u with the largest weight in the
/// parent point's triangle, and u's position seen from the parent point.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Parent {
    /// u, a site of the coarser level.
    pub site: u32,
    /// u's offset along s from the parent point, in texels of the coarser level.
    pub x: f32,
    /// u's offset along t from the parent point, in texels of the coarser level.
    pub y: f32,
}

/// One level of sites.
#[derive(Clone, Debug, PartialEq)]
pub struct SiteLevel {
    /// Sites of this level.
    pub site_count: usize,
    /// Samples of the neighbourhood on this level.
    pub fine: Stencils,
    /// Samples of the parent level's neighbourhood round the parent point, on the coarser level's
    /// sites; `None` at the coarsest level.
    pub coarse: Option<Stencils>,
    /// Sites within the neighbourhood's window, nearest first.
    pub neighbors: NeighborLists,
    /// Parent points; empty at the coarsest level.
    pub parents: Vec<Parent>,
    /// Surface area each site stands for, in mesh units squared (0 for a site in no face).
    pub areas: Vec<f32>,
}

/// All levels, finest first.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SiteHierarchy {
    /// Level 0 is the finest.
    pub levels: Vec<SiteLevel>,
}
