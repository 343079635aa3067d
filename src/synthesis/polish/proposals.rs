//! What all sites of a region could hold together: one copied patch, continued over the region or laid anew.

use rand::Rng;

use crate::exemplar::level::ExemplarLevel;
use crate::grid::{TexCoord, TexelGrid};
use crate::index::TexelIndex;
use crate::random::Stream;
use crate::synthesis::polish::energy::SeamCost;
use crate::synthesis::polish::region::{OUTSIDE, Region};

/// Patches of a region that are continued, the largest of them.
const CONTINUED: usize = 4;
/// Patches drawn, and how many of those that fit best are laid anew.
const DRAWN: usize = 48;
const LAID: usize = 2;
/// Sites of a region at which a drawn patch is held against the map.
const HELD_AGAINST: usize = 48;
/// Texels that a link may be off inside one patch.
const SAME_PATCH: f32 = 1.0;

/// The patches that a region's sites belong to.
#[derive(Clone, Debug, Default)]
pub struct Patches {
    /// The patch of each site.
    of_site: Vec<u32>,
    /// How far each site's coordinate is from its place, the same branch throughout a patch.
    shifts: Vec<[f32; 2]>,
    /// Sites and patch, the largest first.
    sizes: Vec<(usize, u32)>,
}

impl Patches {
    /// Sites that are linked without a tear belong to one patch.
    pub fn of(region: &Region, grid: TexelGrid, coords: &[TexCoord]) -> Self {
        let count = region.sites.len();
        let mut patches = Self {
            of_site: vec![OUTSIDE; count],
            shifts: vec![[0.0; 2]; count],
            sizes: Vec::new(),
        };
        let mut queue = Vec::new();
        for first in 0..count {
            if patches.of_site[first] != OUTSIDE {
                continue;
            }
            let patch = patches.sizes.len() as u32;
            let (at, place) = (coords[first], region.places[first]);
            patches.of_site[first] = patch;
            patches.shifts[first] = [at.s - place[0], at.t - place[1]];
            queue.clear();
            queue.push(first);
            let mut visited = 0;
            while let Some(&at) = queue.get(visited) {
                visited += 1;
                for link in region.links(at) {
                    let other = link.at as usize;
                    if link.at == OUTSIDE || patches.of_site[other] != OUTSIDE {
                        continue;
                    }
                    let (ds, dt) = grid.difference(coords[at], coords[other]);
                    let off = [ds - link.near.x, dt - link.near.y];
                    if off[0].abs().max(off[1].abs()) > SAME_PATCH {
                        continue;
                    }
                    let (here, there) = (region.places[at], region.places[other]);
                    let shift = patches.shifts[at];
                    patches.of_site[other] = patch;
                    patches.shifts[other] = [
                        shift[0] + ds - (there[0] - here[0]),
                        shift[1] + dt - (there[1] - here[1]),
                    ];
                    queue.push(other);
                }
            }
            patches.sizes.push((queue.len(), patch));
        }
        patches.sizes.sort_by_key(|&(size, patch)| (usize::MAX - size, patch));
        patches
    }

    /// The largest patches, each continued over the whole region: a list of coordinates, which may lie off the
    /// grid.
    pub fn continued<'a>(&'a self, region: &'a Region) -> impl Iterator<Item = Vec<TexCoord>> + 'a {
        let worth = self.sizes.len() > 1;
        let largest = self.sizes.iter().take(if worth { CONTINUED } else { 0 });
        largest
            .filter(|&&(size, _)| size > 2)
            .map(|&(_, patch)| self.continue_patch(region, patch))
    }

    /// Every site beyond the patch takes the mean shift of those linked to it that have one: of the patch, and
    /// layer by layer of what is continued.
    fn continue_patch(&self, region: &Region, patch: u32) -> Vec<TexCoord> {
        let count = region.sites.len();
        let is_own = |&at: &usize| self.of_site[at] == patch;
        let mut layer: Vec<usize> = (0..count).filter(is_own).collect();
        let mut shifts = vec![None; count];
        layer.iter().for_each(|&at| shifts[at] = Some(self.shifts[at]));
        while !layer.is_empty() {
            let mut next = Vec::new();
            for &at in &layer {
                for link in region.links(at).iter().filter(|link| link.at != OUTSIDE) {
                    let (x, y) = (link.near.x, link.near.y);
                    if shifts[link.at as usize].is_none() && x.hypot(y) < 1.8 {
                        next.push(link.at as usize);
                    }
                }
            }
            next.sort_unstable();
            next.dedup();
            let found: Vec<_> = next.iter().map(|&at| mean_shift(region, &shifts, at)).collect();
            for (&at, shift) in next.iter().zip(found) {
                shifts[at] = Some(shift);
            }
            layer = next;
        }
        let places = region.places.iter().zip(shifts);
        places
            .map(|(place, shift)| {
                let shift = shift.unwrap_or([f32::NAN; 2]);
                TexCoord {
                    s: place[0] + shift[0],
                    t: place[1] + shift[1],
                }
            })
            .collect()
    }
}

fn mean_shift(region: &Region, shifts: &[Option<[f32; 2]>], at: usize) -> [f32; 2] {
    let (mut sum, mut count) = ([0.0; 2], 0.0f32);
    for link in region.links(at).iter().filter(|link| link.at != OUTSIDE) {
        if let Some(shift) = shifts[link.at as usize] {
            sum = [sum[0] + shift[0], sum[1] + shift[1]];
            count += 1.0;
        }
    }
    sum.map(|sum| sum / count)
}

/// Patches laid anew: of some drawn shifts those that fit best.
///
/// A shift lays a texel near to one that a site holds at that site, or a whole texel drawn at random at the centre.
pub fn laid_anew(
    region: &Region,
    exemplar: &ExemplarLevel<'_>,
    seams: &SeamCost<'_>,
    coords: &[TexCoord],
    price: impl Fn(TexCoord) -> f64,
    stream: &mut Stream,
) -> Vec<Vec<TexCoord>> {
    let grid = exemplar.grid;
    let count = region.sites.len();
    let against: Vec<usize> = (0..HELD_AGAINST.min(count))
        .map(|_| stream.gen_range(0..count))
        .collect();
    let mut drawn: Vec<(f64, [f32; 2])> = (0..DRAWN)
        .map(|number| {
            let (site, texel) = match number % 2 {
                0 => {
                    let site = stream.gen_range(0..count);
                    let near = exemplar.nearest(grid.texel_nearest(coords[site]).0);
                    (site, near[stream.gen_range(0..near.len())])
                }
                _ => {
                    let whole = &exemplar.whole_texels;
                    (0, whole[stream.gen_range(0..whole.len())])
                }
            };
            let (at, place) = (grid.centre(TexelIndex(texel)), region.places[site]);
            [at.s - place[0], at.t - place[1]]
        })
        .map(|shift| {
            let fit = |&at: &usize| {
                let place = region.places[at];
                let there = TexCoord {
                    s: place[0] + shift[0],
                    t: place[1] + shift[1],
                };
                let far = place[0].hypot(place[1]);
                f64::from(far) * 0.1 * f64::from(seams.features.distance(there, coords[at])) + price(there)
            };
            (against.iter().map(fit).sum(), shift)
        })
        .collect();
    drawn.sort_by(|a, b| a.0.total_cmp(&b.0));
    drawn
        .iter()
        .take(LAID)
        .map(|(_, shift)| {
            let places = region.places.iter();
            places
                .map(|place| TexCoord {
                    s: place[0] + shift[0],
                    t: place[1] + shift[1],
                })
                .collect()
        })
        .collect()
}
