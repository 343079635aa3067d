//! Whether the embedded metric picks what Φ picks: at seeded sites of a finished map, among the
//! candidates that k-coherence would try there, with the level-0 fine window.
//!
//! Every metric picks as synthesis does: the smallest score, factor · (distance + noise), the noise that
//! metric's own share `--noise` of its distance by chance. A pick agrees when its score through Φ is Φ's
//! smallest, or above it by no more than the rounding of single precision.

use rayon::prelude::*;
use serde::Serialize;

use crate::error::Result;
use crate::exemplar::space::Features;
use crate::grid::TexCoord;
use crate::progress::Progress;
use crate::synthesis::candidates::{Candidate, CandidateList};
use crate::synthesis::check;
use crate::synthesis::choice::Pick;
use crate::synthesis::embedded::{EmbeddedMetric, EmbeddedPattern};
use crate::synthesis::embedding::Embedding;
use crate::synthesis::engine::Inputs;
use crate::synthesis::exemplar_level::ExemplarLevel;
use crate::synthesis::gram::{GramMetric, GramPattern};
use crate::synthesis::metric::Metric;
use crate::synthesis::options::SynthesisOptions;
use crate::synthesis::passes::LevelPass;
use crate::synthesis::quality::energy::measured_sites;
use crate::synthesis::site_samples::{SampledSites, SiteNeighborhood};

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
pub fn measure(
    inputs: Inputs<'_>,
    coords: &[TexCoord],
    options: &SynthesisOptions,
    progress: Progress<'_>,
) -> Result<Option<Agreement>> {
    let level = &inputs.space.levels[0];
    if let Features::Vectors(_) = level.features {
        return Ok(None);
    }
    let k = options.k.unwrap_or(inputs.table.k);
    let exemplar = ExemplarLevel::new(inputs.space, inputs.table, 0, k, false);
    let whole = Embedding::new(level, 1.0);
    progress.check()?;
    let used = Embedding::new(level, options.energy);
    let state = coords.iter().map(|&at| exemplar.grid.texel_nearest(at));
    let phi = GramMetric::new(&exemplar, check::gram(level)?, None);
    let embedded = [&whole, &used].map(|embedding| EmbeddedMetric::new(&exemplar, embedding, None));
    let [whole_noise, used_noise] = embedded
        .each_ref()
        .map(|metric| noise(inputs, &exemplar, metric, options));
    let comparison = Comparison {
        inputs,
        coords,
        rows: state.map(|texel| exemplar.rows[texel.index()]).collect(),
        coherence: options.coherence,
        phi_noise: noise(inputs, &exemplar, &phi, options),
        phi,
        embedded,
        embedded_noise: [whole_noise, used_noise],
        exemplar: &exemplar,
    };
    let sites = measured_sites(&inputs.sites.levels[0].areas, options.seed);
    let costs = sites
        .par_iter()
        .map_init(Scratch::default, |scratch, &site| {
            progress.check()?;
            Ok(comparison.at_site(site as usize, scratch))
        });
    Ok(Some(Agreement::of(&costs.collect::<Result<Vec<_>>>()?)))
}

/// What synthesis adds to all distances of a choice on level 0, here measured with the fine window alone.
fn noise<M: Metric>(
    inputs: Inputs<'_>,
    exemplar: &ExemplarLevel<'_>,
    metric: &M,
    options: &SynthesisOptions,
) -> f64 {
    if options.noise == 0.0 {
        return 0.0;
    }
    let pass = LevelPass {
        level: 0,
        exemplar,
        sites: &inputs.sites.levels[0],
        coarser: None,
        metric,
        options,
        noise: 0.0,
    };
    options.noise * pass.distance_by_chance()
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
struct Comparison<'a> {
    inputs: Inputs<'a>,
    coords: &'a [TexCoord],
    rows: Vec<u32>,
    coherence: f64,
    exemplar: &'a ExemplarLevel<'a>,
    phi: GramMetric<'a>,
    phi_noise: f64,
    /// Of the whole spectrum, and the one that synthesis uses.
    embedded: [EmbeddedMetric<'a>; 2],
    embedded_noise: [f64; 2],
}

#[derive(Default)]
struct Scratch {
    candidates: CandidateList,
    in_phi: GramPattern,
    in_rd: EmbeddedPattern,
}

impl Comparison<'_> {
    fn at_site(&self, site: usize, scratch: &mut Scratch) -> Costs {
        let sites = &self.inputs.sites.levels[0];
        let neighborhood = SiteNeighborhood {
            site,
            fine: SampledSites::all(&sites.fine, &self.rows),
            coarse: None,
        };
        let (own, near) = (self.coords[site], sites.neighbors.of_site(site));
        let list = &mut scratch.candidates;
        list.collect_coherent(self.exemplar, Some(own), near, self.coords, |_| true);
        list.add_nearest(self.exemplar, self.coherence);
        let candidates = list.candidates();
        let in_phi = &mut scratch.in_phi;
        self.phi.read(&neighborhood, in_phi);
        let first = self.phi.best(in_phi, candidates, None, self.phi_noise);
        let [whole, used] = [0, 1].map(|number| {
            let metric = &self.embedded[number];
            metric.read(&neighborhood, &mut scratch.in_rd);
            metric.best(
                &scratch.in_rd,
                candidates,
                None,
                self.embedded_noise[number],
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
                listed.factor * (distance + self.phi_noise)
            })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthesis::engine::synthesize;
    use crate::synthesis::fixtures;
    use crate::synthesis::grid_target::GridTarget;

    #[test]
    fn shares_count_what_costs_no_more() {
        let found = Agreement::of(&[[1.0, 1.0, 1.1], [3.0, 3.0, 3.0]]);
        assert_eq!((found.whole_spectrum, found.embedded), (1.0, 0.5));
        assert!((found.embedded_cost - 4.1 / 4.0).abs() < 1e-12);
    }

    /// A random exemplar of 2 levels and a grid of 40×40 sites, handed to `check`.
    fn with_inputs(check: impl FnOnce(Inputs<'_>)) {
        let (space, table) = fixtures::random_exemplar(8, 16, 2, true);
        let neighborhoods: Vec<_> = table
            .levels
            .iter()
            .map(|l| l.neighborhood.clone())
            .collect();
        let target = GridTarget {
            width: 40,
            height: 40,
            toroidal: true,
        };
        let sites = target.hierarchy(&neighborhoods).unwrap();
        check(Inputs {
            space: &space,
            table: &table,
            sites: &sites,
        });
    }

    fn measured(inputs: Inputs<'_>, coords: &[TexCoord], options: &SynthesisOptions) -> Agreement {
        let found = measure(inputs, coords, options, Progress::silent());
        found.unwrap().unwrap()
    }

    fn synthesized(inputs: Inputs<'_>, options: &SynthesisOptions) -> Vec<TexCoord> {
        let map = synthesize(inputs, options, None, |_| Ok(()), Progress::silent());
        map.unwrap().coords
    }

    #[test]
    fn the_whole_embedding_picks_what_phi_picks() {
        with_inputs(the_whole_embedding_agrees);
    }

    fn the_whole_embedding_agrees(inputs: Inputs<'_>) {
        let options = SynthesisOptions::default();
        let coords = synthesized(inputs, &options);
        let found = measured(inputs, &coords, &options);
        assert!(found.whole_spectrum >= 0.999, "{found:?}");
        assert!((1.0..=1.01).contains(&found.embedded_cost), "{found:?}");
        let rough = SynthesisOptions {
            energy: 0.2,
            ..options
        };
        let rough = measured(inputs, &coords, &rough);
        assert!(rough.embedded < found.embedded && rough.embedded_cost > found.embedded_cost);
    }

    /// Noise far above every distance leaves the factor to decide: all metrics pick a coherent texel, and
    /// every score is the noise itself, whatever the spectrum.
    #[test]
    fn picks_heed_the_noise_as_synthesis_does() {
        with_inputs(|inputs| {
            let coords = synthesized(inputs, &SynthesisOptions::default());
            let with_noise = |noise: f64| {
                let options = SynthesisOptions {
                    energy: 0.2,
                    noise,
                    ..SynthesisOptions::default()
                };
                measured(inputs, &coords, &options)
            };
            let (none, much) = (with_noise(0.0), with_noise(1e9));
            assert!(none.embedded < 1.0 && none.embedded_cost > 1.0, "{none:?}");
            assert_eq!((much.embedded, much.whole_spectrum), (1.0, 1.0));
            assert!((much.embedded_cost - 1.0).abs() < 1e-6, "{much:?}");
        });
    }
}
