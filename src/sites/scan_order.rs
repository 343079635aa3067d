//! The order of methods that see only finished sites and need each next one beside some (Ying 2001 §4): along
//! the target's scan lines, else breadth first.

use std::collections::VecDeque;

use crate::error::Result;
use crate::progress::Progress;
use crate::sites::level::Sites;

/// Sites ordered from one look at whether to stop to the next.
const SITES_BETWEEN_CHECKS: usize = 1 << 12;

/// All sites in the order of their visit: the target's scan lines, or breadth first from `start`.
pub fn scan_order<const N: usize, S: Sites<N>>(
    sites: &S,
    start: usize,
    progress: Progress<'_>,
) -> Result<Vec<u32>> {
    match sites.scan_lines() {
        Some(lines) => Ok(lines),
        None => breadth_first(sites, start, progress),
    }
}

/// The same for a method of one pass, which never repairs where lines meet.
pub fn one_pass_order<const N: usize, S: Sites<N>>(
    sites: &S,
    start: usize,
    progress: Progress<'_>,
) -> Result<Vec<u32>> {
    match sites.one_pass_lines() {
        Some(lines) => Ok(lines),
        None => breadth_first(sites, start, progress),
    }
}

/// From `start` on, the neighbours of a site after it, nearest first; a further connected part begins at its
/// first site.
fn breadth_first<const N: usize, S: Sites<N>>(
    sites: &S,
    start: usize,
    progress: Progress<'_>,
) -> Result<Vec<u32>> {
    let count = sites.count();
    let mut reached = vec![false; count];
    let mut order = Vec::with_capacity(count);
    let mut front = VecDeque::new();
    for seed in std::iter::once(start).chain(0..count) {
        if seed >= count || std::mem::replace(&mut reached[seed], true) {
            continue;
        }
        front.push_back(seed as u32);
        while let Some(site) = front.pop_front() {
            if order.len().is_multiple_of(SITES_BETWEEN_CHECKS) {
                progress.check()?;
            }
            order.push(site);
            for near in sites.neighbors(site as usize) {
                if !std::mem::replace(&mut reached[near.site as usize], true) {
                    front.push_back(near.site);
                }
            }
        }
    }
    Ok(order)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::compressed_rows::Rows;
    use crate::neighborhood::Neighborhood;
    use crate::sites::grid::window::SiteGrid;
    use crate::sites::level::Neighbor;
    use crate::sites::vertices::VertexSites;

    /// Paths of sites, each beside the one before and after it.
    fn paths(lengths: &[u32]) -> VertexSites {
        let mut neighbors = Rows::<Neighbor>::default();
        neighbors.starts.push(0);
        let mut first = 0;
        for &length in lengths {
            for site in first..first + length {
                let beside = [site.checked_sub(1), Some(site + 1)].into_iter().flatten();
                let in_path = beside.filter(|near| (first..first + length).contains(near));
                neighbors.entries.extend(in_path.map(|near| Neighbor {
                    site: near,
                    x: near as f32 - site as f32,
                    y: 0.0,
                }));
                neighbors.starts.push(neighbors.entries.len() as u32);
            }
            first += length;
        }
        VertexSites {
            neighbors,
            areas: vec![1.0; first as usize],
            ..VertexSites::default()
        }
    }

    #[test]
    fn sites_come_in_rings_round_the_start_and_part_after_part() {
        let order = scan_order(&paths(&[3, 6]), 5, Progress::silent()).unwrap();
        assert_eq!(order, [5, 4, 6, 3, 7, 8, 0, 1, 2]);
        let order = scan_order(&paths(&[]), 0, Progress::silent()).unwrap();
        assert!(order.is_empty());
    }

    #[test]
    fn a_grid_is_visited_row_by_row() {
        let target = SiteGrid {
            width: 5,
            height: 4,
            toroidal: true,
        };
        let sites = target.hierarchy(&[Neighborhood::square(3, 0)]).unwrap();
        let order = scan_order(&sites.levels[0], 7, Progress::silent()).unwrap();
        assert!(order.into_iter().eq(0..20));
    }
}
