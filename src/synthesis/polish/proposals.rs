//! What all sites of a region could hold together: one copied patch, continued over the region or placed anew.

use rand::Rng;

use crate::grid::{TexCoord, TexelGrid};
use crate::index::TexelIndex;
use crate::random::Stream;
use crate::synthesis::polish::moves::{Here, Judge};
use crate::synthesis::polish::region::{OUTSIDE, Region};
use crate::synthesis::polish::reuse_cost::ReuseCost;
use crate::synthesis::polish::seam_cost::TORN;

/// Patches of a region that are continued, the largest of them.
const CONTINUED: usize = 4;
/// Patches drawn, and how many of those that fit best are placed anew.
const DRAWN: usize = 48;
const LAID: usize = 2;
/// Sites of a region at which a drawn patch is held against the map.
const HELD_AGAINST: usize = 48;
/// Texels from a site to those of the next layer that continue its patch, at the most.
const LAYER: f32 = 1.8;
/// What a difference counts per texel from the centre.
const OF_BORDER: f32 = 0.1;
/// Sites of the smallest patch that is continued.
const SMALLEST: usize = 3;

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
        for first in 0..count {
            if patches.of_site[first] == OUTSIDE {
                let size = patches.grow(region, grid, coords, first);
                patches.sizes.push((size, patches.sizes.len() as u32));
            }
        }
        let largest_first = |&(size, patch): &(usize, u32)| (usize::MAX - size, patch);
        patches.sizes.sort_by_key(largest_first);
        patches
    }

    /// Collects the next patch from its first site on; returns how many sites it has.
    fn grow(
        &mut self,
        region: &Region,
        grid: TexelGrid,
        coords: &[TexCoord],
        first: usize,
    ) -> usize {
        // Begin with the first site's shift.
        let patch = self.sizes.len() as u32;
        let (at, place) = (coords[first], region.places[first]);
        self.of_site[first] = patch;
        self.shifts[first] = [at.s - place[0], at.t - place[1]];
        // Spread over links that copy without a tear.
        let mut queue = vec![first];
        let mut visited = 0;
        while let Some(&at) = queue.get(visited) {
            visited += 1;
            for link in region.links_inside(at) {
                let other = link.at as usize;
                let (ds, dt) = grid.difference(coords[at], coords[other]);
                let off = (ds - link.near.x).abs().max((dt - link.near.y).abs());
                if self.of_site[other] != OUTSIDE || off > TORN {
                    continue;
                }
                let (here, there) = (region.places[at], region.places[other]);
                let [s, t] = self.shifts[at];
                self.of_site[other] = patch;
                self.shifts[other] = [s + ds - (there[0] - here[0]), t + dt - (there[1] - here[1])];
                queue.push(other);
            }
        }
        queue.len()
    }

    /// The largest patches, each continued over the whole region: lists of coordinates, which may lie off the
    /// grid. None where the region is one patch.
    pub fn continued<'a>(&'a self, region: &'a Region) -> impl Iterator<Item = Vec<TexCoord>> + 'a {
        let most = if self.sizes.len() > 1 { CONTINUED } else { 0 };
        let large = self.sizes.iter().take(most);
        let large = large.filter(|&&(size, _)| size >= SMALLEST);
        large.map(|&(_, patch)| self.continue_patch(region, patch))
    }

    /// Layer by layer beyond the patch, every site takes the mean shift of those linked to it that have one.
    fn continue_patch(&self, region: &Region, patch: u32) -> Vec<TexCoord> {
        let count = region.sites.len();
        let mut layer: Vec<usize> = (0..count).filter(|&at| self.of_site[at] == patch).collect();
        let mut shifts = vec![None; count];
        for &at in &layer {
            shifts[at] = Some(self.shifts[at]);
        }
        while !layer.is_empty() {
            let links = layer.iter().flat_map(|&at| region.links_inside(at));
            let near = links.filter(|link| link.near.x.hypot(link.near.y) < LAYER);
            let mut next: Vec<usize> = near.map(|link| link.at as usize).collect();
            next.retain(|&at| shifts[at].is_none());
            next.sort_unstable();
            next.dedup();
            let found: Vec<_> = next
                .iter()
                .map(|&at| mean_shift(region, &shifts, at))
                .collect();
            for (&at, shift) in next.iter().zip(found) {
                shifts[at] = Some(shift);
            }
            layer = next;
        }
        // What the patch does not reach has no coordinate.
        let shift = |at: usize| shifts[at].unwrap_or([f32::NAN; 2]);
        (0..count).map(|at| region.shifted(at, shift(at))).collect()
    }
}

fn mean_shift(region: &Region, shifts: &[Option<[f32; 2]>], at: usize) -> [f32; 2] {
    let near = region
        .links_inside(at)
        .filter_map(|link| shifts[link.at as usize]);
    let (mut sum, mut count) = ([0.0; 2], 0.0f32);
    for [s, t] in near {
        sum = [sum[0] + s, sum[1] + t];
        count += 1.0;
    }
    sum.map(|sum| sum / count)
}

/// Patches placed anew: of some drawn shifts those that fit best.
///
/// Every other shift lays at some site a texel near to that which it holds. The rest lay a whole texel drawn at random
/// at the centre.
pub fn laid_anew(
    judge: &Judge<'_>,
    here: &Here<'_>,
    reuse: &ReuseCost,
    stream: &mut Stream,
) -> Vec<Vec<TexCoord>> {
    let (region, exemplar) = (here.region, judge.exemplar);
    let count = region.sites.len();
    let against = HELD_AGAINST.min(count);
    let against: Vec<usize> = (0..against).map(|_| stream.gen_range(0..count)).collect();
    let draw = |number: usize| {
        let (site, among) = match number % 2 {
            0 => {
                let site = stream.gen_range(0..count);
                let held = exemplar.grid.texel_nearest(here.coords[site]);
                (site, exemplar.nearest(held.0))
            }
            _ => (0, &exemplar.whole_texels[..]),
        };
        let at = exemplar
            .grid
            .centre(TexelIndex(among[stream.gen_range(0..among.len())]));
        let [x, y] = region.places[site];
        [at.s - x, at.t - y]
    };
    // What is near the border should fit what is there; what is within should be little used.
    let misfit = |shift: [f32; 2]| {
        let at_site = |&at: &usize| {
            let [x, y] = region.places[at];
            let there = region.shifted(at, shift);
            let apart = judge.seams.features.distance(there, here.coords[at]);
            f64::from(OF_BORDER * x.hypot(y) * apart) + reuse.price(reuse.cell_at(there))
        };
        against.iter().map(at_site).sum::<f64>()
    };
    let drawn = (0..DRAWN).map(draw);
    let mut drawn: Vec<(f64, [f32; 2])> = drawn.map(|shift| (misfit(shift), shift)).collect();
    drawn.sort_by(|a, b| a.0.total_cmp(&b.0));
    let all =
        |&(_, shift): &(f64, [f32; 2])| (0..count).map(|at| region.shifted(at, shift)).collect();
    drawn.iter().take(LAID).map(all).collect()
}
