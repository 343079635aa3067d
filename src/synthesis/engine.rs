//! Level after level, coarsest first: the multi-resolution scheme of Tong 2002 §5.1.
//!
//! With one level, the level grows from one random texel. With more, the coarsest starts with a
//! random texel at every site and is swept in growing order; every finer level takes its
//! coordinates from its parents and is refined in colour classes.

use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::exemplar::neighbor_table::NeighborTable;
use crate::exemplar::space::{Features, Kind, Space};
use crate::grid::{TexCoord, TexelGrid};
use crate::index::{Level, TextonLabel};
use crate::mesh::hierarchy::SiteHierarchy;
use crate::progress::Progress;
use crate::synthesis::check::{self, Plan};
use crate::synthesis::coloring::color_classes;
use crate::synthesis::embedded::EmbeddedMetric;
use crate::synthesis::embedding::Embedding;
use crate::synthesis::exemplar_level::ExemplarLevel;
use crate::synthesis::gram::GramMetric;
use crate::synthesis::metric::Metric;
use crate::synthesis::options::{MetricKind, Search, SynthesisOptions};
use crate::synthesis::passes::{LevelPass, LevelState};
use crate::synthesis::picture::PictureMetric;

/// What synthesis reads.
#[derive(Clone, Copy, Debug)]
pub struct Inputs<'a> {
    /// The exemplar's features.
    pub space: &'a Space,
    /// The nearest neighbours of its texels.
    pub table: &'a NeighborTable,
    /// Where synthesis writes.
    pub sites: &'a SiteHierarchy,
}

/// One finished level.
#[derive(Clone, Debug, PartialEq)]
pub struct LevelMap {
    /// Which.
    pub level: Level,
    /// A texture coordinate a site, in texels of the level: texel centres on the finest.
    pub coords: Vec<TexCoord>,
}

/// Synthesizes all levels and returns the finest.
///
/// `finished` is handed every level when it is done; `resume` is one that an earlier run of the same
/// inputs and options finished. Errors: inputs and options that do not fit ([`check`]), and
/// [`Error::Interrupted`].
pub fn synthesize(
    inputs: Inputs<'_>,
    options: &SynthesisOptions,
    resume: Option<LevelMap>,
    mut finished: impl FnMut(&LevelMap) -> Result<()>,
    progress: Progress<'_>,
) -> Result<LevelMap> {
    let plan = check::plan(inputs, options)?;
    let mut before = resume.filter(|map| map.level.index() < plan.levels);
    let first = before.as_ref().map_or(plan.levels, |map| map.level.index());
    // The coarsest level is swept site after site; meanwhile the finer ones are coloured.
    let finer = first.min(plan.levels.saturating_sub(1));
    let coarsest = || {
        let begins = finer < first;
        let stage = begins.then(|| Stage::new(inputs, options, &plan, finer));
        stage.map(|stage| stage.run(None, &[], progress))
    };
    let (coarsest, classes) =
        rayon::join(coarsest, || classes_of(inputs, options, finer, progress));
    let classes = classes?;
    let mut finish = |level: usize, coords| {
        let map = LevelMap {
            level: Level(level as u32),
            coords,
        };
        finished(&map).map(|()| map)
    };
    if let Some(coords) = coarsest {
        before = Some(finish(finer, coords?)?);
    }
    for (level, classes) in classes.iter().enumerate().rev() {
        let stage = Stage::new(inputs, options, &plan, level);
        let coords = stage.run(before.take(), classes, progress)?;
        before = Some(finish(level, coords)?);
    }
    before.ok_or_else(|| Error::option("levels", "0", "1 or more"))
}

/// The colour classes of the finest `levels`; none where nothing is refined.
fn classes_of(
    inputs: Inputs<'_>,
    options: &SynthesisOptions,
    levels: usize,
    progress: Progress<'_>,
) -> Result<Vec<Vec<Vec<u32>>>> {
    let refined = options.passes > 1;
    let of_level = |level| match refined {
        true => color_classes(level, progress),
        false => Ok(Vec::new()),
    };
    let levels = &inputs.sites.levels[..levels];
    levels.par_iter().map(of_level).collect()
}

/// The texton of every coordinate of level 0; [`TextonLabel::NONE`] for plain images.
pub fn textons(space: &Space, coords: &[TexCoord]) -> Vec<TextonLabel> {
    let level = &space.levels[0];
    let label = |&at: &TexCoord| match &level.features {
        Features::Textons { labels, .. } => {
            TextonLabel(labels[level.grid.texel_nearest(at).index()])
        }
        Features::Vectors(_) => TextonLabel::NONE,
    };
    coords.iter().map(label).collect()
}

/// The work on one level.
struct Stage<'a> {
    inputs: Inputs<'a>,
    options: &'a SynthesisOptions,
    plan: &'a Plan,
    level: usize,
    exemplar: ExemplarLevel<'a>,
}

impl<'a> Stage<'a> {
    fn new(
        inputs: Inputs<'a>,
        options: &'a SynthesisOptions,
        plan: &'a Plan,
        level: usize,
    ) -> Self {
        let two_level = level + 1 < plan.levels;
        let (space, table) = (inputs.space, inputs.table);
        Self {
            inputs,
            options,
            plan,
            level,
            exemplar: ExemplarLevel::new(space, table, level, plan.k, two_level),
        }
    }

    /// Synthesizes the level from the coarser one, refined class after class, or from nothing.
    fn run(
        &self,
        coarser: Option<LevelMap>,
        classes: &[Vec<u32>],
        progress: Progress<'_>,
    ) -> Result<Vec<TexCoord>> {
        let two_level = self.level + 1 < self.plan.levels;
        let coarser = coarser.map(|map| self.state_of_coarser(map));
        progress.begin(format!("synthesis, level {}", self.level), self.visits());
        let state = match self.options.metric {
            MetricKind::Gram => {
                let gram = |level: usize| check::gram(&self.inputs.space.levels[level]);
                let fine = gram(self.level)?;
                let coarse = two_level.then(|| gram(self.level + 1)).transpose()?;
                let metric = GramMetric::new(&self.exemplar, fine, coarse);
                self.run_with(&metric, coarser.as_ref(), classes, progress)
            }
            MetricKind::Embedded => {
                let embedding = |level: usize| {
                    Embedding::new(&self.inputs.space.levels[level], self.options.energy)
                };
                let fine = embedding(self.level);
                let coarse = two_level.then(|| embedding(self.level + 1));
                let (seed, level) = (self.options.seed, self.level as u32);
                let full = self.options.search == Search::Full || self.mends();
                match self.inputs.space.kind() {
                    Kind::Features => {
                        let mut metric = PictureMetric::new(&self.exemplar, &fine, coarse.as_ref());
                        if full || self.refines() {
                            metric = metric.with_projected_windows(seed, level);
                        }
                        self.run_with(&metric, coarser.as_ref(), classes, progress)
                    }
                    Kind::Textons => {
                        let mut metric =
                            EmbeddedMetric::new(&self.exemplar, &fine, coarse.as_ref());
                        if full {
                            metric = metric.with_projected_windows(seed, level);
                        }
                        self.run_with(&metric, coarser.as_ref(), classes, progress)
                    }
                }
            }
        }?;
        progress.end();
        let grid = self.exemplar.grid;
        let centre = |&at: &TexCoord| grid.centre(grid.texel_nearest(at));
        Ok(match self.level {
            0 => state.coords.iter().map(centre).collect(),
            _ => state.coords,
        })
    }

    fn run_with<M: Metric>(
        &self,
        metric: &M,
        coarser: Option<&LevelState>,
        classes: &[Vec<u32>],
        progress: Progress<'_>,
    ) -> Result<LevelState> {
        let mut pass = LevelPass {
            level: self.level as u32,
            exemplar: &self.exemplar,
            sites: &self.inputs.sites.levels[self.level],
            coarser,
            metric,
            options: self.options,
            noise: 0.0,
        };
        if self.options.noise > 0.0 {
            let stands_for = 4_f64.powi(self.level as i32);
            pass.noise = self.options.noise * stands_for * pass.distance_by_chance();
        }
        let Some(coarser) = coarser else {
            return self.start(&pass, progress);
        };
        let mut state = pass.from_coarser(coarser);
        if self.options.passes > 1 {
            pass.refine(&mut state, classes, self.options.passes - 1, progress)?;
            if self.mends() {
                pass.mend(&mut state, classes, self.options.mends, progress)?;
            }
        }
        Ok(state)
    }

    /// The coarsest level: grown when it is the only one, else swept from a random start.
    fn start<M: Metric>(
        &self,
        pass: &LevelPass<'_, M>,
        progress: Progress<'_>,
    ) -> Result<LevelState> {
        if self.plan.levels == 1 {
            return pass.grow(progress);
        }
        let mut state = pass.random_start();
        let sweeps = (0..self.options.start_passes).into_par_iter();
        let orders = sweeps.map(|sweep| pass.visiting_order(u64::from(sweep), progress));
        for order in orders.collect::<Result<Vec<_>>>()? {
            pass.sweep(&mut state, &order, progress)?;
        }
        Ok(state)
    }

    /// Whether the level is refined after its first guess.
    fn refines(&self) -> bool {
        self.level + 1 < self.plan.levels && self.options.passes > 1
    }

    /// Whether the level ends with a full search where it fits worst.
    fn mends(&self) -> bool {
        let by_coherence = self.options.search == Search::KCoherence;
        self.level == 0 && self.refines() && by_coherence && self.options.mends > 0
    }

    /// How many choices the level takes, mending apart.
    fn visits(&self) -> u64 {
        let sites = self.inputs.sites.levels[self.level].site_count as u64;
        let coarsest = self.level + 1 == self.plan.levels;
        match (coarsest, self.plan.levels) {
            (true, 1) => sites,
            (true, _) => sites * u64::from(self.options.start_passes),
            (false, _) => sites * u64::from(self.options.passes - 1),
        }
    }

    fn state_of_coarser(&self, map: LevelMap) -> LevelState {
        let space = &self.inputs.space.levels[map.level.index()];
        let rows = crate::synthesis::exemplar_level::feature_rows(space);
        let grid: TexelGrid = space.grid;
        LevelState {
            rows: map
                .coords
                .iter()
                .map(|&at| rows[grid.texel_nearest(at).index()])
                .collect(),
            coords: map.coords,
        }
    }
}
