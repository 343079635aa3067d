//! Whether the embedded metric picks what Φ picks: at seeded sites of a finished map, among the
//! candidates that k-coherence would try there, with the level-0 fine window.
//!
//! Every metric picks as synthesis does: the smallest score, factor · (distance + floor), the floor that
//! metric's own share `--distance-floor` of the distance between random texels. A pick agrees when its score through Φ
//! is Φ's smallest, or above it by no more than the rounding of single precision.

use rayon::prelude::*;
use serde::Serialize;

use crate::error::Result;
use crate::exemplar::embedding::Embedding;
use crate::exemplar::level::ExemplarLevel;
use crate::exemplar::space::Features;
use crate::grid::TexCoord;
use crate::progress::Progress;
use crate::sites::level::Sites;
use crate::synthesis::candidates::forward::{Candidate, CandidateList};
use crate::synthesis::check::Plan;
use crate::synthesis::inputs::Inputs;
use crate::synthesis::keep::{Pick, Preference};
use crate::synthesis::metric::Metric;
use crate::synthesis::metric::embedded::{EmbeddedMetric, EmbeddedPattern};
use crate::synthesis::metric::gram::{GramMetric, GramPattern};
use crate::synthesis::metric::of_level::gram;
use crate::synthesis::metric::site_values::{SiteNeighborhood, Unfinished};
use crate::synthesis::options::SynthesisOptions;
use crate::synthesis::quality::energy::measured_sites;
use crate::synthesis::recipes::distance_floor::distance_floor;
use crate::synthesis::recipes::k_coherence::KCoherence;

/// Distances that differ by less, as a share, are equal: the rounding of single precision.
const ROUNDING: f64 = 1e-6;

/// How the metrics' picks compare.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Agreement {
    /// Share of sites at which the embedding of Φ's whole spectrum picks what Φ picks, ties aside.
    pub whole_spectrum: f64,
    /// The same of the embedding that synthesis uses.
    pub embedded: f64,
    /// Mean score through Φ of the picks of the embedding that synthesis uses, over that of Φ's.
    pub embedded_cost: f64,
}

/// The score through Φ of a metric's pick: Φ's own pick, the whole embedding's, the used one's.
type Costs = [f64; 3];

/// Compares the metrics on a finished map of level 0; `None` for plain images, which have no Φ.
pub fn measure<const N: usize, S: Sites<N>>(
    inputs: Inputs<'_, S>,
    coords: &[TexCoord],
    (options, plan): (&SynthesisOptions, &Plan),
    progress: Progress<'_>,
) -> Result<Option<Agreement>> {
    let level = &inputs.space.levels[0];
    if let Features::Plain(_) = level.features {
        return Ok(None);
    }
    // Prepare Φ, and vectors of the whole and of the kept spectrum.
    let exemplar = ExemplarLevel::new(inputs.space, inputs.table, 0, plan.k, false);
    let whole = Embedding::new(level, 1.0);
    progress.check()?;
    let used = Embedding::new(level, options.spectrum);
    let state = coords.iter().map(|&at| exemplar.grid.texel_nearest(at));
    let phi = GramMetric::new(&exemplar, gram(level)?, None);
    let embedded = [&whole, &used].map(|embedding| EmbeddedMetric::new(&exemplar, embedding, None));
    let [whole_floor, used_floor] = embedded
        .each_ref()
        .map(|metric| floor(inputs, &exemplar, metric, options));
    // Compare what they choose, site by site.
    let comparison = Comparison::<N, S> {
        inputs,
        coords,
        rows: state.map(|texel| exemplar.rows[texel.index()]).collect(),
        coherence: options.k_coherence.coherence,
        phi_floor: floor(inputs, &exemplar, &phi, options),
        phi,
        embedded,
        embedded_floor: [whole_floor, used_floor],
        exemplar: &exemplar,
    };
    let sites = measured_sites(inputs.sites.levels[0].areas(), options.seed);
    let costs = sites
        .par_iter()
        .map_init(Scratch::default, |scratch, &site| {
            progress.check()?;
            Ok(comparison.at_site(site as usize, scratch))
        });
    Ok(Some(Agreement::of(&costs.collect::<Result<Vec<_>>>()?)))
}

/// The distance floor of synthesis on level 0, here of the fine window alone.
fn floor<const N: usize, S: Sites<N>, M: Metric>(
    inputs: Inputs<'_, S>,
    exemplar: &ExemplarLevel<'_>,
    metric: &M,
    options: &SynthesisOptions,
) -> f64 {
    let rule = KCoherence::<N, S, M> {
        exemplar,
        sites: &inputs.sites.levels[0],
        coarser: None,
        metric,
        search: options.k_coherence.search,
        preference: Preference::NONE,
    };
    distance_floor(&rule, options.k_coherence.distance_floor, (options.seed, 0))
}

impl Agreement {
    fn of(costs: &[Costs]) -> Self {
        let sum = |metric: usize| costs.iter().map(|costs| costs[metric]).sum::<f64>();
        let agreeing = |metric: usize| {
            let equal = |costs: &&Costs| costs[metric] <= costs[0] * (1.0 + ROUNDING);
            costs.iter().filter(equal).count() as f64 / costs.len().max(1) as f64
        };
        Self {
            whole_spectrum: agreeing(1),
            embedded: agreeing(2),
            embedded_cost: if sum(0) > 0.0 { sum(2) / sum(0) } else { 1.0 },
        }
    }
}

/// A finished map and the metrics that look at it.
struct Comparison<'a, const N: usize, S> {
    inputs: Inputs<'a, S>,
    coords: &'a [TexCoord],
    rows: Vec<u32>,
    coherence: f64,
    exemplar: &'a ExemplarLevel<'a>,
    phi: GramMetric<'a>,
    phi_floor: f64,
    /// Of the whole spectrum, and the one that synthesis uses.
    embedded: [EmbeddedMetric<'a>; 2],
    embedded_floor: [f64; 2],
}

#[derive(Default)]
struct Scratch {
    candidates: CandidateList,
    in_phi: GramPattern,
    in_rd: EmbeddedPattern,
}

impl<const N: usize, S: Sites<N>> Comparison<'_, N, S> {
    fn at_site(&self, site: usize, scratch: &mut Scratch) -> Costs {
        let sites = &self.inputs.sites.levels[0];
        let neighborhood = SiteNeighborhood {
            site,
            sites,
            rows: &self.rows,
            done: None,
            unfinished: Unfinished::LeftOut,
            coarser: None,
        };
        let (own, near) = (self.coords[site], sites.neighbors(site));
        let list = &mut scratch.candidates;
        list.collect_coherent(self.exemplar, Some(own), near, self.coords, |_| true);
        list.add_nearest(self.exemplar, self.coherence);
        let candidates = list.candidates();
        let in_phi = &mut scratch.in_phi;
        self.phi.read(&neighborhood, in_phi);
        let first = self.phi.best(in_phi, candidates, None, self.phi_floor);
        let [whole, used] = [0, 1].map(|number| {
            let metric = &self.embedded[number];
            metric.read(&neighborhood, &mut scratch.in_rd);
            metric.best(
                &scratch.in_rd,
                candidates,
                None,
                self.embedded_floor[number],
            )
        });
        [first, whole, used].map(|pick| self.score(pick, candidates, in_phi))
    }

    /// The score of a pick through Φ; 0 where nothing may be picked.
    fn score(&self, pick: Option<Pick>, candidates: &[Candidate], in_phi: &GramPattern) -> f64 {
        let listed = |texel: u32| candidates.iter().find(|listed| listed.texel == texel);
        pick.and_then(|pick| listed(pick.texel))
            .map_or(0.0, |listed| {
                let distance = self.phi.distance(in_phi, listed.texel, f64::INFINITY);
                listed.factor * (distance + self.phi_floor)
            })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sites::grid::GridSites;
    use crate::sites::grid::window::SiteGrid;
    use crate::synthesis::all_levels::synthesize;
    use crate::synthesis::check::complete;
    use crate::synthesis::options::KCoherenceOptions;
    use crate::synthesis::tests::fixtures;

    #[test]
    fn shares_count_what_costs_no_more() {
        let found = Agreement::of(&[[1.0, 1.0, 1.1], [3.0, 3.0, 3.0]]);
        assert_eq!((found.whole_spectrum, found.embedded), (1.0, 0.5));
        assert!((found.embedded_cost - 4.1 / 4.0).abs() < 1e-12);
    }

    /// A random exemplar of 2 levels and a grid of 40×40 sites, handed to `check`.
    fn with_inputs(check: impl FnOnce(Inputs<'_, GridSites>)) {
        let (space, table) = fixtures::random_exemplar(8, 16, 2, true);
        let neighborhoods: Vec<_> = table
            .levels
            .iter()
            .map(|l| l.neighborhood.clone())
            .collect();
        let target = SiteGrid {
            width: 40,
            height: 40,
            toroidal: true,
        };
        let sites = target.hierarchy(&neighborhoods).unwrap();
        check(Inputs {
            space: &space,
            table: &table,
            sites: &sites,
            controls: None,
        });
    }

    fn measured(
        inputs: Inputs<'_, GridSites>,
        coords: &[TexCoord],
        options: &SynthesisOptions,
    ) -> Agreement {
        let plan = complete(inputs.space, inputs.table, options).unwrap();
        let found = measure(inputs, coords, (options, &plan), Progress::silent());
        found.unwrap().unwrap()
    }

    fn synthesized(inputs: Inputs<'_, GridSites>, options: &SynthesisOptions) -> Vec<TexCoord> {
        let map = synthesize(inputs, options, None, &mut |_| Ok(()), Progress::silent());
        map.unwrap().coords
    }

    #[test]
    fn the_whole_embedding_picks_what_phi_picks() {
        with_inputs(the_whole_embedding_agrees);
    }

    fn the_whole_embedding_agrees(inputs: Inputs<'_, GridSites>) {
        let options = SynthesisOptions::default();
        let coords = synthesized(inputs, &options);
        let found = measured(inputs, &coords, &options);
        assert!(found.whole_spectrum >= 0.999, "{found:?}");
        assert!((1.0..=1.01).contains(&found.embedded_cost), "{found:?}");
        let rough = SynthesisOptions {
            spectrum: 0.2,
            ..options
        };
        let rough = measured(inputs, &coords, &rough);
        assert!(rough.embedded < found.embedded && rough.embedded_cost > found.embedded_cost);
    }

    /// A floor far above every distance leaves the factor to decide: all metrics pick a coherent texel, and
    /// every score is the floor itself, whatever the spectrum.
    #[test]
    fn picks_heed_the_floor_as_synthesis_does() {
        with_inputs(|inputs| {
            let coords = synthesized(inputs, &SynthesisOptions::default());
            let with_floor = |distance_floor: f64| {
                let options = SynthesisOptions {
                    spectrum: 0.2,
                    k_coherence: KCoherenceOptions {
                        distance_floor,
                        ..KCoherenceOptions::default()
                    },
                    ..SynthesisOptions::default()
                };
                measured(inputs, &coords, &options)
            };
            let (none, much) = (with_floor(0.0), with_floor(1e9));
            assert!(none.embedded < 1.0 && none.embedded_cost > 1.0, "{none:?}");
            assert_eq!((much.embedded, much.whole_spectrum), (1.0, 1.0));
            assert!((much.embedded_cost - 1.0).abs() < 1e-6, "{much:?}");
        });
    }
}
