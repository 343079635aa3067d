//! What a progressively-variant texture follows on a target: a transition value per site, and a label where a
//! mask is painted (Zhang 2003 §3).

use crate::sites::level::{Parent, SiteHierarchy, Sites};

/// The controls of one level of sites.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SiteControls {
    /// How far the texture has changed at each site, 0 to 1.
    pub transition: Vec<f32>,
    /// The label that each site must hold, where a mask is painted on the surface.
    pub mask: Option<Vec<u8>>,
}

impl SiteControls {
    /// The controls of every level, finest first: a coarser site has those of the site that lies nearest to it of
    /// the sites whose parent it is.
    pub fn pyramid<const N: usize, S: Sites<N>>(&self, sites: &SiteHierarchy<S>) -> Vec<Self> {
        let mut all = vec![self.clone()];
        for (finer, coarser) in sites.levels.iter().zip(sites.levels.iter().skip(1)) {
            let below = &all[all.len() - 1];
            let source = nearest_children(finer.parents(), coarser);
            all.push(below.taken(&source));
        }
        all
    }

    fn taken(&self, source: &[u32]) -> Self {
        let transition = source.iter().map(|&site| self.transition[site as usize]);
        let labels = |mask: &Vec<u8>| source.iter().map(|&site| mask[site as usize]).collect();
        Self {
            transition: transition.collect(),
            mask: self.mask.as_ref().map(labels),
        }
    }

    /// Feeds them to a hash.
    pub fn digest(&self, hasher: &mut blake3::Hasher) {
        hasher.update(bytemuck::cast_slice(&self.transition));
        hasher.update(self.mask.as_deref().unwrap_or_default());
    }
}

/// The finer site nearest to every coarser one of those whose parent it is. A coarser site that is no parent has
/// that of its nearest neighbour that is one; without any, the first site's.
fn nearest_children<const N: usize, S: Sites<N>>(parents: &[Parent], coarser: &S) -> Vec<u32> {
    let mut nearest = vec![(f32::INFINITY, None); coarser.count()];
    for (site, parent) in (0..).zip(parents) {
        let away = parent.x.hypot(parent.y);
        let held = &mut nearest[parent.site as usize];
        if away < held.0 {
            *held = (away, Some(site));
        }
    }
    let of_neighbor = |site| {
        let mut neighbors = coarser.neighbors(site);
        neighbors.find_map(|near| nearest[near.site as usize].1)
    };
    let child = |site: usize| nearest[site].1.or_else(|| of_neighbor(site)).unwrap_or(0);
    (0..coarser.count()).map(child).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::neighborhood::Neighborhood;
    use crate::sites::grid::window::SiteGrid;

    #[test]
    fn coarser_sites_have_the_controls_of_a_site_below_them() {
        let target = SiteGrid {
            width: 8,
            height: 6,
            toroidal: false,
        };
        let neighborhoods = [Neighborhood::square(3, 3), Neighborhood::square(3, 0)];
        let sites = target.hierarchy(&neighborhoods).unwrap();
        let controls = SiteControls {
            transition: (0..48).map(|site| (site % 8) as f32 / 7.0).collect(),
            mask: Some((0..48).map(|site| u8::from(site >= 24)).collect()),
        };
        let levels = controls.pyramid(&sites);
        assert_eq!(levels.len(), 2);
        assert_eq!(levels[0], controls);
        let coarse = &levels[1];
        assert_eq!(coarse.transition.len(), sites.levels[1].count());
        let mask = coarse.mask.as_ref().unwrap();
        for (site, (&value, &label)) in coarse.transition.iter().zip(mask).enumerate() {
            let (row, col) = (site / 4, site % 4);
            let below = [2 * col, 2 * col + 1].map(|col| col as f32 / 7.0);
            assert!(below.contains(&value), "{site}: {value}");
            // Rows 2 and 3 of the finer level are on both sides of the edge of the mask.
            assert!(row == 1 || label == u8::from(row == 2), "{site}");
        }
    }
}
