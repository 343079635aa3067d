//! What the samples of a site's neighbourhood hold: a blend of at most three sites' features
//! (Tong 2002 eq. 1), the default, or nothing yet.

use crate::mesh::stencil::{SampleLocation, Stencils};

/// What one sample holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Held {
    /// The default texton: the sample lies outside every patch triangle.
    Default,
    /// What one site does: its feature row.
    One(u32),
    /// A surface texton: feature rows and their weights, which sum to 1.
    Blend([u32; 3], [f32; 3]),
}

/// The sites of one level, sampled through its stencils.
#[derive(Clone, Copy, Debug)]
pub struct SampledSites<'a> {
    /// Where the samples fall.
    pub stencils: &'a Stencils,
    /// The feature row each site holds.
    pub rows: &'a [u32],
    /// Which sites are synthesized, while a level grows; `None` when all hold something.
    pub done: Option<&'a [bool]>,
}

impl<'a> SampledSites<'a> {
    /// All sites hold something, every sample counts.
    pub fn all(stencils: &'a Stencils, rows: &'a [u32]) -> Self {
        Self {
            stencils,
            rows,
            done: None,
        }
    }

    /// The samples of a site that count, each with its place in the template.
    #[inline(always)]
    pub fn of_site(&self, site: usize) -> impl Iterator<Item = (usize, Held)> + '_ {
        let samples = self.stencils.of_site(site).enumerate();
        samples.filter_map(|(place, sample)| Some((place, self.held(sample)?)))
    }

    /// What a sample holds; `None` for one that does not count. A sample counts only when all sites that
    /// weigh in it are done.
    #[inline(always)]
    pub fn held(&self, sample: SampleLocation) -> Option<Held> {
        let done = |site: u32| self.done.is_none_or(|done| done[site as usize]);
        let row = |site: u32| self.rows[site as usize];
        match sample {
            SampleLocation::Outside => Some(Held::Default),
            SampleLocation::AtSite(site) => done(site).then(|| Held::One(row(site))),
            SampleLocation::InCell(sites, weights) => {
                let counts = |(&site, &weight)| weight == 0.0 || done(site);
                let all = sites.iter().zip(&weights).all(counts);
                all.then(|| Held::Blend(sites.map(row), weights))
            }
        }
    }
}

/// A site with its samples on its own level and, where two levels are compared, on the coarser.
#[derive(Clone, Copy, Debug)]
pub struct SiteNeighborhood<'a> {
    /// The site.
    pub site: usize,
    /// Samples on its own level.
    pub fine: SampledSites<'a>,
    /// Samples round its parent point.
    pub coarse: Option<SampledSites<'a>>,
}
