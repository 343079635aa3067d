//! The hierarchy of sites that synthesis writes: per level the stencils, the neighbours of each
//! site, and its parent point. A mesh prepares one (vertices); a flat grid is another.

use crate::mesh::stencil::Stencils;

/// A site near another, and where it lies in that one's (s, t) plane.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Neighbor {
    /// The neighbouring site.
    pub site: u32,
    /// Offset along s, in texels of the level.
    pub x: f32,
    /// Offset along t, in texels of the level.
    pub y: f32,
}

/// The neighbours of every site of a level, in compressed rows.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NeighborLists {
    /// Where each site's list begins; one more entry than sites.
    pub starts: Vec<u32>,
    /// The lists, one after the other; the site itself is not in its own.
    pub entries: Vec<Neighbor>,
}

impl NeighborLists {
    /// The neighbours of one site.
    #[inline]
    pub fn of_site(&self, site: usize) -> &[Neighbor] {
        &self.entries[self.starts[site] as usize..self.starts[site + 1] as usize]
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
#[derive(Clone, Debug, Default, PartialEq)]
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
