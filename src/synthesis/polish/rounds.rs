//! Rounds: regions that cover all sites, the worst first, each offered patches once.

use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};

use rayon::prelude::*;

use crate::error::Result;
use crate::grid::TexCoord;
use crate::progress::Progress;
use crate::random;
use crate::synthesis::polish::max_flow::CutGraph;
use crate::synthesis::polish::moves::{Here, Judge};
use crate::synthesis::polish::proposals::{Patches, laid_anew};
use crate::synthesis::polish::region::{Places, Region};
use crate::synthesis::polish::repeats::repeated;
use crate::synthesis::polish::reuse_cost::ReuseCost;

/// Texels from a region's centre to its border: a patch as wide as the features of most samples.
const RADIUS: f32 = 12.0;
/// Texels from a centre within which no other is needed.
const COVERED: f32 = 0.7 * RADIUS;
/// The share of a region's sites above which its texels count as repeated.
const REPEATED: f32 = 0.2;
/// Regions that are judged side by side, from what all sites hold when the run begins.
const RUN: usize = 32;
/// A gain less than this is rounding.
const LEAST_GAIN: f64 = 1e-6;

/// The work on a map.
pub struct Rounds<'a, 'c> {
    judge: Judge<'a>,
    coords: &'c mut [TexCoord],
    reuse: ReuseCost,
    seed: u64,
    /// The last run in which each site changed.
    changed: Vec<u32>,
    run: u32,
    memory: Mutex<Vec<Memory>>,
}

/// Working memory of one thread.
#[derive(Default)]
struct Memory {
    places: Places,
    graph: CutGraph,
}

/// What a region would take.
#[derive(Default)]
struct Change {
    region: Vec<u32>,
    sites: Vec<(u32, TexCoord)>,
    /// What seams cost less then.
    saved: f64,
}

impl<'a, 'c> Rounds<'a, 'c> {
    /// Begins with what the sites hold.
    pub fn new(judge: Judge<'a>, coords: &'c mut [TexCoord], reuse: ReuseCost, seed: u64) -> Self {
        Self {
            judge,
            changed: vec![0; coords.len()],
            coords,
            reuse,
            seed,
            run: 0,
            memory: Mutex::default(),
        }
    }

    /// What the map costs per site: seams, each shared by two sites, and reuse.
    pub fn cost(&self) -> f64 {
        let seams = self.judge.seams.of_sites(self.judge.links, self.coords);
        let seams: f64 = seams.iter().map(|&cost| f64::from(cost)).sum();
        (0.5 * seams + self.reuse.total()) / self.coords.len().max(1) as f64
    }

    /// A round over the regions where texels are repeated.
    pub fn round_where_repeated(&mut self, progress: Progress<'_>) -> Result<()> {
        let mut centres = self.centres();
        let mut places = Places::default();
        centres.retain(|&centre| {
            let region = Region::round(self.judge.links, centre, RADIUS, &mut places);
            repeated(self.judge.exemplar.grid, &region, self.coords) > REPEATED
        });
        self.offer(0, centres, progress)
    }

    /// A round over all regions.
    pub fn round(&mut self, round: u32, progress: Progress<'_>) -> Result<()> {
        let centres = self.centres();
        self.offer(round, centres, progress)
    }

    /// Regions are judged in runs, side by side, and then changed one after another. One that reads a site
    /// changed in the same run waits for the next.
    fn offer(&mut self, round: u32, mut waiting: Vec<u32>, progress: Progress<'_>) -> Result<()> {
        progress.begin(format!("polish, round {}", round + 1), waiting.len() as u64);
        while !waiting.is_empty() {
            let later = waiting.split_off(waiting.len().min(RUN));
            let judged = |&centre: &u32| match progress.is_interrupted() {
                true => Change::default(),
                false => self.judged(round, centre),
            };
            let changes: Vec<Change> = waiting.par_iter().map(judged).collect();
            progress.check()?;
            self.run += 1;
            let mut again = Vec::new();
            for (&centre, change) in waiting.iter().zip(&changes) {
                match self.is_outdated(change) {
                    true => again.push(centre),
                    false => self.make(change),
                }
            }
            progress.advance((waiting.len() - again.len()) as u64)?;
            again.extend(later);
            waiting = again;
        }
        progress.end();
        Ok(())
    }

    /// Centres of regions that cover all sites, those with the costliest seams first.
    fn centres(&self) -> Vec<u32> {
        let costs = self.judge.seams.of_sites(self.judge.links, self.coords);
        let cost = |site: u32| costs[site as usize];
        let mut order: Vec<u32> = (0..self.coords.len() as u32).collect();
        order.par_sort_by(|&a, &b| cost(b).total_cmp(&cost(a)).then(a.cmp(&b)));
        let mut places = Places::default();
        let mut is_covered = vec![false; order.len()];
        order.retain(|&site| {
            let is_centre = !is_covered[site as usize];
            if is_centre {
                let near = Region::round(self.judge.links, site, COVERED, &mut places);
                near.sites
                    .iter()
                    .for_each(|&near| is_covered[near as usize] = true);
            }
            is_centre
        });
        order
    }

    /// What a region would take of what it is offered.
    fn judged(&self, round: u32, centre: u32) -> Change {
        let mut memory = self.lock().pop().unwrap_or_default();
        let region = Region::round(self.judge.links, centre, RADIUS, &mut memory.places);
        let held = |&site: &u32| self.coords[site as usize];
        let before: Vec<TexCoord> = region.sites.iter().map(held).collect();
        let mut here = Here {
            region: &region,
            coords: before.clone(),
            map: self.coords,
        };
        let mut stream = random::stream(self.seed, "polish", round, u64::from(centre));
        let anew = laid_anew(&self.judge, &here, &self.reuse, &mut stream);
        let patches = Patches::of(&region, self.judge.exemplar.grid, &before);
        let mut saved = 0.0;
        for proposal in patches.continued(&region).chain(anew) {
            let (reuse, graph) = (&self.reuse, &mut memory.graph);
            saved += self.judge.take_part(&mut here, &proposal, reuse, graph);
        }
        let now = region.sites.iter().zip(before.iter().zip(&here.coords));
        let sites = now
            .filter(|(_, (before, now))| before != now)
            .map(|(&site, (_, &now))| (site, now))
            .collect();
        self.lock().push(memory);
        Change {
            sites,
            saved,
            region: region.sites,
        }
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, Vec<Memory>> {
        self.memory.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Whether a change was judged by what a site no longer holds.
    fn is_outdated(&self, change: &Change) -> bool {
        let has_changed = |site: u32| self.changed[site as usize] == self.run;
        let reads_changed = |&site: &u32| {
            let mut near = self.judge.links.of(site).iter();
            has_changed(site) || near.any(|near| has_changed(near.site))
        };
        !change.sites.is_empty() && change.region.iter().any(reads_changed)
    }

    /// Makes a change, if the cost of reuse does not outweigh what it saves by now.
    fn make(&mut self, change: &Change) {
        let mut cells = BTreeMap::new();
        for &(site, at) in &change.sites {
            let held = self.coords[site as usize];
            for (at, more) in [(held, -1.0), (at, 1.0)] {
                *cells.entry(self.reuse.cell_at(at)).or_insert(0.0) += more;
            }
        }
        let dearer = self.reuse.cost_of(&cells);
        if change.saved - dearer < LEAST_GAIN {
            return;
        }
        self.reuse.change(&cells);
        for &(site, at) in &change.sites {
            self.coords[site as usize] = at;
            self.changed[site as usize] = self.run;
        }
    }
}
