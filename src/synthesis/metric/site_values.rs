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

/// What becomes of a sample between sites of which only some are synthesized.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unfinished {
    /// It does not count.
    LeftOut,
    /// It holds what the nearest synthesized one of its sites does, the one that weighs most in it; without
    /// any, it does not count (Ying 2001 §4).
    Nearest,
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
    /// What becomes of a sample meanwhile that not all sites are synthesized for.
    pub unfinished: Unfinished,
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

    /// What a sample on the site's own level holds; `None` for one that does not count. A sample counts
    /// when all sites that weigh in it are done; what others do is for [`Unfinished`] to say.
    #[inline(always)]
    pub fn value<const N: usize>(&self, sample: SampleLocation<N>) -> Option<SampleValue<N>> {
        let counts = match (self.done, sample) {
            (None, _) | (_, SampleLocation::Outside) => true,
            (Some(done), SampleLocation::AtSite(site)) => done[site as usize],
            (Some(done), SampleLocation::Between(sites, weights)) => {
                let mut pairs = sites.iter().zip(&weights);
                let all_done = pairs.all(|(&site, &weight)| weight == 0.0 || done[site as usize]);
                if !all_done && self.unfinished == Unfinished::Nearest {
                    let nearest = nearest_done(done, sites, weights)?;
                    return Some(SampleValue::One(self.rows[nearest as usize]));
                }
                all_done
            }
        };
        counts.then(|| value_in(self.rows, sample))
    }
}

/// The site that weighs most of those that are done and weigh anything; of equals the first.
fn nearest_done<const N: usize>(done: &[bool], sites: [u32; N], weights: [f32; N]) -> Option<u32> {
    let mut nearest = (0.0, None);
    for (site, weight) in sites.into_iter().zip(weights) {
        if done[site as usize] && weight > nearest.0 {
            nearest = (weight, Some(site));
        }
    }
    nearest.1
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sites::vertices::VertexSites;

    #[test]
    fn an_unfinished_sample_holds_what_the_nearest_finished_site_does() {
        let sites = VertexSites::default();
        let done = [true, false, true, false];
        let site = |unfinished| SiteNeighborhood {
            site: 0,
            sites: &sites,
            rows: &[10, 11, 12, 13],
            done: Some(&done),
            unfinished,
            coarser: None,
        };
        let (nearest, left_out) = (site(Unfinished::Nearest), site(Unfinished::LeftOut));
        let between = SampleLocation::Between([0, 1, 2], [0.2, 0.5, 0.3]);
        assert_eq!(nearest.value(between), Some(SampleValue::One(12)));
        assert_eq!(left_out.value(between), None);
        let all_done = SampleLocation::Between([0, 1, 2], [0.4, 0.0, 0.6]);
        let blend = SampleValue::Blend([10, 11, 12], [0.4, 0.0, 0.6]);
        assert_eq!(nearest.value(all_done), Some(blend));
        // A finished site that weighs nothing is not near.
        let far = SampleLocation::Between([0, 1, 3], [0.0, 0.5, 0.5]);
        assert_eq!(nearest.value(far), None);
        assert_eq!(nearest.value::<3>(SampleLocation::AtSite(1)), None);
    }
}
