//! The order in which the lowest resolution grows (Chen 2008 §3): the site with most synthesized neighbours
//! comes next; of several, the one that had so many first.

use std::collections::VecDeque;

use crate::error::Result;
use crate::progress::Progress;
use crate::sites::level::Sites;

/// Sites ordered from one look at whether to stop to the next.
const SITES_BETWEEN_CHECKS: usize = 1 << 12;

/// All sites, from `start` on; a further connected part begins at its first site.
pub fn most_neighbors_first<const N: usize, S: Sites<N>>(
    sites: &S,
    start: usize,
    progress: Progress<'_>,
) -> Result<Vec<u32>> {
    let count = sites.count();
    let mut counts = vec![0_u32; count];
    let mut visited = vec![false; count];
    let mut order = Vec::with_capacity(count);
    // One queue per number of synthesized neighbours; entries that have moved on are skipped.
    let mut queues: Vec<VecDeque<u32>> = Vec::new();
    for seed in std::iter::once(start)
        .chain(0..count)
        .filter(|&seed| seed < count)
    {
        let mut next = Some(seed as u32);
        let mut top = 0;
        while let Some(site) = next {
            let site = site as usize;
            if !visited[site] {
                if order.len().is_multiple_of(SITES_BETWEEN_CHECKS) {
                    progress.check()?;
                }
                visited[site] = true;
                order.push(site as u32);
                for near in sites.neighbors(site) {
                    let other = near.site as usize;
                    if visited[other] {
                        continue;
                    }
                    counts[other] += 1;
                    let level = counts[other] as usize;
                    if queues.len() <= level {
                        queues.resize_with(level + 1, VecDeque::new);
                    }
                    queues[level].push_back(near.site);
                    top = top.max(level);
                }
            }
            next = loop {
                let Some(queue) = queues.get_mut(top) else {
                    break None;
                };
                match queue.pop_front() {
                    Some(site) if counts[site as usize] as usize == top => break Some(site),
                    Some(_) => {}
                    None if top == 0 => break None,
                    None => top -= 1,
                }
            };
        }
    }
    Ok(order)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::neighborhood::Template;
    use crate::sites::grid::round::RoundGridSites;
    use crate::sites::grid::window::SiteGrid;

    #[test]
    fn every_site_comes_once_and_the_most_constrained_first() {
        let grid = SiteGrid {
            width: 12,
            height: 9,
            toroidal: false,
        };
        let sites = RoundGridSites::new(grid, &Template::round(1), 0, 2);
        let order = most_neighbors_first(&sites, 50, Progress::silent()).unwrap();
        let mut sorted = order.clone();
        sorted.sort_unstable();
        assert!(sorted.into_iter().eq(0..108));
        let mut done = [false; 108];
        for &site in &order {
            let count = |site: usize| {
                let near = sites.neighbors(site);
                near.filter(|near| done[near.site as usize]).count()
            };
            let most = (0..108).filter(|&s| !done[s]).map(count).max().unwrap();
            assert_eq!(count(site as usize), most);
            done[site as usize] = true;
        }
    }
}
