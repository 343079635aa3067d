//! A flat grid of sites one texel apart, so that every sample coincides with a site.
//!
//! | file | what it does |
//! | --- | --- |
//! | [`target`] | the grid, its surface and its levels |
//! | [`window`] | square windows: every sample is a site |
//! | [`round`] | round neighbourhoods: a sample lies between four sites |
//! | [`turned`] | neighbourhoods scaled and turned at every site: a sample lies between four sites |

pub(crate) mod round;
pub(crate) mod target;
pub(crate) mod turned;
pub(crate) mod window;

use either::Either;

use crate::sites::grid::window::{GridNeighbors, GridWindow};
use crate::sites::level::{Neighbor, Parent, SampleLocation, Sites};

/// One level of a flat grid; site row · width + col, row 0 at the top.
#[derive(Clone, Debug, PartialEq)]
pub struct GridSites {
    /// Samples of the neighbourhood on this level.
    pub fine: GridWindow,
    /// Samples of the parent level's neighbourhood; `None` at the coarsest level.
    pub coarse: Option<GridWindow>,
    /// Sites within the neighbourhood's window, nearest first.
    pub neighbors: GridNeighbors,
    /// Parent points; empty at the coarsest level.
    pub parents: Vec<Parent>,
    /// 1 per site.
    pub areas: Vec<f32>,
}

impl Sites<1> for GridSites {
    fn count(&self) -> usize {
        self.areas.len()
    }

    #[inline(always)]
    fn neighbors(&self, site: usize) -> impl Iterator<Item = Neighbor> + '_ {
        self.neighbors.of_site(site)
    }

    #[inline(always)]
    fn samples(&self, site: usize) -> impl Iterator<Item = SampleLocation<1>> + '_ {
        self.fine.of_site(site)
    }

    #[inline(always)]
    fn parent_samples(&self, site: usize) -> impl Iterator<Item = SampleLocation<1>> + '_ {
        match &self.coarse {
            Some(coarse) => Either::Left(coarse.of_site(site)),
            None => Either::Right(std::iter::empty()),
        }
    }

    fn samples_per_site(&self) -> usize {
        self.fine.samples_per_site()
    }

    fn parent_samples_per_site(&self) -> usize {
        self.coarse.as_ref().map_or(0, GridWindow::samples_per_site)
    }

    fn parents(&self) -> &[Parent] {
        &self.parents
    }

    fn areas(&self) -> &[f32] {
        &self.areas
    }

    /// Samples and neighbours fill the same window.
    fn known_colors(&self) -> Option<Vec<u32>> {
        Some(self.neighbors.colors())
    }

    /// Row by row.
    fn scan_lines(&self) -> Option<Vec<u32>> {
        Some((0..self.count() as u32).collect())
    }

    fn digest(&self, hasher: &mut blake3::Hasher) {
        hasher.update_rayon(bytemuck::cast_slice(&self.parents));
        hasher.update(format!("{:?}", self.fine).as_bytes());
    }
}
