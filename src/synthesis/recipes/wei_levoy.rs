//! Wei and Levoy 2001, *Texture Synthesis over Arbitrary Manifold Surfaces*: at every site the whole exemplar is
//! searched for the texel whose neighbourhood is most similar, level after level.
//!
//! The coarsest level starts from random texels, a finer one from its parents; then every site chooses anew,
//! `--passes` − 1 times, with windows on its own and on the coarser level (their §3.3). The plainest
//! method there is: the baseline of others' figures, and the example in docs/extending.md.
//!
//! Deviations: sites are visited by colour classes in place of a random order, so that a class is searched in
//! parallel; exact bounds replace their tree of vectors, so the best texel is always found.

use crate::error::Result;
use crate::exemplar::level::ExemplarLevel;
use crate::grid::TexCoord;
use crate::index::TexelIndex;
use crate::progress::Progress;
use crate::sites::coloring::color_classes;
use crate::sites::level::Sites;
use crate::synthesis::check::{Plan, check_sites, table_windows};
use crate::synthesis::drive::{class_by_class, coarse_to_fine};
use crate::synthesis::inputs::{Inputs, LevelMap};
use crate::synthesis::keep::Preference;
use crate::synthesis::method::MethodDescription;
use crate::synthesis::metric::Metric;
use crate::synthesis::metric::of_level::{MetricChoice, WithMetric, with_metric};
use crate::synthesis::metric::site_values::{SiteNeighborhood, Unfinished};
use crate::synthesis::options::SynthesisOptions;
use crate::synthesis::rule::Rule;
use crate::synthesis::state::Texels;

/// The method, as the rest of the program sees it.
pub const DESCRIPTION: MethodDescription = MethodDescription {
    name: "wei-levoy",
    help: "Wei and Levoy 2001: every texel is compared at every site; slow, for comparison",
    ..MethodDescription::PLAIN
};

/// Synthesizes all levels and returns the finest.
pub fn synthesize<const N: usize, S: Sites<N>>(
    inputs: Inputs<'_, S>,
    (options, plan): (&SynthesisOptions, &Plan),
    begun: Option<LevelMap>,
    finished: &mut dyn FnMut(&LevelMap) -> Result<()>,
    progress: Progress<'_>,
) -> Result<LevelMap> {
    check_sites(inputs.sites, &table_windows(inputs.table, plan))?;
    coarse_to_fine(plan.levels, begun, finished, |level, coarser| {
        // Prepare the exemplar.
        let (space, sites) = (inputs.space, &inputs.sites.levels[level]);
        let two_level = level + 1 < plan.levels;
        let exemplar = ExemplarLevel::new(space, inputs.table, level, 1, two_level);
        let coarser = coarser.map(|map| Texels::on(&space.levels[level + 1], map.coords));
        // Start at random, or from the parents.
        let start = match &coarser {
            None => Texels::random(&exemplar, sites.count(), (options.seed, level as u32)),
            Some(coarser) => Texels::of_parents(&exemplar, sites.parents(), coarser),
        };
        // Visit every site as often as asked for; a level that another follows saves one pass.
        let passes = options.passes - u32::from(two_level);
        progress.begin(
            format!("synthesis, level {level}"),
            u64::from(passes) * sites.count() as u64,
        );
        let work = Passes::<N, S> {
            exemplar: &exemplar,
            sites,
            coarser: coarser.as_ref(),
            start,
            passes,
            progress,
        };
        // Search with the metric of the options.
        let choice = MetricChoice {
            kind: options.metric,
            spectrum: options.spectrum,
            searches_all: true,
            refines: true,
            seed: options.seed,
        };
        let state = with_metric(space, &exemplar, level, choice, work)??;
        progress.end();
        Ok(state.at_centres(exemplar.grid))
    })
}

struct Passes<'a, const N: usize, S> {
    exemplar: &'a ExemplarLevel<'a>,
    sites: &'a S,
    coarser: Option<&'a Texels>,
    start: Texels,
    passes: u32,
    progress: Progress<'a>,
}

impl<const N: usize, S: Sites<N>> WithMetric for Passes<'_, N, S> {
    type Found = Result<Texels>;

    fn run<M: Metric>(self, metric: &M) -> Result<Texels> {
        let (classes, mut state) = (color_classes(self.sites, self.progress)?, self.start);
        let rule = BestOfAll {
            exemplar: self.exemplar,
            sites: self.sites,
            coarser: self.coarser,
            metric,
        };
        let visits = (&classes[..], self.passes);
        class_by_class(&rule, self.sites, &mut state, visits, self.progress)?;
        Ok(state)
    }
}

/// The rule: the texel whose neighbourhood is most similar, of all that are whole.
struct BestOfAll<'a, const N: usize, S, M> {
    exemplar: &'a ExemplarLevel<'a>,
    sites: &'a S,
    coarser: Option<&'a Texels>,
    metric: &'a M,
}

impl<const N: usize, S: Sites<N>, M: Metric> Rule for BestOfAll<'_, N, S, M> {
    type State = Texels;
    type Take = TexCoord;
    type Scratch = M::Pattern;

    fn held(&self, state: &Texels, site: usize) -> TexCoord {
        state.coords[site]
    }

    fn choose(&self, state: &Texels, site: usize, pattern: &mut M::Pattern) -> TexCoord {
        let neighborhood = SiteNeighborhood {
            site,
            sites: self.sites,
            rows: &state.rows,
            done: None,
            unfinished: Unfinished::LeftOut,
            coarser: self.coarser.map(|coarser| &coarser.rows[..]),
        };
        self.metric.read(&neighborhood, pattern);
        let best = self.metric.best_of_all(pattern, &[], Preference::NONE);
        best.map_or(state.coords[site], |pick| {
            self.exemplar.grid.centre(TexelIndex(pick.texel))
        })
    }

    fn set(&self, state: &mut Texels, site: usize, at: TexCoord) {
        state.set(self.exemplar, site, at);
    }

    fn batch(&self) -> usize {
        2
    }
}
