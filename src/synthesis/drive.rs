//! The drivers: in which order and how often the sites of the levels are visited, whatever the rule.

use std::sync::{Mutex, PoisonError};

use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::index::Level;
use crate::progress::Progress;
use crate::sites::level::Sites;
use crate::synthesis::changes::Changes;
use crate::synthesis::inputs::{LevelContent, LevelMap};
use crate::synthesis::rule::{Foreseen, Rule};

/// Visits sites in an order, each seeing what all others hold by then.
pub fn one_by_one<R: Rule>(
    rule: &R,
    state: &mut R::State,
    order: &[u32],
    progress: Progress<'_>,
) -> Result<()> {
    const STEP: usize = 256;
    let mut scratch = R::Scratch::default();
    for (visit, &site) in order.iter().enumerate() {
        if visit % STEP == STEP - 1 {
            progress.advance(STEP as u64)?;
        }
        progress.check()?;
        let take = rule.choose(state, site as usize, &mut scratch);
        rule.set(state, site as usize, take);
    }
    Ok(())
}

/// Visits sites in an order, each seeing what all others hold by then: the same as [`one_by_one`], in parallel.
///
/// The sites of a run are decided side by side, from what all hold when it begins. Then they are set one after another.
/// A decision that would be another by then, because of what was set before it in the run, is made again.
pub fn run_by_run<R: Foreseen>(
    rule: &R,
    state: &mut R::State,
    order: &[u32],
    progress: Progress<'_>,
) -> Result<()> {
    let mut again = R::Scratch::default();
    for run in order.chunks(rule.run().max(1)) {
        rule.begin_run(state);
        let held = &*state;
        let choose = |scratch: &mut R::Scratch, &site: &u32| match progress.is_interrupted() {
            true => R::Take::default(),
            false => rule.choose(held, site as usize, scratch),
        };
        let sites = run.par_iter().with_min_len(rule.batch());
        let chosen: Vec<R::Take> = sites.map_init(R::Scratch::default, choose).collect();
        progress.check()?;
        for (&site, take) in run.iter().zip(chosen) {
            let site = site as usize;
            let take = match rule.stands(state, site, take) {
                true => take,
                false => rule.choose(state, site, &mut again),
            };
            rule.set(state, site, take);
        }
        progress.advance(run.len() as u64)?;
    }
    Ok(())
}

/// Visits classes of sites that read nothing of each other, in parallel inside a class, `passes` times: the
/// same as visiting one by one in the order of the classes. Sites that nothing they read has changed for
/// are skipped.
pub fn class_by_class<const N: usize, S: Sites<N>, R: Rule>(
    rule: &R,
    sites: &S,
    state: &mut R::State,
    (classes, passes): (&[Vec<u32>], u32),
    progress: Progress<'_>,
) -> Result<()> {
    let pool = Mutex::new(Vec::<R::Scratch>::new());
    let mut changes = Changes::new(sites.count(), classes.len());
    let batch = rule.batch();
    let mut chosen = Vec::new();
    // Choose for all sites of a class, in parallel.
    for class in (0..passes).flat_map(|_| classes) {
        changes.next_class();
        chosen.clear();
        chosen.resize(class.len(), R::Take::default());
        let batches = chosen.par_chunks_mut(batch).zip(class.par_chunks(batch));
        batches.for_each(|(chosen, batch)| {
            if progress.is_interrupted() {
                return;
            }
            let taken = pool.lock().unwrap_or_else(PoisonError::into_inner).pop();
            let mut scratch = taken.unwrap_or_default();
            for (take, &site) in chosen.iter_mut().zip(batch) {
                let site = site as usize;
                *take = match changes.is_settled(sites, site) {
                    true => rule.held(state, site),
                    false => rule.choose(state, site, &mut scratch),
                };
            }
            let mut spare = pool.lock().unwrap_or_else(PoisonError::into_inner);
            spare.push(scratch);
        });
        progress.check()?;
        // Then set them.
        for (&site, &take) in class.iter().zip(&chosen) {
            let site = site as usize;
            if take != rule.held(state, site) {
                rule.set(state, site, take);
                changes.changed(site);
            }
        }
        progress.advance(class.len() as u64)?;
    }
    Ok(())
}

/// Visits sites once, wave after wave, in parallel inside a wave: the same as visiting one by one in the order of the
/// waves, where no site of a wave reads another of it.
pub fn wave_by_wave<R: Rule>(
    rule: &R,
    state: &mut R::State,
    waves: &[Vec<u32>],
    progress: Progress<'_>,
) -> Result<()> {
    for wave in waves {
        let held = &*state;
        let choose = |scratch: &mut R::Scratch, &site: &u32| match progress.is_interrupted() {
            true => R::Take::default(),
            false => rule.choose(held, site as usize, scratch),
        };
        let sites = wave.par_iter().with_min_len(rule.batch());
        let chosen: Vec<R::Take> = sites.map_init(R::Scratch::default, choose).collect();
        progress.check()?;
        for (&site, take) in wave.iter().zip(chosen) {
            rule.set(state, site as usize, take);
        }
        progress.advance(wave.len() as u64)?;
    }
    Ok(())
}

/// Runs level after level, the coarsest first, from `begun` on where a level is there already; `finished` is
/// handed every level when it is done.
pub fn coarse_to_fine<C: Into<LevelContent>>(
    levels: usize,
    begun: Option<LevelMap>,
    finished: &mut dyn FnMut(&LevelMap) -> Result<()>,
    mut level: impl FnMut(usize, Option<LevelMap>) -> Result<C>,
) -> Result<LevelMap> {
    let mut before = begun;
    let first = before.as_ref().map_or(levels, |map| map.level.index());
    for number in (0..first).rev() {
        let LevelContent { coords, searched } = level(number, before.take())?.into();
        let map = LevelMap {
            level: Level(number as u32),
            coords,
            searched,
        };
        finished(&map)?;
        before = Some(map);
    }
    before.ok_or_else(|| Error::option("levels", "0", "1 or more"))
}
