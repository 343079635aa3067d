//! Chen and Dong 2008, *Adaptive Surface Texture Synthesis Using Round-Shaped Neighbourhoods*.
//!
//! All levels have the same sites; level l has round neighbourhoods 2ˡ times as wide. The lowest resolution
//! grows from one site, the one with most synthesized neighbours next: neighbours propose texels by forward
//! shift (§5.1), and the [adaptive similarity](similarity) decides (§5.2). A site of a finer level takes the
//! nearest of the texels round the pixel links of what it held (§6.3). The exemplar is resampled once (§5.3).
//!
//! Deviations: on grids the neighbours of a site are those within `--rings` texels of the finest level, whatever
//! the level; on meshes those inside its outermost circle, at most 128. Finer levels are visited by colour
//! classes, so that a class is searched in parallel. Pixel links start from the real coordinate, so that a
//! copied patch stays regular between texel centres.

pub(crate) mod options;
mod order;
mod plan;
mod similarity;

use rand::Rng;

use crate::error::Result;
use crate::exemplar::dense_windows::{DenseWindows, whole_texels};
use crate::exemplar::embedding::Embedding;
use crate::exemplar::level::ExemplarLevel;
use crate::grid::TexCoord;
use crate::index::TexelIndex;
use crate::neighborhood::{Neighborhood, Template};
use crate::progress::Progress;
use crate::random;
use crate::sites::coloring::color_classes;
use crate::sites::level::Sites;
use crate::synthesis::candidates::forward::CandidateList;
use crate::synthesis::check::Plan;
use crate::synthesis::drive::{class_by_class, coarse_to_fine, one_by_one};
use crate::synthesis::inputs::{Inputs, LevelMap};
use crate::synthesis::method::{MethodDescription, MethodSites, SharedOption};
use crate::synthesis::metric::dense::{DenseMetric, DensePattern};
use crate::synthesis::metric::site_values::{SiteNeighborhood, Unfinished};
use crate::synthesis::options::SynthesisOptions;
use crate::synthesis::recipes::adaptive::options::Similarity;
use crate::synthesis::recipes::adaptive::order::most_neighbors_first;
use crate::synthesis::recipes::adaptive::plan::{check_levels, levels};
use crate::synthesis::recipes::adaptive::similarity::Contest;
use crate::synthesis::rule::Rule;
use crate::synthesis::state::Texels;

/// The method, as the rest of the program sees it.
pub const DESCRIPTION: MethodDescription = MethodDescription {
    name: "adaptive",
    help: "Chen and Dong 2008: round neighbourhoods of growing size on the same sites at every level",
    sites: MethodSites::Circles(|options| options.adaptive.rings),
    plan: |space, _, options| levels(space, options).map(Plan::of_levels),
    chooses_levels: false,
    unused: &[
        (SharedOption::Metric, "a metric of its own"),
        (SharedOption::Neighborhood, "neighbourhoods of its own"),
        (SharedOption::Passes, "a fixed number of passes"),
    ],
    own_options: Some(|options| &options.adaptive),
    microseconds: |_, _| 78.0,
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
    check_levels(inputs.sites, plan)?;
    let template = Template::round(options.adaptive.rings);
    let none = Neighborhood::default();
    coarse_to_fine(plan.levels, begun, finished, |number, coarser| {
        // Prepare the exemplar with its round windows.
        let (level, sites) = (&inputs.space.levels[number], &inputs.sites.levels[number]);
        let embedding = Embedding::new(level, options.spectrum);
        let (margin, k) = (inputs.table.margin, inputs.table.k);
        let whole = whole_texels((level.grid, k), margin, &template, None);
        let exemplar = ExemplarLevel::without_table(level, whole, &none);
        let metric = DenseMetric::new(DenseWindows::new(level, &embedding, &template), &embedding);
        progress.begin(format!("synthesis, level {number}"), sites.count() as u64);
        // Grow the coarsest level; refine the others from the level above.
        let state = match coarser {
            None => {
                let grown = Grown {
                    exemplar: &exemplar,
                    sites,
                    metric: &metric,
                    template: &template,
                    similarity: options.adaptive.similarity,
                };
                let draw = (options.seed, number as u32);
                let mut state = Texels::random(&exemplar, sites.count(), draw).none_done();
                let mut stream = random::stream(options.seed, "growth start", number as u32, 0);
                let start = stream.gen_range(0..sites.count().max(1));
                let order = most_neighbors_first(sites, start, progress)?;
                one_by_one(&grown, &mut state, &order, progress)?;
                state
            }
            Some(coarser) => {
                let range = options.adaptive.link_range;
                let linked = Linked {
                    exemplar: &exemplar,
                    sites,
                    metric: &metric,
                    range,
                };
                let held = linked_coords(&coarser.coords, &exemplar);
                let mut state = Texels::of_coords(&exemplar, held);
                let classes = color_classes(sites, progress)?;
                class_by_class(&linked, sites, &mut state, (&classes, 1), progress)?;
                state
            }
        };
        // Write texel centres on the finest level.
        progress.end();
        Ok(match number {
            0 => state.at_centres(level.grid),
            _ => state.coords,
        })
    })
}

/// Where coordinates of a coarser level lie on the finer one, on the same sites: half as far from the image's
/// corner in texels there as here.
fn linked_coords(coarser: &[TexCoord], finer: &ExemplarLevel<'_>) -> Vec<TexCoord> {
    let grid = finer.grid;
    let (height, above) = (grid.height as f32, grid.coarser().height as f32);
    let link = |at: &TexCoord| {
        let (s, down) = (2.0 * at.s, 2.0 * (above - at.t));
        TexCoord {
            s: s.min((grid.width as f32).next_down()),
            t: height - down.min(height.next_down()),
        }
    };
    coarser.iter().map(link).collect()
}

/// The rule of the lowest resolution: of the texels that synthesized neighbours propose, the one that the
/// adaptive similarity leaves.
struct Grown<'a, const N: usize, S> {
    exemplar: &'a ExemplarLevel<'a>,
    sites: &'a S,
    metric: &'a DenseMetric,
    template: &'a Template,
    similarity: Similarity,
}

/// Working memory of one thread.
#[derive(Default)]
struct Scratch {
    candidates: CandidateList,
    pattern: DensePattern,
    contest: Contest,
}

impl<const N: usize, S: Sites<N>> Rule for Grown<'_, N, S> {
    type State = Texels;
    type Take = TexCoord;
    type Scratch = Scratch;

    fn held(&self, state: &Texels, site: usize) -> TexCoord {
        state.coords[site]
    }

    fn choose(&self, state: &Texels, site: usize, scratch: &mut Scratch) -> TexCoord {
        let Scratch {
            candidates,
            pattern,
            contest,
        } = scratch;
        let done = state.done.as_deref().unwrap_or_default();
        let near = self.sites.neighbors(site);
        candidates.collect_coherent(self.exemplar, None, near, &state.coords, |site| done[site]);
        if candidates.candidates().is_empty() {
            // The first site of a part, or all that is proposed ends at the border: a random texel.
            return state.coords[site];
        }
        self.metric
            .read(&neighborhood(self.sites, state, site), pattern);
        let texels = candidates
            .candidates()
            .iter()
            .map(|candidate| candidate.texel);
        let winner = match self.similarity {
            Similarity::Adaptive => {
                contest.winner(self.metric, pattern, texels, &self.template.ring_ends)
            }
            Similarity::Plain => nearest(self.metric, pattern, texels),
        };
        winner.map_or(state.coords[site], |texel| {
            candidates.place(self.exemplar.grid, texel)
        })
    }

    fn set(&self, state: &mut Texels, site: usize, at: TexCoord) {
        state.set(self.exemplar, site, at);
    }
}

/// The rule of finer levels: the nearest of the texels within a range of the pixel links.
struct Linked<'a, const N: usize, S> {
    exemplar: &'a ExemplarLevel<'a>,
    sites: &'a S,
    metric: &'a DenseMetric,
    range: u32,
}

impl<const N: usize, S: Sites<N>> Rule for Linked<'_, N, S> {
    type State = Texels;
    type Take = TexCoord;
    type Scratch = DensePattern;

    fn held(&self, state: &Texels, site: usize) -> TexCoord {
        state.coords[site]
    }

    fn choose(&self, state: &Texels, site: usize, pattern: &mut DensePattern) -> TexCoord {
        let grid = self.exemplar.grid;
        let held = grid.texel_nearest(state.coords[site]);
        self.metric
            .read(&neighborhood(self.sites, state, site), pattern);
        let mut best = (f32::INFINITY, held.0);
        // The links are the four texels of one parent.
        let (held_row, held_col) = grid.row_col(held);
        let (row, col) = (i64::from(held_row & !1), i64::from(held_col & !1));
        let range = i64::from(self.range);
        for row in row - range..=row + 1 + range {
            for col in col - range..=col + 1 + range {
                let Some(texel) = grid.texel_at(row, col) else {
                    continue;
                };
                if self.exemplar.whole[texel.index()] {
                    let distance = self.metric.distance(pattern, texel.0);
                    if (distance, texel.0) < best {
                        best = (distance, texel.0);
                    }
                }
            }
        }
        let (row, col) = grid.row_col(TexelIndex(best.1));
        let at = state.coords[site];
        TexCoord {
            s: at.s - held_col as f32 + col as f32,
            t: at.t + held_row as f32 - row as f32,
        }
    }

    fn set(&self, state: &mut Texels, site: usize, at: TexCoord) {
        state.set(self.exemplar, site, at);
    }
}

/// The texel at the smallest distance; ties go to the smaller index.
fn nearest(
    metric: &DenseMetric,
    pattern: &DensePattern,
    texels: impl Iterator<Item = u32>,
) -> Option<u32> {
    let told = texels.map(|texel| (metric.distance(pattern, texel), texel));
    let nearest = told.reduce(|a, b| if b < a { b } else { a });
    nearest.map(|(_, texel)| texel)
}

fn neighborhood<'a, S>(sites: &'a S, state: &'a Texels, site: usize) -> SiteNeighborhood<'a, S> {
    SiteNeighborhood {
        site,
        sites,
        rows: &state.rows,
        done: state.done.as_deref(),
        unfinished: Unfinished::LeftOut,
        coarser: None,
    }
}
