//! Ying 2001 §4, *Texture and Shape Synthesis on Surfaces*: multiscale synthesis, after Wei and Levoy 2000.
//!
//! The coarsest level grows along [scan lines](crate::sites::scan_order): every site takes the texel whose
//! Gaussian-weighted window is most similar, as far as the window is synthesized. On every finer level the first pass
//! compares windows on the coarser level alone, the second windows on both; one of the nearest `--matches` is drawn
//! at random, of those within `--match-margin` of the smallest distance.
//!
//! Deviations: exact bounds replace the paper's approximate search, so the nearest are always found. The first
//! pass is parallel, as no site reads another; the second goes by colour classes, so that a class is searched in
//! parallel. All texels of one coarser texel have the same window there: the first pass draws among coarser
//! texels, and takes the quarter of it that the site has in what its parent holds. The standard deviation of the
//! Gaussian, which the paper does not state, is the window's width over 6.4 (Efros and Leung 1999).

pub(crate) mod options;
mod plan;

use crate::error::Result;
use crate::exemplar::level::ExemplarLevel;
use crate::grid::{TexCoord, TexelGrid};
use crate::index::TexelIndex;
use crate::neighborhood::Neighborhood;
use crate::progress::Progress;
use crate::random;
use crate::sites::coloring::color_classes;
use crate::sites::level::Sites;
use crate::sites::scan_order::scan_order;
use crate::synthesis::check::{Plan, check_sites};
use crate::synthesis::drive::{class_by_class, coarse_to_fine, one_by_one};
use crate::synthesis::inputs::{Inputs, LevelMap};
use crate::synthesis::keep::Nearest;
use crate::synthesis::method::{MethodDescription, MethodSites, SharedOption};
use crate::synthesis::metric::Metric;
use crate::synthesis::metric::of_level::{MetricChoice, WithMetric, with_metric};
use crate::synthesis::metric::site_values::{SiteNeighborhood, Unfinished};
use crate::synthesis::options::SynthesisOptions;
use crate::synthesis::recipes::multiscale::plan::levels;
use crate::synthesis::rule::Rule;
use crate::synthesis::state::Texels;
use rand::Rng;

/// The method, as the rest of the program sees it.
pub const DESCRIPTION: MethodDescription = MethodDescription {
    name: "multiscale",
    help: "Ying 2001 §4: every texel is compared, first on the coarser level alone; one of the nearest is drawn at random",
    sites: MethodSites::Windows(|_, plan, options| options.multiscale.neighborhoods(plan.levels)),
    plan: |space, _, options| levels(space, options).map(Plan::of_levels),
    chooses_levels: false,
    unused: &[
        (SharedOption::Neighborhood, "neighbourhoods of its own"),
        (SharedOption::Passes, "a fixed number of passes"),
    ],
    own_options: Some(|options| &options.multiscale),
    microseconds: |work, _| 90.0 + 1.1 * work.texels.sqrt(),
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
    let neighborhoods = options.multiscale.neighborhoods(plan.levels);
    check_sites(inputs.sites, &neighborhoods)?;
    coarse_to_fine(plan.levels, begun, finished, |level, coarser| {
        let windows = &neighborhoods[level];
        let run = |kind, windows, coarser, start| {
            let pass = Pass::<N, S> {
                inputs,
                options,
                level,
                kind,
                coarser,
                start,
                progress,
            };
            pass.run(windows)
        };
        // Grow the coarsest level; refine the others in two passes.
        let state = match coarser {
            None => run(Kind::Coarsest, windows, None, None)?,
            Some(map) => {
                let above = Texels::on(&inputs.space.levels[level + 1], map.coords);
                let parents_alone = Neighborhood {
                    offsets: Vec::new(),
                    weights: Vec::new(),
                    ..windows.clone()
                };
                let first = run(Kind::First, &parents_alone, Some(&above), None)?;
                run(Kind::Second, windows, Some(&above), Some(first))?
            }
        };
        Ok(state.at_centres(inputs.space.levels[level].grid))
    })
}

/// The three ways to visit a level.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// The coarsest level, which grows.
    Coarsest,
    /// A finer level's first pass: windows on the coarser level alone.
    First,
    /// A finer level's second pass: windows on both.
    Second,
}

/// One pass over a level.
struct Pass<'a, const N: usize, S> {
    inputs: Inputs<'a, S>,
    options: &'a SynthesisOptions,
    level: usize,
    kind: Kind,
    coarser: Option<&'a Texels>,
    /// What the pass before left.
    start: Option<Texels>,
    progress: Progress<'a>,
}

impl<const N: usize, S: Sites<N>> Pass<'_, N, S> {
    /// Visits every site once, comparing some windows.
    fn run(self, windows: &Neighborhood) -> Result<Texels> {
        let Pass {
            inputs,
            options,
            level,
            kind,
            progress,
            ..
        } = self;
        let (space, sites) = (inputs.space, &inputs.sites.levels[level]);
        let grid = space.levels[level].grid;
        let table = inputs.table;
        let fits = |texel| windows.fits(grid, texel);
        let mut whole = table.margin.whole_texels(grid, table.k, fits);
        if kind == Kind::First {
            keep_one_of_each_parent(grid, &mut whole);
        }
        let two_level = kind != Kind::Coarsest;
        let exemplar = ExemplarLevel::of_windows(space, level, windows, whole, two_level);
        let pass = match kind {
            Kind::Coarsest => "",
            Kind::First => ", first pass",
            Kind::Second => ", second pass",
        };
        progress.begin(
            format!("synthesis, level {level}{pass}"),
            sites.count() as u64,
        );
        let choice = MetricChoice {
            kind: options.metric,
            spectrum: options.spectrum,
            // Bounds are of whole windows, which a level that grows does not have.
            searches_all: two_level,
            refines: false,
            seed: options.seed,
        };
        let work = Visit {
            pass: self,
            exemplar: &exemplar,
        };
        let state = with_metric(space, &exemplar, level, choice, work)??;
        progress.end();
        Ok(state)
    }
}

/// Lets only the first texel of every coarser texel be picked.
fn keep_one_of_each_parent(grid: TexelGrid, whole: &mut [bool]) {
    for (texel, whole) in (0..).zip(whole) {
        let (row, col) = grid.row_col(TexelIndex(texel));
        *whole &= row % 2 == 0 && col % 2 == 0;
    }
}

/// A pass with its exemplar, whatever the metric.
struct Visit<'a, const N: usize, S> {
    pass: Pass<'a, N, S>,
    exemplar: &'a ExemplarLevel<'a>,
}

impl<const N: usize, S: Sites<N>> WithMetric for Visit<'_, N, S> {
    type Found = Result<Texels>;

    fn run<M: Metric>(self, metric: &M) -> Result<Texels> {
        let (exemplar, pass) = (self.exemplar, self.pass);
        let (level, progress) = (pass.level, pass.progress);
        let sites = &pass.inputs.sites.levels[level];
        let asked = &pass.options.multiscale;
        let draw = (pass.options.seed, level as u32);
        // Set up the rule of this pass.
        let (matches, purpose) = match pass.kind {
            Kind::Coarsest => (1, "coarsest level"),
            Kind::First => (asked.matches, "first pass"),
            Kind::Second => (asked.matches, "second pass"),
        };
        let rule = OneOfNearest {
            exemplar,
            sites,
            coarser: pass.coarser,
            metric,
            kind: pass.kind,
            matches: matches as usize,
            factor: asked.factor(),
            draw: (pass.options.seed, purpose, level as u32),
        };
        // Visit in the order that suits the start.
        match (pass.start, pass.coarser) {
            (Some(mut state), _) => {
                let classes = color_classes(sites, progress)?;
                class_by_class(&rule, sites, &mut state, (&classes, 1), progress)?;
                Ok(state)
            }
            (None, Some(coarser)) => {
                let mut state = Texels::of_parents(exemplar, sites.parents(), coarser);
                let all = [(0..sites.count() as u32).collect()];
                class_by_class(&rule, sites, &mut state, (&all, 1), progress)?;
                Ok(state)
            }
            (None, None) => {
                let mut state = Texels::random(exemplar, sites.count(), draw).none_done();
                let mut stream = random::stream(draw.0, "growth start", draw.1, 0);
                let start = stream.gen_range(0..sites.count().max(1));
                let order = scan_order(sites, start, progress)?;
                one_by_one(&rule, &mut state, &order, progress)?;
                Ok(state)
            }
        }
    }
}

/// The rule: one of the nearest of all whole texels.
struct OneOfNearest<'a, const N: usize, S, M> {
    exemplar: &'a ExemplarLevel<'a>,
    sites: &'a S,
    coarser: Option<&'a Texels>,
    metric: &'a M,
    kind: Kind,
    /// So many, of those whose squared distance is at most `factor` times the smallest.
    matches: usize,
    factor: f64,
    /// Seed, purpose and level of what is drawn at every site.
    draw: (u64, &'static str, u32),
}

impl<const N: usize, S: Sites<N>, M: Metric> Rule for OneOfNearest<'_, N, S, M> {
    type State = Texels;
    type Take = TexCoord;
    type Scratch = M::Pattern;

    fn held(&self, state: &Texels, site: usize) -> TexCoord {
        state.coords[site]
    }

    fn choose(&self, state: &Texels, site: usize, pattern: &mut M::Pattern) -> TexCoord {
        if self.is_beside_none(state, site) {
            // The random texel that it begins with.
            return state.coords[site];
        }
        let neighborhood = SiteNeighborhood {
            site,
            sites: self.sites,
            rows: &state.rows,
            done: state.done.as_deref(),
            unfinished: Unfinished::Nearest,
            coarser: self.coarser.map(|coarser| &coarser.rows[..]),
        };
        self.metric.read(&neighborhood, pattern);
        let mut nearest = Nearest::new(self.matches, self.factor);
        self.metric.search(pattern, &mut nearest);
        let Some(texel) = self.one_of(nearest.kept(), site) else {
            return state.coords[site];
        };
        let grid = self.exemplar.grid;
        grid.centre(match self.kind {
            Kind::First => sibling_like(grid, texel, grid.texel_nearest(state.coords[site])),
            Kind::Coarsest | Kind::Second => texel,
        })
    }

    fn set(&self, state: &mut Texels, site: usize, at: TexCoord) {
        state.set(self.exemplar, site, at);
    }

    fn batch(&self) -> usize {
        2
    }
}

impl<const N: usize, S: Sites<N>, M> OneOfNearest<'_, N, S, M> {
    /// Whether a level grows and no sample of a site holds anything yet.
    fn is_beside_none(&self, state: &Texels, site: usize) -> bool {
        let Some(done) = &state.done else {
            return false;
        };
        let mut samples = self.sites.samples(site);
        !samples.any(|sample| sample.sites().iter().any(|&near| done[near as usize]))
    }

    /// One of the matches, drawn for the site whatever the thread.
    fn one_of(&self, matches: &[(f64, u32)], site: usize) -> Option<TexelIndex> {
        let (seed, purpose, level) = self.draw;
        let drawn = match matches.len() {
            0 | 1 => 0,
            several => random::stream(seed, purpose, level, site as u64).gen_range(0..several),
        };
        matches.get(drawn).map(|&(_, texel)| TexelIndex(texel))
    }
}

/// The texel beside `texel`, the first of its coarser one, that lies in the coarser texel as `other` does in its own.
fn sibling_like(grid: TexelGrid, texel: TexelIndex, other: TexelIndex) -> TexelIndex {
    let ((row, col), (down, right)) = (grid.row_col(texel), grid.row_col(other));
    grid.texel(
        (row + down % 2).min(grid.height - 1),
        (col + right % 2).min(grid.width - 1),
    )
}

#[cfg(test)]
mod tests;
