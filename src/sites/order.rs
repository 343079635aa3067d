//! The order in which a level grows from nothing: where most neighbours are done, or along the
//! orientation field.

use std::cmp::Reverse;
use std::collections::{BinaryHeap, VecDeque};

use rand::Rng;
use rayon::prelude::*;
use serde::Serialize;

use crate::error::Result;
use crate::progress::Progress;
use crate::random;
use crate::sites::level::Sites;

/// The order in which a level grows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Order {
    /// The site with the most finished neighbours is next.
    #[default]
    Constrained,
    /// Along the orientation field (Turk 2001).
    Field,
}

/// Sites ordered from one look at whether to stop to the next.
const SITES_BETWEEN_CHECKS: usize = 1 << 12;

/// So many growing orders of a level, each from a random site.
pub fn growing_orders<const N: usize, S: Sites<N>>(
    sites: &S,
    order: Order,
    count: u32,
    (seed, level): (u64, u32),
    progress: Progress<'_>,
) -> Result<Vec<Vec<u32>>> {
    let from_random = |number: u32| {
        let mut stream = random::stream(seed, "growth start", level, u64::from(number));
        let start = stream.gen_range(0..sites.count().max(1));
        growing_order(sites, start, order, progress)
    };
    (0..count).into_par_iter().map(from_random).collect()
}

/// All sites in the order of their visit, from `start` on; a further connected part begins at its
/// first site.
pub fn growing_order<const N: usize, S: Sites<N>>(
    sites: &S,
    start: usize,
    order: Order,
    progress: Progress<'_>,
) -> Result<Vec<u32>> {
    match order {
        Order::Constrained => most_constrained(sites, start, progress),
        Order::Field => along_the_field(sites, start, progress),
    }
}

/// Seeds of connected parts: `start`, then every site in turn.
fn seeds<const N: usize, S: Sites<N>>(
    sites: &S,
    start: usize,
) -> impl Iterator<Item = usize> + use<N, S> {
    std::iter::once(start).chain(0..sites.count())
}

/// The site with most visited neighbours comes next; among equals the one reached first.
fn most_constrained<const N: usize, S: Sites<N>>(
    sites: &S,
    start: usize,
    progress: Progress<'_>,
) -> Result<Vec<u32>> {
    let count = sites.count();
    let mut visited = vec![false; count];
    let mut reached: Vec<(u32, u32)> = vec![(0, 0); count];
    let mut order = Vec::with_capacity(count);
    let (mut queue, mut clock) = (BinaryHeap::new(), 0);
    // Begin anew in every component.
    for seed in seeds(sites, start) {
        queue.push((0, Reverse(0), seed as u32));
        // Visit the site of most visited neighbours.
        while let Some((count, _, site)) = queue.pop() {
            let site = site as usize;
            if visited[site] || count < reached[site].0 {
                continue;
            }
            if order.len().is_multiple_of(SITES_BETWEEN_CHECKS) {
                progress.check()?;
            }
            visited[site] = true;
            order.push(site as u32);
            // Count it among its neighbours' visited ones.
            for neighbor in sites.neighbors(site) {
                let (count, since) = &mut reached[neighbor.site as usize];
                if *count == 0 {
                    clock += 1;
                    *since = clock;
                }
                *count += 1;
                if !visited[neighbor.site as usize] {
                    queue.push((*count, Reverse(*since), neighbor.site));
                }
            }
        }
    }
    Ok(order)
}

/// Of the sites next to visited ones, the one that lies least far along the field comes next
/// (Turk 2001 §4): a site's sweep distance is the mean of what its known neighbours say, theirs
/// plus the way along s from them to it.
fn along_the_field<const N: usize, S: Sites<N>>(
    sites: &S,
    start: usize,
    progress: Progress<'_>,
) -> Result<Vec<u32>> {
    let sweep = sweep_distances(sites, start);
    let mut queued = vec![false; sweep.len()];
    let mut order = Vec::with_capacity(sweep.len());
    let mut frontier = BinaryHeap::new();
    for seed in seeds(sites, start) {
        if queued[seed] {
            continue;
        }
        queued[seed] = true;
        frontier.push(Reverse((Along(sweep[seed]), seed as u32)));
        while let Some(Reverse((_, site))) = frontier.pop() {
            if order.len().is_multiple_of(SITES_BETWEEN_CHECKS) {
                progress.check()?;
            }
            order.push(site);
            for neighbor in sites.neighbors(site as usize) {
                let there = neighbor.site as usize;
                if !std::mem::replace(&mut queued[there], true) {
                    frontier.push(Reverse((Along(sweep[there]), neighbor.site)));
                }
            }
        }
    }
    Ok(order)
}

/// A sweep distance, ordered.
#[derive(PartialEq)]
struct Along(f32);

impl Eq for Along {}

impl PartialOrd for Along {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Along {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.0.total_cmp(&other.0)
    }
}

/// The sweep distance of every site, breadth first from `start`, and from 0 in every further part.
fn sweep_distances<const N: usize, S: Sites<N>>(sites: &S, start: usize) -> Vec<f32> {
    let count = sites.count();
    let mut sweep: Vec<Option<f32>> = vec![None; count];
    for seed in seeds(sites, start) {
        if sweep[seed].is_none() {
            spread(sites, seed, &mut sweep);
        }
    }
    sweep.into_iter().map(Option::unwrap_or_default).collect()
}

/// Fills in the connected part of `seed`.
fn spread<const N: usize, S: Sites<N>>(sites: &S, seed: usize, sweep: &mut [Option<f32>]) {
    let mut queued = VecDeque::from([seed as u32]);
    sweep[seed] = Some(0.0);
    while let Some(site) = queued.pop_front() {
        let here = sweep[site as usize].unwrap_or_default();
        for neighbor in sites.neighbors(site as usize) {
            let there = neighbor.site as usize;
            if sweep[there].is_none() {
                sweep[there] = Some(consensus(sites, there, sweep).unwrap_or(here + neighbor.x));
                queued.push_back(neighbor.site);
            }
        }
    }
}

/// What the known neighbours of a site say of its sweep distance, on average.
fn consensus<const N: usize, S: Sites<N>>(
    sites: &S,
    site: usize,
    sweep: &[Option<f32>],
) -> Option<f32> {
    let (mut sum, mut count) = (0.0, 0.0);
    for neighbor in sites.neighbors(site) {
        if let Some(there) = sweep[neighbor.site as usize] {
            sum += there - neighbor.x;
            count += 1.0;
        }
    }
    (count > 0.0).then(|| sum / count)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::neighborhood::Neighborhood;
    use crate::sites::grid::GridSites;
    use crate::sites::grid::window::SiteGrid;

    fn lists(width: u32, height: u32, toroidal: bool) -> GridSites {
        let target = SiteGrid {
            width,
            height,
            toroidal,
        };
        let neighborhoods = [Neighborhood::square(3, 0)];
        let mut hierarchy = target.hierarchy(&neighborhoods).unwrap();
        hierarchy.levels.remove(0)
    }

    fn is_permutation(order: &[u32], sites: usize) -> bool {
        let mut sorted = order.to_vec();
        sorted.sort_unstable();
        sorted.iter().copied().eq(0..sites as u32)
    }

    #[test]
    fn every_site_is_visited_once() {
        for order in [Order::Constrained, Order::Field] {
            for start in [0, 17, 41] {
                let visited =
                    growing_order(&lists(7, 6, false), start, order, Progress::silent()).unwrap();
                assert!(is_permutation(&visited, 42));
                assert_eq!(visited[0] as usize, start);
            }
        }
    }

    #[test]
    fn the_most_constrained_comes_next() {
        let neighbors = lists(9, 9, true);
        let order = growing_order(&neighbors, 40, Order::Constrained, Progress::silent()).unwrap();
        let mut done = [false; 81];
        for &site in &order {
            let count = |site: usize| {
                let list = neighbors.neighbors(site);
                list.filter(|n| done[n.site as usize]).count()
            };
            let most = (0..81).filter(|&s| !done[s]).map(count).max().unwrap();
            assert_eq!(count(site as usize), most);
            done[site as usize] = true;
        }
    }

    #[test]
    fn the_field_order_sweeps_along_s() {
        let order =
            growing_order(&lists(8, 5, false), 0, Order::Field, Progress::silent()).unwrap();
        let columns: Vec<u32> = order.iter().map(|site| site % 8).collect();
        assert!(columns.is_sorted());
    }
}
