//! How badly linked sites fit together.

use rayon::prelude::*;

use crate::grid::{TexCoord, TexelGrid};
use crate::sites::level::Neighbor;
use crate::synthesis::polish::features::PlaneFeatures;
use crate::synthesis::polish::links::Links;

/// Texels that a link may be off before it counts as torn.
pub const TORN: f32 = 1.0;
/// What a torn link costs beside what it shows, texels by chance costing 1. Without, patches are cut up wherever the
/// sample is plain.
const TEAR: f32 = 0.3;

/// How two linked sites are compared.
#[derive(Clone, Copy, Debug)]
pub struct SeamCost<'a> {
    /// The exemplar.
    pub features: &'a PlaneFeatures,
    grid: TexelGrid,
}

impl<'a> SeamCost<'a> {
    /// Costs by an exemplar's features.
    pub fn new(features: &'a PlaneFeatures, grid: TexelGrid) -> Self {
        Self { features, grid }
    }

    /// ‖F(a + ½o) − F(b − ½o)‖ for a site that holds a and one at o from it that holds b, and more if the two are torn.
    ///
    /// It is how different the two are half-way (after Kwatra 2003): 0 inside a copied patch.
    #[inline]
    pub fn between(&self, a: TexCoord, b: TexCoord, [x, y]: [f32; 2]) -> f32 {
        let (ds, dt) = self.grid.difference(a, b);
        let off = (ds - x).abs().max((dt - y).abs());
        if off < 1e-3 {
            return 0.0;
        }
        let moved = |at: TexCoord, share: f32| TexCoord {
            s: at.s + share * x,
            t: at.t + share * y,
        };
        let shown = self.features.distance(moved(a, 0.5), moved(b, -0.5));
        shown + TEAR * (off / TORN).min(1.0)
    }

    /// What a link costs.
    fn of_link(&self, coords: &[TexCoord], site: u32, link: &Neighbor) -> f32 {
        let (a, b) = (coords[site as usize], coords[link.site as usize]);
        self.between(a, b, [link.x, link.y])
    }

    /// What the links of every site cost, each link counted at both ends.
    pub fn of_sites(&self, links: &Links, coords: &[TexCoord]) -> Vec<f32> {
        let of_site = |site: u32| {
            let costs = links.of(site).iter();
            costs
                .map(|link| self.of_link(coords, site, link))
                .sum::<f32>()
                * links.weight
        };
        let sites = (0..coords.len() as u32).into_par_iter();
        sites.map(of_site).collect()
    }
}
