//! Tong 2002 §5: a surface texton map by k-coherence, level after level.
//!
//! The coarsest level starts with a random texel at every site and is swept in growing order; with one level
//! alone, it grows from one random texel. Every finer level takes its coordinates from its parents (the
//! paper's first pass) and is refined with windows on both levels (the second), in colour classes. The
//! finest level ends with [seam repair](super::seam_repair).
//!
//! Deviations, each an option that also gives the paper's way: κ > 1 prefers coherent candidates
//! (`--coherence`), with a [floor](super::distance_floor) on distances (`--distance-floor`); texels that
//! the coarsest level uses often are [penalised](super::reuse_penalty) (`--reuse-penalty`); the second
//! pass is repeated (`--passes`).

pub(crate) mod options;

use rand::Rng;
use rayon::prelude::*;

use crate::error::Result;
use crate::exemplar::level::ExemplarLevel;
use crate::grid::TexCoord;
use crate::progress::Progress;
use crate::random;
use crate::sites::coloring::color_classes;
use crate::sites::level::Sites;
use crate::sites::order::growing_order;
use crate::synthesis::check::{self, Plan};
use crate::synthesis::drive::{class_by_class, coarse_to_fine, one_by_one};
use crate::synthesis::inputs::{Inputs, LevelMap};
use crate::synthesis::keep::Preference;
use crate::synthesis::metric::Metric;
use crate::synthesis::metric::of_level::{MetricChoice, WithMetric, with_metric};
use crate::synthesis::options::{Search, SynthesisOptions};
use crate::synthesis::recipes::distance_floor::distance_floor;
use crate::synthesis::recipes::k_coherence::KCoherence;
use crate::synthesis::recipes::reuse_penalty::Uses;
use crate::synthesis::recipes::seam_repair::repair_seams;
use crate::synthesis::state::Texels;

/// Synthesizes all levels and returns the finest.
pub fn tong<const N: usize, S: Sites<N>>(
    inputs: Inputs<'_, S>,
    options: &SynthesisOptions,
    begun: Option<LevelMap>,
    finished: &mut dyn FnMut(&LevelMap) -> Result<()>,
    progress: Progress<'_>,
) -> Result<LevelMap> {
    let plan = check::plan(inputs, options)?;
    let begun = begun.filter(|map| map.level.index() < plan.levels);
    let coarsest = plan.levels - 1;
    let refined = begun.as_ref().map_or(coarsest, |map| map.level.index());
    let run = |level: usize, coarser: Option<LevelMap>, classes: &[Vec<u32>]| {
        let level = LevelRun::<N, S>::new(inputs, options, &plan, level);
        level.run(coarser, classes, progress)
    };
    // The coarsest level is swept site after site; meanwhile the finer ones are coloured.
    let (started, classes) = rayon::join(
        || begun.is_none().then(|| run(coarsest, None, &[])),
        || classes_of::<N, S>(&inputs.sites.levels[..refined], options, progress),
    );
    let (mut started, classes) = (started.transpose()?, classes?);
    coarse_to_fine(
        plan.levels,
        begun,
        finished,
        |level, coarser| match started.take() {
            Some(coords) => Ok(coords),
            None => run(level, coarser, &classes[level]),
        },
    )
}

/// The colour classes of levels; none where nothing is refined.
fn classes_of<const N: usize, S: Sites<N>>(
    levels: &[S],
    options: &SynthesisOptions,
    progress: Progress<'_>,
) -> Result<Vec<Vec<Vec<u32>>>> {
    let of_level = |level: &S| match options.passes > 1 {
        true => color_classes(level, progress),
        false => Ok(Vec::new()),
    };
    levels.par_iter().map(of_level).collect()
}

/// The work on one level.
struct LevelRun<'a, const N: usize, S> {
    inputs: Inputs<'a, S>,
    options: &'a SynthesisOptions,
    level: usize,
    levels: usize,
    exemplar: ExemplarLevel<'a>,
}

impl<'a, const N: usize, S: Sites<N>> LevelRun<'a, N, S> {
    fn new(
        inputs: Inputs<'a, S>,
        options: &'a SynthesisOptions,
        plan: &Plan,
        level: usize,
    ) -> Self {
        let (space, table) = (inputs.space, inputs.table);
        let two_level = level + 1 < plan.levels;
        Self {
            inputs,
            options,
            level,
            levels: plan.levels,
            exemplar: ExemplarLevel::new(space, table, level, plan.k, two_level),
        }
    }

    fn run(
        &self,
        coarser: Option<LevelMap>,
        classes: &[Vec<u32>],
        progress: Progress<'_>,
    ) -> Result<Vec<TexCoord>> {
        let space = self.inputs.space;
        let coarser = coarser.map(|map| Texels::on(&space.levels[self.level + 1], map.coords));
        progress.begin(format!("synthesis, level {}", self.level), self.visits());
        let choice = MetricChoice {
            kind: self.options.metric,
            spectrum: self.options.spectrum,
            searches_all: self.options.k_coherence.search == Search::Full || self.repairs(),
            refines: self.refines(),
            seed: self.options.seed,
        };
        let work = Visits {
            of: self,
            coarser: coarser.as_ref(),
            classes,
            progress,
        };
        let state = with_metric(space, &self.exemplar, self.level, choice, work)??;
        progress.end();
        let grid = self.exemplar.grid;
        let centre = |&at: &TexCoord| grid.centre(grid.texel_nearest(at));
        Ok(match self.level {
            0 => state.coords.iter().map(centre).collect(),
            _ => state.coords,
        })
    }

    /// Whether the level is refined after its first guess.
    fn refines(&self) -> bool {
        self.level + 1 < self.levels && self.options.passes > 1
    }

    /// Whether the level ends with a full search where it fits worst.
    fn repairs(&self) -> bool {
        let by_coherence = self.options.k_coherence.search == Search::KCoherence;
        self.level == 0
            && self.refines()
            && by_coherence
            && self.options.k_coherence.repair_rounds > 0
    }

    /// How many choices the level takes, seam repair apart.
    fn visits(&self) -> u64 {
        let sites = self.inputs.sites.levels[self.level].count() as u64;
        let is_coarsest = self.level + 1 == self.levels;
        match (is_coarsest, self.levels) {
            (true, 1) => sites,
            (true, _) => sites * u64::from(self.options.k_coherence.start_passes),
            (false, _) => sites * u64::from(self.options.passes - 1),
        }
    }
}

/// The visits to a level's sites, whatever the metric.
struct Visits<'a, const N: usize, S> {
    of: &'a LevelRun<'a, N, S>,
    coarser: Option<&'a Texels>,
    classes: &'a [Vec<u32>],
    progress: Progress<'a>,
}

impl<const N: usize, S: Sites<N>> WithMetric for Visits<'_, N, S> {
    type Found = Result<Texels>;

    fn run<M: Metric>(self, metric: &M) -> Result<Texels> {
        let LevelRun {
            options,
            level,
            exemplar,
            ..
        } = self.of;
        let sites = &self.of.inputs.sites.levels[*level];
        let (draw, progress) = ((options.seed, *level as u32), self.progress);
        let mut rule = KCoherence {
            exemplar,
            sites,
            coarser: self.coarser,
            metric,
            search: options.k_coherence.search,
            preference: Preference {
                coherence: options.k_coherence.coherence,
                floor: 0.0,
            },
        };
        rule.preference.floor = distance_floor(&rule, options.k_coherence.distance_floor, draw);
        let Some(coarser) = self.coarser else {
            let state = Texels::random(exemplar, sites.count(), draw);
            return self.start(&rule, state);
        };
        let mut state = Texels::of_parents(exemplar, sites.parents(), coarser);
        if options.passes > 1 {
            let repeated = (self.classes, options.passes - 1);
            class_by_class(&rule, sites, &mut state, repeated, progress)?;
            if self.of.repairs() {
                repair_seams(
                    &rule,
                    &mut state,
                    (self.classes, options.k_coherence.repair_rounds),
                    progress,
                )?;
            }
        }
        Ok(state)
    }
}

impl<const N: usize, S: Sites<N>> Visits<'_, N, S> {
    /// The coarsest level: grown when it is the only one, else swept from a random start.
    fn start<M: Metric>(&self, rule: &KCoherence<'_, N, S, M>, random: Texels) -> Result<Texels> {
        let (options, exemplar) = (self.of.options, &self.of.exemplar);
        let (mut state, sweeps) = match self.of.levels {
            1 => (random.none_done(), 1),
            _ => (random, options.k_coherence.start_passes),
        };
        if state.done.is_none() {
            state.uses = Some(Uses::of(
                exemplar,
                &state.coords,
                options.k_coherence.reuse_penalty,
            ));
        }
        let orders = (0..sweeps).into_par_iter();
        let orders = orders.map(|sweep| self.visiting_order(rule.sites, u64::from(sweep)));
        for order in orders.collect::<Result<Vec<_>>>()? {
            one_by_one(rule, &mut state, &order, self.progress)?;
        }
        Ok(state)
    }

    /// A growing order from a random site.
    fn visiting_order(&self, sites: &S, sweep: u64) -> Result<Vec<u32>> {
        let (options, level) = (self.of.options, self.of.level as u32);
        let count = sites.count();
        let mut stream = random::stream(options.seed, "growth start", level, sweep);
        let start = stream
            .gen_range(0..count.max(1))
            .min(count.saturating_sub(1));
        growing_order(sites, start, options.k_coherence.order, self.progress)
    }
}
