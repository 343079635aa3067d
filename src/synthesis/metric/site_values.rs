//! What the samples of a site's neighbourhood hold: a blend of a few sites' features (Tong 2002 eq. 1), the
//! default, or nothing yet.

use crate::sites::level::{SampleLocation, Sites};

/// What one sample holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SampleValue<const N: usize> {
    /// The default texton: the sample lies outside every patch triangle.
    Default,
    /// What one site does: its feature row.
    One(u32),
    /// A surface texton: feature rows and their weights, which sum to 1.
    Blend([u32; N], [f32; N]),
}

/// A site with its samples on its own level and, where two levels are compared, on the coarser.
#[derive(Debug)]
pub struct SiteNeighborhood<'a, S> {
    /// The site.
    pub site: usize,
    /// The level's sites.
    pub sites: &'a S,
    /// The feature row that each site holds.
    pub rows: &'a [u32],
    /// Which sites are synthesized, while a level grows; `None` when all hold something.
    pub done: Option<&'a [bool]>,
    /// The feature row that each site of the coarser level holds, where two levels are compared.
    pub coarser: Option<&'a [u32]>,
}

impl<S> SiteNeighborhood<'_, S> {
    /// The samples on the site's own level that count, each with its place in the template.
    #[inline(always)]
    pub fn own<const N: usize>(&self) -> impl Iterator<Item = (usize, SampleValue<N>)> + '_
    where
        S: Sites<N>,
    {
        let samples = self.sites.samples(self.site).enumerate();
        samples.filter_map(|(place, sample)| Some((place, self.value(sample)?)))
    }

    /// The samples on the coarser level, all of which count.
    #[inline(always)]
    pub fn parent<const N: usize>(&self) -> impl Iterator<Item = SampleValue<N>> + '_
    where
        S: Sites<N>,
    {
        let rows = self.coarser.unwrap_or_default();
        let samples = self.sites.parent_samples(self.site);
        samples.map(move |sample| value_in(rows, sample))
    }

    /// What a sample on the site's own level holds; `None` for one that does not count. A sample counts only
    /// when all sites that weigh in it are done.
    #[inline(always)]
    pub fn value<const N: usize>(&self, sample: SampleLocation<N>) -> Option<SampleValue<N>> {
        let counts = match (self.done, sample) {
            (None, _) | (_, SampleLocation::Outside) => true,
            (Some(done), SampleLocation::AtSite(site)) => done[site as usize],
            (Some(done), SampleLocation::Between(sites, weights)) => {
                let mut pairs = sites.iter().zip(&weights);
                pairs.all(|(&site, &weight)| weight == 0.0 || done[site as usize])
            }
        };
        counts.then(|| value_in(self.rows, sample))
    }
}

/// What a sample holds where every site holds something.
#[inline(always)]
pub fn value_in<const N: usize>(rows: &[u32], sample: SampleLocation<N>) -> SampleValue<N> {
    let row = |site: u32| rows[site as usize];
    match sample {
        SampleLocation::Outside => SampleValue::Default,
        SampleLocation::AtSite(site) => SampleValue::One(row(site)),
        SampleLocation::Between(sites, weights) => SampleValue::Blend(sites.map(row), weights),
    }
}
