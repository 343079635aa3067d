//! Polishing: a discrete optimisation over a finished map, after Kwatra 2003 and Boykov 2001.
//!
//! Neighbourhood search changes one site at a time. Where two copied patches meet out of step no single site can
//! mend it. Here all sites of a region are offered one copied patch at once: a patch of the region
//! [continued](proposals::Patches::continued) over all of it, or one [laid anew](proposals::laid_anew). A smallest
//! [cut](max_flow) tells which of them take it, so that the seam runs where it costs least.
//!
//! | file | what it does |
//! | --- | --- |
//! | [`links`], [`features`], [`energy`], [`usage`] | what a map costs |
//! | [`region`], [`proposals`] | what a region is offered |
//! | [`max_flow`], [`moves`] | what is taken of it |

mod energy;
mod features;
mod links;
mod max_flow;
mod moves;
mod proposals;
mod region;
mod usage;

use std::cell::RefCell;
use std::sync::Mutex;

use rayon::prelude::*;

use crate::error::Result;
use crate::exemplar::embedding::Embedding;
use crate::exemplar::level::ExemplarLevel;
use crate::grid::TexCoord;
use crate::progress::Progress;
use crate::random;
use crate::sites::level::Sites;
use crate::synthesis::polish::energy::SeamCost;
use crate::synthesis::polish::features::PlaneFeatures;
use crate::synthesis::polish::links::Links;
use crate::synthesis::polish::max_flow::CutGraph;
use crate::synthesis::polish::moves::Judge;
use crate::synthesis::polish::region::{Places, Region};
use crate::synthesis::polish::usage::Usage;

/// Regions judged side by side from what all sites hold when the run begins.
const RUN: usize = 32;

fn env(name: &str, default: f64) -> f64 {
    std::env::var(name).ok().and_then(|v| v.parse().ok()).unwrap_or(default)
}

struct Change {
    sites: Vec<(u32, TexCoord)>,
    saved: f64,
    region: Vec<u32>,
}

/// Polishes a map.
pub fn polish<const N: usize, S: Sites<N>>(
    exemplar: &ExemplarLevel<'_>,
    embedding: &Embedding,
    sites: &S,
    coords: &mut [TexCoord],
    (rounds, seed): (u32, u64),
    progress: Progress<'_>,
) -> Result<()> {
    let features = PlaneFeatures::new(exemplar, embedding);
    let links = Links::new(sites, progress)?;
    let judge = Judge {
        exemplar,
        links: &links,
        seams: SeamCost {
            features: &features,
            grid: exemplar.grid,
            tear: env("P_TEAR", 0.05) as f32,
        },
    };
    let radius = env("P_RADIUS", 9.0) as f32;
    let mut usage = Usage::of(exemplar, coords, env("P_USAGE", 0.1));
    progress.begin("polish", u64::from(rounds) * coords.len() as u64);
    for round in 0..rounds {
        let costs = judge.seams.of_sites(&links, coords);
        let total: f64 = costs.iter().map(|&c| f64::from(c)).sum::<f64>() / 2.0;
        eprintln!("round {round}: seams {:.5} usage {:.5}", total / coords.len() as f64, usage.total() / coords.len() as f64);
        let mut order: Vec<u32> = (0..coords.len() as u32).collect();
        order.sort_by(|&a, &b| costs[b as usize].total_cmp(&costs[a as usize]).then(a.cmp(&b)));
        // centres
        let mut memory = Places::default();
        let mut covered = vec![false; coords.len()];
        let mut centres = Vec::new();
        for &site in &order {
            if !covered[site as usize] {
                centres.push(site);
                let near = Region::round(&links, site, radius * env("P_COVER", 0.5) as f32, &mut memory);
                near.sites.iter().for_each(|&s| covered[s as usize] = true);
            }
        }
        let mut stamps = vec![0u32; coords.len()];
        let mut run = 0;
        let pool = Mutex::new(Vec::<(Places, CutGraph)>::new());
        let mut waiting = centres;
        let (mut taken, mut judged, mut stale) = (0, 0, 0);
        while !waiting.is_empty() {
            run += 1;
            let rest = waiting.split_off(waiting.len().min(RUN));
            let held = &*coords;
            let found: Vec<Change> = waiting
                .par_iter()
                .map(|&centre| {
                    let (mut places, mut graph) = pool.lock().unwrap().pop().unwrap_or_default();
                    let region = Region::round(&links, centre, radius, &mut places);
                    let before: Vec<TexCoord> = region.sites.iter().map(|&s| held[s as usize]).collect();
                    let mut here = before.clone();
                    let mut saved = 0.0;
                    let patches = proposals::Patches::of(&region, exemplar.grid, &here);
                    let mut all: Vec<Vec<TexCoord>> = patches.continued(&region).collect();
                    let mut stream = random::stream(seed, "polish", round, u64::from(centre));
                    let price = |at: TexCoord| usage.price(usage.cell_at(at));
                    all.extend(proposals::laid_anew(&region, exemplar, &judge.seams, &here, price, &mut stream));
                    for proposal in &all {
                        saved += judge.take_part(&region, (&mut here, held), proposal, &usage, &mut graph);
                    }
                    pool.lock().unwrap().push((places, graph));
                    let sites = region.sites.iter().zip(before.iter().zip(&here)).filter(|(_, (b, h))| b != h).map(|(&s, (_, &h))| (s, h)).collect();
                    Change { sites, saved, region: region.sites }
                })
                .collect();
            progress.check()?;
            let mut again = Vec::new();
            for (change, &centre) in found.iter().zip(&waiting) {
                if change.sites.is_empty() { judged += 1; continue; }
                let touched = |&s: &u32| stamps[s as usize] == run || links.of(s).iter().any(|n| stamps[n.site as usize] == run);
                if change.region.iter().any(touched) { again.push(centre); stale += 1; continue; }
                judged += 1;
                let cells = RefCell::new(std::collections::BTreeMap::<usize, f64>::new());
                for &(site, at) in &change.sites {
                    *cells.borrow_mut().entry(usage.cell_at(coords[site as usize])).or_default() -= 1.0;
                    *cells.borrow_mut().entry(usage.cell_at(at)).or_default() += 1.0;
                }
                let cells = cells.into_inner();
                let more = usage.cost_of(cells.iter().map(|(&c, &m)| (c, m)));
                if change.saved - more <= 1e-6 { continue; }
                taken += 1;
                cells.iter().for_each(|(&c, &m)| usage.change(c, m));
                for &(site, at) in &change.sites { coords[site as usize] = at; stamps[site as usize] = run; }
            }
            again.extend(rest);
            waiting = again;
        }
        eprintln!("  judged {judged} taken {taken} stale {stale}");
        progress.advance(coords.len() as u64)?;
    }
    let costs = judge.seams.of_sites(&links, coords);
    let total: f64 = costs.iter().map(|&c| f64::from(c)).sum::<f64>() / 2.0;
    eprintln!("end: seams {:.5} usage {:.5}", total / coords.len() as f64, usage.total() / coords.len() as f64);
    progress.end();
    Ok(())
}
