//! Where a neighbourhood's sample falls among the sites.

/// Where a sample falls.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SampleLocation {
    /// Outside every patch triangle, or off the grid.
    Outside,
    /// On a site.
    AtSite(u32),
    /// Between three sites, with their weights.
    InCell([u32; 3], [f32; 3]),
}

impl SampleLocation {
    /// The sites that the sample reads.
    #[inline(always)]
    pub fn sites(&self) -> &[u32] {
        match self {
            Self::Outside => &[],
            Self::AtSite(site) => std::slice::from_ref(site),
            Self::InCell(sites, _) => sites,
        }
    }
}
