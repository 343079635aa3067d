//! One level of an atlas as [`Sites`].

use std::sync::Arc;

use either::Either;

use super::cells::CellStencils;
use super::neighbors::PackedNeighbor;
use super::scan_lines::ScanLines;
use crate::mesh::compressed_rows::Rows;
use crate::sites::level::{Neighbor, Parent, SampleLocation, Sites};

/// One level of an atlas; sites are its texels inside charts, in row-major order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AtlasSites {
    /// Samples of the neighbourhood on this level.
    pub fine: CellStencils,
    /// Samples of the parent level's neighbourhood round the sites of the coarser level; `None` at the
    /// coarsest level.
    pub coarse: Option<Arc<CellStencils>>,
    /// Sites within the neighbourhood's window, nearest first.
    pub neighbors: Rows<PackedNeighbor>,
    /// Parent points; empty at the coarsest level.
    pub parents: Vec<Parent>,
    /// Surface area that each site stands for, in mesh units squared.
    pub areas: Vec<f32>,
    /// The texel of each site, ascending.
    pub texels: Vec<u32>,
    /// Columns of the level.
    pub width: u32,
    /// The chart of each site.
    pub charts: Vec<u32>,
}

impl Sites<4> for AtlasSites {
    fn count(&self) -> usize {
        self.areas.len()
    }

    #[inline(always)]
    fn neighbors(&self, site: usize) -> impl Iterator<Item = Neighbor> + '_ {
        let packed = self.neighbors.row(site).iter();
        packed.map(|neighbor| neighbor.unpacked())
    }

    #[inline(always)]
    fn samples(&self, site: usize) -> impl Iterator<Item = SampleLocation<4>> + '_ {
        self.fine.of_site(site)
    }

    /// Those of the coarse texel that holds the parent point, as on a flat grid.
    ///
    /// Deviation: the window stands round a coarse texel and not round the parent point itself. On a level
    /// with aligned texels its samples then fall on texels, as the exemplar's do, and are not blurred.
    #[inline(always)]
    fn parent_samples(&self, site: usize) -> impl Iterator<Item = SampleLocation<4>> + '_ {
        match &self.coarse {
            Some(coarse) => Either::Left(coarse.of_site(self.parents[site].site as usize)),
            None => Either::Right(std::iter::empty()),
        }
    }

    fn samples_per_site(&self) -> usize {
        self.fine.samples_per_site
    }

    fn parent_samples_per_site(&self) -> usize {
        let coarse = self.coarse.as_ref();
        coarse.map_or(0, |coarse| coarse.samples_per_site)
    }

    fn parents(&self) -> &[Parent] {
        &self.parents
    }

    fn areas(&self) -> &[f32] {
        &self.areas
    }

    fn scan_lines(&self) -> Option<Vec<u32>> {
        let lines = ScanLines {
            texels: &self.texels,
            width: self.width,
            charts: &self.charts,
        };
        Some(lines.order(|site| self.neighbors(site as usize).map(|near| near.site)))
    }

    /// None: a chart's last lines run into its finished neighbours all along their border.
    fn one_pass_lines(&self) -> Option<Vec<u32>> {
        None
    }

    /// Neighbours are sites of the samples, and charts follow from the neighbours' texels.
    fn digest(&self, hasher: &mut blake3::Hasher) {
        hasher.update_rayon(bytemuck::cast_slice(&self.parents));
        for stencils in std::iter::once(&self.fine).chain(self.coarse.as_deref()) {
            hasher.update_rayon(bytemuck::cast_slice(&stencils.cells));
            hasher.update_rayon(bytemuck::cast_slice(&stencils.samples));
        }
    }
}
