//! The links between near sites: where each lies in the other's (s, t) plane, the same seen from both.

use crate::error::Result;
use crate::mesh::compressed_rows::Rows;
use crate::progress::Progress;
use crate::sites::level::{Neighbor, Sites};

/// Sites at most so far apart are linked, in texels.
const REACH: f32 = 2.3;

/// Sites at most that one is linked to, the nearest.
pub const MOST_LINKS: usize = 24;

/// Links of every site.
#[derive(Clone, Debug, Default)]
pub struct Links {
    /// Where the linked sites lie: the mean of what both ends see.
    pub rows: Rows<Neighbor>,
    /// What a link weighs, so that those of a site weigh 1 on average, each shared by two sites.
    pub weight: f32,
}

impl Links {
    /// The links of a level's sites.
    pub fn new<const N: usize, S: Sites<N>>(sites: &S, progress: Progress<'_>) -> Result<Self> {
        let near = |site: usize| {
            let neighbors = sites.neighbors(site);
            neighbors
                .take(MOST_LINKS)
                .filter(|near| near.x.hypot(near.y) <= REACH)
        };
        let back = |site: usize, from: usize| near(from).find(|back| back.site as usize == site);
        // Both ends must see each other.
        let fill = |(): &mut (), site: usize, row: &mut Vec<Neighbor>| {
            for there in near(site) {
                if let Some(back) = back(site, there.site as usize) {
                    row.push(Neighbor {
                        site: there.site,
                        x: 0.5 * (there.x - back.x),
                        y: 0.5 * (there.y - back.y),
                    });
                }
            }
        };
        let rows = Rows::collect(sites.count(), || (), fill);
        progress.check()?;
        let each = rows.entries.len().max(1) as f32 / sites.count().max(1) as f32;
        Ok(Self {
            rows,
            weight: 2.0 / each,
        })
    }

    /// The links of one site.
    #[inline]
    pub fn of(&self, site: u32) -> &[Neighbor] {
        self.rows.row(site as usize)
    }
}
