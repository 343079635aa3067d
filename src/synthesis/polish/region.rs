//! The sites round one, flattened into the plane of the orientation field, with the links among them.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use crate::grid::TexCoord;
use crate::sites::level::Neighbor;
use crate::synthesis::polish::links::Links;

/// Most sites of a region.
const MOST: usize = 1000;
/// Outside the region.
pub const OUTSIDE: u32 = u32::MAX;

/// A region of sites.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Region {
    /// The sites, nearest first.
    pub sites: Vec<u32>,
    /// Where each lies, the first at the origin, in texels.
    pub places: Vec<[f32; 2]>,
    /// Where the links of each site begin; one more entry than sites.
    starts: Vec<u32>,
    links: Vec<RegionLink>,
}

/// A link of a region's site.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RegionLink {
    /// The linked site's place in the region's list, or [`OUTSIDE`].
    pub at: u32,
    /// It, and where it lies.
    pub near: Neighbor,
}

/// Working memory: which sites are in the region that is being collected, four bytes per site.
#[derive(Clone, Debug, Default)]
pub struct Places {
    of_site: Vec<u32>,
    queue: BinaryHeap<Reverse<(u32, u32)>>,
}

impl Region {
    /// The sites at most `radius` texels from a centre.
    ///
    /// Nearest first, each lies at the mean of where the sites before it see it: distances and turns of the
    /// field between them are evened out as the region grows.
    pub fn round(links: &Links, centre: u32, radius: f32, memory: &mut Places) -> Self {
        // Begin with the centre.
        let mut region = Self::default();
        let Places { of_site, queue } = memory;
        of_site.resize(links.rows.starts.len(), OUTSIDE);
        queue.clear();
        queue.push(Reverse((0, centre)));
        // Add the nearest site that is seen, until the radius or the limit.
        while let Some(Reverse((_, site))) = queue.pop() {
            if of_site[site as usize] != OUTSIDE || region.sites.len() == MOST {
                continue;
            }
            let place = region.seen_at(links, site, of_site);
            let distance = place[0].hypot(place[1]);
            if distance > radius {
                continue;
            }
            of_site[site as usize] = region.sites.len() as u32;
            region.sites.push(site);
            region.places.push(place);
            for near in links.of(site) {
                if of_site[near.site as usize] == OUTSIDE {
                    let guess = (place[0] + near.x).hypot(place[1] + near.y);
                    queue.push(Reverse((guess.to_bits(), near.site)));
                }
            }
        }
        // Link the sites, and leave the memory as it was.
        region.link(links, of_site);
        region
            .sites
            .iter()
            .for_each(|&site| of_site[site as usize] = OUTSIDE);
        region
    }

    /// The links of one of the sites.
    pub fn links(&self, at: usize) -> &[RegionLink] {
        &self.links[self.starts[at] as usize..self.starts[at + 1] as usize]
    }

    /// Those of its links that stay inside.
    pub fn links_inside(&self, at: usize) -> impl Iterator<Item = &RegionLink> {
        self.links(at).iter().filter(|link| link.at != OUTSIDE)
    }

    /// A site's place, shifted into the exemplar.
    pub fn shifted(&self, at: usize, shift: [f32; 2]) -> TexCoord {
        let [x, y] = self.places[at];
        TexCoord {
            s: x + shift[0],
            t: y + shift[1],
        }
    }

    /// Where the sites that are placed see another.
    fn seen_at(&self, links: &Links, site: u32, of_site: &[u32]) -> [f32; 2] {
        let (mut sum, mut weights) = ([0.0; 2], 0.0f32);
        for near in links.of(site) {
            let Some(place) = self.places.get(of_site[near.site as usize] as usize) else {
                continue;
            };
            let weight = 1.0 / (0.05 + near.x * near.x + near.y * near.y);
            sum[0] += weight * (place[0] - near.x);
            sum[1] += weight * (place[1] - near.y);
            weights += weight;
        }
        match weights > 0.0 {
            true => sum.map(|sum| sum / weights),
            false => [0.0; 2],
        }
    }

    fn link(&mut self, links: &Links, of_site: &[u32]) {
        self.starts.push(0);
        for &site in &self.sites {
            let row = links.of(site).iter();
            self.links.extend(row.map(|&near| RegionLink {
                at: of_site[near.site as usize],
                near,
            }));
            self.starts.push(self.links.len() as u32);
        }
    }
}
