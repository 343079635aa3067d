//! The vertices of a mesh as sites: patches round every vertex, sampled once for any exemplar, on every
//! level of a pyramid of retiled meshes (Tong 2002 §5.1).
//!
//! In: a [user's mesh](crate::mesh::reading::UserMesh). Out: a [`PreparedSurface`](prepared_surface::PreparedSurface),
//! kept in a [`cache`] beside the mesh.
//!
//! | file | what it does |
//! | --- | --- |
//! | [`surface`], [`prepared_surface`], [`surface_options`] | the whole preparation: pyramid, orientation field, stencils |
//! | [`patches`], [`sampling`], [`stencil`] | where the samples round every vertex fall |
//! | [`parents`] | the place of every vertex on the coarser level |
//! | [`circles`] | round neighbourhoods, of the same vertices at every level |
//! | [`cache`] | prepared surfaces in files |
//! | [`distortion`], [`stretch`] | how much charts and samples bend lengths |
//! | [`memory`] | how much memory preparation takes |

pub mod cache;
pub mod circles;
pub(crate) mod distortion;
pub(crate) mod memory;
mod parents;
pub mod patches;
pub(crate) mod prepared_surface;
pub(crate) mod sampling;
pub mod stencil;
pub mod stretch;
pub mod surface;
pub mod surface_options;

use either::Either;

use crate::mesh::compressed_rows::Rows;
use crate::sites::level::{Neighbor, Parent, SampleLocation, Sites};
use crate::sites::vertices::stencil::PatchStencils;

/// The vertices of one mesh of the pyramid.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct VertexSites {
    /// Samples of the neighbourhood on this level.
    pub fine: PatchStencils,
    /// Samples of the parent level's neighbourhood round the parent point, on the coarser level's
    /// vertices; `None` at the coarsest level.
    pub coarse: Option<PatchStencils>,
    /// Vertices within the neighbourhood's window, nearest first.
    pub neighbors: Rows<Neighbor>,
    /// Parent points; empty at the coarsest level.
    pub parents: Vec<Parent>,
    /// Surface area each vertex stands for, in mesh units squared (0 for one in no face).
    pub areas: Vec<f32>,
}

impl Sites<3> for VertexSites {
    fn count(&self) -> usize {
        self.areas.len()
    }

    #[inline(always)]
    fn neighbors(&self, site: usize) -> impl Iterator<Item = Neighbor> + '_ {
        self.neighbors.row(site).iter().copied()
    }

    #[inline(always)]
    fn samples(&self, site: usize) -> impl Iterator<Item = SampleLocation<3>> + '_ {
        self.fine.of_site(site)
    }

    #[inline(always)]
    fn parent_samples(&self, site: usize) -> impl Iterator<Item = SampleLocation<3>> + '_ {
        match &self.coarse {
            Some(coarse) => Either::Left(coarse.of_site(site)),
            None => Either::Right(std::iter::empty()),
        }
    }

    fn samples_per_site(&self) -> usize {
        self.fine.samples_per_site
    }

    fn parent_samples_per_site(&self) -> usize {
        self.coarse
            .as_ref()
            .map_or(0, |coarse| coarse.samples_per_site)
    }

    fn parents(&self) -> &[Parent] {
        &self.parents
    }

    fn areas(&self) -> &[f32] {
        &self.areas
    }

    /// Neighbours come of the same patches as the samples.
    fn digest(&self, hasher: &mut blake3::Hasher) {
        hasher.update_rayon(bytemuck::cast_slice(&self.parents));
        hasher.update_rayon(bytemuck::cast_slice(&self.fine.cells));
        hasher.update_rayon(bytemuck::cast_slice(&self.fine.samples));
    }
}
