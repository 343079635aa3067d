//! One level of sites: what synthesis asks of whatever it writes on. A target is a file that implements
//! [`Sites`].

/// A site near another, and where it lies in that one's (s, t) plane.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Neighbor {
    /// The neighbouring site.
    pub site: u32,
    /// Offset along s, in texels of the level.
    pub x: f32,
    /// Offset along t, in texels of the level.
    pub y: f32,
}

/// Where a site lies on the next coarser level: the coarse site u with the largest weight in the
/// parent point's cell, and u's position seen from the parent point.
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

/// An edge between two sites, and where the second lies seen from the first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SiteEdge {
    /// The site with the smaller index.
    pub from: u32,
    /// The other.
    pub to: u32,
    /// Offset of `to` in the (s, t) plane of `from`, in texels of level 0.
    pub offset: [f32; 2],
}

/// Sites that a sample blends at most, on any target.
pub const MOST_BLENDED: usize = 4;

/// Where a sample falls.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SampleLocation<const N: usize> {
    /// Beyond the surface that is seen from the site.
    Outside,
    /// On a site.
    AtSite(u32),
    /// Between N sites, with their weights.
    Between([u32; N], [f32; N]),
}

impl<const N: usize> SampleLocation<N> {
    /// The sites that the sample reads.
    #[inline(always)]
    pub fn sites(&self) -> &[u32] {
        match self {
            Self::Outside => &[],
            Self::AtSite(site) => std::slice::from_ref(site),
            Self::Between(sites, _) => sites,
        }
    }
}

/// One level of sites, each with the samples of its neighbourhood; a sample blends at most N sites.
pub trait Sites<const N: usize>: Sync {
    /// Sites of this level.
    fn count(&self) -> usize;

    /// Sites within the neighbourhood of one, nearest first; the site itself is not among them.
    fn neighbors(&self, site: usize) -> impl Iterator<Item = Neighbor> + '_;

    /// Where the samples of one site fall on its own level, in the order of the neighbourhood's offsets.
    fn samples(&self, site: usize) -> impl Iterator<Item = SampleLocation<N>> + '_;

    /// Where the samples of the parent neighbourhood fall on the coarser level's sites; none at the coarsest
    /// level.
    fn parent_samples(&self, site: usize) -> impl Iterator<Item = SampleLocation<N>> + '_;

    /// Samples per site on its own level.
    fn samples_per_site(&self) -> usize;

    /// Samples per site on the coarser level; 0 at the coarsest.
    fn parent_samples_per_site(&self) -> usize;

    /// Parent points; empty at the coarsest level.
    fn parents(&self) -> &[Parent];

    /// Surface area that each site stands for, in mesh units squared (0 for a site on no surface).
    fn areas(&self) -> &[f32];

    /// Colours known without looking, such that no site reads another of its colour.
    fn known_colors(&self) -> Option<Vec<u32>> {
        None
    }

    /// All sites along scan lines, each beside sites before it as far as it can be, where the target has such
    /// lines. Without, sites are visited breadth first.
    fn scan_lines(&self) -> Option<Vec<u32>> {
        None
    }

    /// The scan lines of a method of one pass. It never repairs the borders of patches where lines run into finished
    /// sites, so these must not be the same places for all lines, as the borders of charts are.
    fn one_pass_lines(&self) -> Option<Vec<u32>> {
        self.scan_lines()
    }

    /// Feeds everything that a result depends on to a hash.
    fn digest(&self, hasher: &mut blake3::Hasher);
}

/// All levels, finest first.
#[derive(Clone, Debug, PartialEq)]
pub struct SiteHierarchy<S> {
    /// Level 0 is the finest.
    pub levels: Vec<S>,
}
