//! Tong 2002 §5: a surface texton map by k-coherence, level after level.
//!
//! The coarsest level starts with random texels and is swept in growing order; alone, it grows from one random
//! texel. Every finer level takes its coordinates from its parents (the paper's first pass) and is refined with
//! windows on both levels (the second). The finest level ends with [seam repair](super::seam_repair)
//! and, where the sample does not tile or when asked for, is [polished](crate::synthesis::polish).
//!
//! Deviations, each an option that also gives the paper's way: κ > 1 prefers coherent candidates
//! (`--coherence`), with a [floor](super::distance_floor) on distances (`--distance-floor`); texels that
//! the coarsest level uses often, and textons that finer levels do, are [penalised](super::reuse_penalty)
//! (`--reuse-penalty`); the second pass is repeated (`--passes`).

pub(crate) mod options;
mod passes;

use rayon::prelude::*;

use crate::error::Result;
use crate::exemplar::embedding::Embedding;
use crate::exemplar::level::ExemplarLevel;
use crate::exemplar::space::{Features, Space};
use crate::grid::TexCoord;
use crate::progress::Progress;
use crate::sites::coloring::color_classes;
use crate::sites::level::Sites;
use crate::sites::order::growing_orders;
use crate::synthesis::check::{Plan, check_sites, table_windows};
use crate::synthesis::drive::{class_by_class, coarse_to_fine, one_by_one};
use crate::synthesis::inputs::{Inputs, LevelMap};
use crate::synthesis::keep::Preference;
use crate::synthesis::method::{Figure, MethodDescription, Workload};
use crate::synthesis::metric::Metric;
use crate::synthesis::metric::of_level::{MetricChoice, WithMetric, with_metric};
use crate::synthesis::options::{CandidateSearch, SynthesisOptions};
use crate::synthesis::polish::{Effort, SITE_BYTES, polish};
use crate::synthesis::recipes::distance_floor::distance_floor;
use crate::synthesis::recipes::k_coherence::KCoherence;
use crate::synthesis::recipes::reuse_penalty::Uses;
use crate::synthesis::recipes::seam_repair::repair_seams;
use crate::synthesis::recipes::tong::passes::Passes;
use crate::synthesis::state::Texels;

/// Rounds that `--polish auto` amounts to: none of a sample that tiles, about a third of one of others.
const AUTO_POLISH: f64 = 0.15;

/// The method, as the rest of the program sees it.
pub const DESCRIPTION: MethodDescription = MethodDescription {
    name: "k-coherence",
    help: "Tong 2002: coherent texels and the nearest of each, level after level",
    own_options: Some(|options| &options.k_coherence),
    figures: &[Figure::K, Figure::MetricAgreement],
    microseconds,
    bytes: polish_bytes,
    ..MethodDescription::PLAIN
};

/// Microseconds per site: those of the search, and of each round of polishing.
fn microseconds(work: Workload, options: &SynthesisOptions) -> f64 {
    let choices = match options.k_coherence.search {
        CandidateSearch::KCoherence if work.onto_atlas => 70.0,
        CandidateSearch::KCoherence => 97.0,
        CandidateSearch::Full => work.full_search(),
    };
    let rounds = match options.k_coherence.polish {
        Effort::Auto => AUTO_POLISH,
        Effort::Rounds(rounds) => f64::from(rounds),
    };
    choices + 320.0 * rounds
}

/// Bytes that polishing takes.
fn polish_bytes(space: &Space, sites: u64, options: &SynthesisOptions) -> u64 {
    match options.k_coherence.polish.rounds(space.tileable()) {
        0 => 0,
        _ => SITE_BYTES * sites,
    }
}

/// Synthesizes all levels and returns the finest.
pub fn synthesize<const N: usize, S: Sites<N>>(
    inputs: Inputs<'_, S>,
    (options, plan): (&SynthesisOptions, &Plan),
    begun: Option<LevelMap>,
    finished: &mut dyn FnMut(&LevelMap) -> Result<()>,
    progress: Progress<'_>,
) -> Result<LevelMap> {
    check_sites(inputs.sites, &table_windows(inputs.table, plan))?;
    let begun = begun.filter(|map| map.level.index() < plan.levels);
    let coarsest = plan.levels - 1;
    let refined = begun.as_ref().map_or(coarsest, |map| map.level.index());
    let run = |level: usize, coarser: Option<LevelMap>, classes: &[Vec<u32>]| {
        let passes = Passes::of(options, level, plan.levels);
        run_level(inputs, (passes, plan.k), coarser, classes, progress)
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

/// The work on one level, whatever the metric.
struct LevelRun<'a, const N: usize, S> {
    exemplar: &'a ExemplarLevel<'a>,
    sites: &'a S,
    coarser: Option<&'a Texels>,
    /// Whether texels have textons, which can be counted.
    has_textons: bool,
    classes: &'a [Vec<u32>],
    passes: Passes<'a>,
    progress: Progress<'a>,
}

/// Synthesizes one level.
fn run_level<const N: usize, S: Sites<N>>(
    inputs: Inputs<'_, S>,
    (passes, k): (Passes<'_>, usize),
    coarser: Option<LevelMap>,
    classes: &[Vec<u32>],
    progress: Progress<'_>,
) -> Result<Vec<TexCoord>> {
    let Passes { options, level, .. } = passes;
    // Prepare the exemplar, and what the coarser level holds.
    let (space, sites) = (inputs.space, &inputs.sites.levels[level]);
    let exemplar = ExemplarLevel::new(space, inputs.table, level, k, passes.is_fine());
    let coarser = coarser.map(|map| Texels::on(&space.levels[level + 1], map.coords));
    progress.begin(
        format!("synthesis, level {level}"),
        passes.visits(sites.count()),
    );
    // Synthesize with the metric of the options.
    let choice = MetricChoice {
        kind: options.metric,
        spectrum: options.spectrum,
        searches_all: passes.searches() || passes.repairs(),
        refines: passes.refines(),
        seed: options.seed,
    };
    let work = LevelRun::<N, S> {
        exemplar: &exemplar,
        sites,
        coarser: coarser.as_ref(),
        has_textons: matches!(space.levels[level].features, Features::Textons { .. }),
        classes,
        passes,
        progress,
    };
    let state = with_metric(space, &exemplar, level, choice, work)??;
    progress.end();
    if level > 0 {
        return Ok(state.coords);
    }
    // Polish the finest level.
    let mut coords = state.at_centres(exemplar.grid);
    let effort = options.k_coherence.polish;
    if effort.rounds(exemplar.grid.tileable) > 0 {
        let embedding = Embedding::new(&space.levels[0], options.spectrum);
        let effort = (effort, options.seed);
        polish(
            (&exemplar, &embedding),
            sites,
            &mut coords,
            effort,
            progress,
        )?;
    }
    Ok(coords)
}

impl<const N: usize, S: Sites<N>> WithMetric for LevelRun<'_, N, S> {
    type Found = Result<Texels>;

    fn run<M: Metric>(self, metric: &M) -> Result<Texels> {
        let (exemplar, sites, progress) = (self.exemplar, self.sites, self.progress);
        let SynthesisOptions {
            k_coherence: asked,
            passes,
            seed,
            ..
        } = self.passes.options;
        let draw = (*seed, self.passes.level as u32);
        // Set up the rule, with a distance floor measured on this start.
        let mut rule = KCoherence {
            exemplar,
            sites,
            coarser: self.coarser,
            metric,
            search: asked.search,
            preference: Preference {
                coherence: asked.coherence,
                floor: 0.0,
            },
        };
        rule.preference.floor = distance_floor(&rule, asked.distance_floor, draw);
        let Some(coarser) = self.coarser else {
            return self.start(&rule, Texels::random(exemplar, sites.count(), draw));
        };
        // Start from the parents.
        let mut state = Texels::of_parents(exemplar, sites.parents(), coarser);
        if self.has_textons && asked.reuse_penalty > 0.0 && !self.passes.searches() {
            let uses = Uses::of_textons(exemplar, &state.coords, asked.reuse_penalty);
            state.uses = Some(uses);
        }
        // Refine.
        if self.passes.refines() {
            let visits = (self.classes, passes - 1);
            class_by_class(&rule, sites, &mut state, visits, progress)?;
        }
        // Repair seams.
        if self.passes.repairs() {
            let visits = (self.classes, asked.repair_rounds);
            repair_seams(&rule, &mut state, visits, progress)?;
        }
        Ok(state)
    }
}

impl<const N: usize, S: Sites<N>> LevelRun<'_, N, S> {
    /// The coarsest level: grown when it is the only one, else swept from a random start.
    fn start<M: Metric>(&self, rule: &KCoherence<'_, N, S, M>, random: Texels) -> Result<Texels> {
        let Passes {
            options,
            level,
            levels,
        } = self.passes;
        let asked = &options.k_coherence;
        let (mut state, sweeps) = match levels {
            1 => (random.none_done(), 1),
            _ => (random, asked.start_passes),
        };
        if state.done.is_none() {
            let uses = Uses::of_texels(self.exemplar, &state.coords, asked.reuse_penalty);
            state.uses = Some(uses);
        }
        let draw = (options.seed, level as u32);
        for order in growing_orders(self.sites, asked.order, sweeps, draw, self.progress)? {
            one_by_one(rule, &mut state, &order, self.progress)?;
        }
        Ok(state)
    }
}
