//! Neighbourhood distances of a map: against a random map, and against the best there is.
//!
//! At some seeded sites, with the level-0 fine window without its centre, exactly: through Φ, or
//! through the whole vectors of a plain image.

use rand::Rng;
use rayon::prelude::*;

use crate::error::Result;
use crate::exemplar::embedding::Embedding;
use crate::exemplar::level::ExemplarLevel;
use crate::exemplar::space::Features;
use crate::grid::TexCoord;
use crate::neighborhood::Neighborhood;
use crate::progress::Progress;
use crate::random;
use crate::sites::level::Sites;
use crate::synthesis::candidates::forward::Candidate;
use crate::synthesis::inputs::Inputs;
use crate::synthesis::keep::{Pick, Preference};
use crate::synthesis::metric::Metric;
use crate::synthesis::metric::feature_metric::{FeatureMetric, FeaturePattern};
use crate::synthesis::metric::gram::{GramMetric, GramPattern};
use crate::synthesis::metric::of_level::gram;
use crate::synthesis::metric::site_values::{SiteNeighborhood, Unfinished};

/// Sites that are measured, where there are as many.
pub const SITES: usize = 1000;

/// The distances at one site.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SiteEnergy {
    /// The site.
    pub site: u32,
    /// Of the texel it holds.
    pub chosen: f64,
    /// Of the best whole texel, the rest of the map fixed.
    pub best: f64,
    /// Of its texel in a map with a random texel at every site.
    pub random: f64,
}

/// The distances at all measured sites.
#[derive(Clone, Debug, PartialEq)]
pub struct Energies {
    /// Site by site.
    pub sites: Vec<SiteEnergy>,
}

impl Energies {
    /// Mean distance over that of the random map.
    pub fn over_random(&self) -> f64 {
        self.ratio(|site| site.chosen, |site| site.random)
    }

    /// Mean distance over that of the best texels.
    pub fn over_best(&self) -> f64 {
        self.ratio(|site| site.chosen, |site| site.best)
    }

    /// A ratio of sums; 1 where both are nothing.
    fn ratio(&self, above: impl Fn(&SiteEnergy) -> f64, below: impl Fn(&SiteEnergy) -> f64) -> f64 {
        let above: f64 = self.sites.iter().map(above).sum();
        let below: f64 = self.sites.iter().map(below).sum();
        match (above > 0.0, below > 0.0) {
            (false, false) => 1.0,
            (true, false) => f64::MAX,
            _ => above / below,
        }
    }
}

/// Measures a map of level 0 at [`SITES`] seeded sites.
pub fn measure<const N: usize, S: Sites<N>>(
    inputs: Inputs<'_, S>,
    coords: &[TexCoord],
    seed: u64,
    progress: Progress<'_>,
) -> Result<Energies> {
    let sites = measured_sites(inputs.sites.levels[0].areas(), seed);
    at_sites(inputs, coords, &sites, seed, progress)
}

/// Distances at every site, chosen only: what the energy picture shows.
pub fn of_every_site<const N: usize, S: Sites<N>>(
    inputs: Inputs<'_, S>,
    coords: &[TexCoord],
    progress: Progress<'_>,
) -> Result<Vec<f64>> {
    let neighborhood = without_centre(inputs);
    let exemplar = exemplar_level(inputs, &neighborhood);
    let map = Map::new(&exemplar, inputs, coords);
    let all: Vec<u32> = (0..coords.len() as u32).collect();
    let work = ChosenOnly::<N, S> { map: &map };
    with_exact_metric(inputs, &exemplar, work, &all, None, progress)
}

/// Distances at given sites.
pub fn at_sites<const N: usize, S: Sites<N>>(
    inputs: Inputs<'_, S>,
    coords: &[TexCoord],
    sites: &[u32],
    seed: u64,
    progress: Progress<'_>,
) -> Result<Energies> {
    let neighborhood = without_centre(inputs);
    let exemplar = exemplar_level(inputs, &neighborhood);
    let (map, random) = rayon::join(
        || Map::new(&exemplar, inputs, coords),
        || {
            Map::of_texels(
                &exemplar,
                inputs,
                random_texels(&exemplar, coords.len(), seed),
            )
        },
    );
    let work = AllThree::<N, S> {
        map: &map,
        random: &random,
    };
    let sites = with_exact_metric(inputs, &exemplar, work, sites, Some(seed), progress)?;
    Ok(Energies { sites })
}

/// Sites on the surface drawn at random, each once; all when there are few.
pub(super) fn measured_sites(areas: &[f32], seed: u64) -> Vec<u32> {
    let mut sites: Vec<u32> = (0..areas.len() as u32)
        .filter(|&site| areas[site as usize] > 0.0)
        .collect();
    let mut stream = random::stream(seed, "quality sites", 0, 0);
    let count = sites.len().min(SITES);
    for drawn in 0..count {
        let other = stream.gen_range(drawn..sites.len());
        sites.swap(drawn, other);
    }
    sites.truncate(count);
    sites
}

/// The neighbourhood of level 0, its centre weighing nothing.
fn without_centre<S>(inputs: Inputs<'_, S>) -> Neighborhood {
    let mut neighborhood = inputs.table.levels[0].neighborhood.clone();
    let weights = neighborhood.weights.iter_mut();
    for (weight, offset) in weights.zip(&neighborhood.offsets) {
        if *offset == [0, 0] {
            *weight = 0.0;
        }
    }
    neighborhood
}

/// Level 0 of the exemplar with another neighbourhood's weights.
fn exemplar_level<'a, S>(
    inputs: Inputs<'a, S>,
    neighborhood: &'a Neighborhood,
) -> ExemplarLevel<'a> {
    let k = inputs.table.k;
    let mut exemplar = ExemplarLevel::new(inputs.space, inputs.table, 0, k, false);
    exemplar.neighborhood = neighborhood;
    exemplar
}

/// A random whole texel for every site.
fn random_texels(exemplar: &ExemplarLevel<'_>, sites: usize, seed: u64) -> Vec<u32> {
    let mut stream = random::stream(seed, "random map", 0, 0);
    let whole = &exemplar.whole_texels;
    let texel = |_| whole[stream.gen_range(0..whole.len())];
    (0..sites).map(texel).collect()
}

/// A map whose neighbourhoods are measured.
struct Map<'a, S> {
    inputs: Inputs<'a, S>,
    /// The texel of each site, and its feature row.
    texels: Vec<u32>,
    rows: Vec<u32>,
}

impl<'a, S> Map<'a, S> {
    fn new(exemplar: &ExemplarLevel<'_>, inputs: Inputs<'a, S>, coords: &[TexCoord]) -> Self {
        let texel = |&at: &TexCoord| exemplar.grid.texel_nearest(at).0;
        Self::of_texels(exemplar, inputs, coords.iter().map(texel).collect())
    }

    fn of_texels(exemplar: &ExemplarLevel<'_>, inputs: Inputs<'a, S>, texels: Vec<u32>) -> Self {
        let row = |&texel: &u32| exemplar.rows[texel as usize];
        Self {
            inputs,
            rows: texels.iter().map(row).collect(),
            texels,
        }
    }

    fn distance<const N: usize, M: Metric>(
        &self,
        metric: &M,
        site: u32,
        pattern: &mut M::Pattern,
    ) -> f64
    where
        S: Sites<N>,
    {
        let neighborhood = SiteNeighborhood {
            site: site as usize,
            sites: &self.inputs.sites.levels[0],
            rows: &self.rows,
            done: None,
            unfinished: Unfinished::LeftOut,
            coarser: None,
        };
        metric.read(&neighborhood, pattern);
        metric.distance(pattern, self.texels[site as usize], f64::INFINITY)
    }
}

/// A metric that is exact, and tells the distance of the best whole texel, or that of the chosen one if
/// it is less: a texel that is not whole may be better than every whole one.
trait ExactMetric: Metric {
    fn best_distance(&self, pattern: &mut Self::Pattern, chosen: Pick) -> f64;
}

impl ExactMetric for GramMetric<'_> {
    fn best_distance(&self, pattern: &mut GramPattern, chosen: Pick) -> f64 {
        let mut best = chosen.distance;
        self.visit_all(pattern, best, |_, distance| {
            best = best.min(distance);
            best
        });
        best
    }
}

impl ExactMetric for FeatureMetric<'_> {
    fn best_distance(&self, pattern: &mut FeaturePattern, chosen: Pick) -> f64 {
        let own = Candidate {
            texel: chosen.texel,
            factor: 1.0,
        };
        let best = self.best_of_all(pattern, &[own], Preference::NONE);
        best.map_or(chosen.distance, |best| best.distance)
    }
}

/// What is measured at a site, whatever the metric.
trait Measurement: Sync {
    type Found: Send;
    fn at_site<M: ExactMetric>(
        &self,
        metric: &M,
        site: u32,
        pattern: &mut M::Pattern,
    ) -> Self::Found;
}

struct ChosenOnly<'a, const N: usize, S> {
    map: &'a Map<'a, S>,
}

impl<const N: usize, S: Sites<N>> Measurement for ChosenOnly<'_, N, S> {
    type Found = f64;
    fn at_site<M: ExactMetric>(&self, metric: &M, site: u32, pattern: &mut M::Pattern) -> f64 {
        self.map.distance(metric, site, pattern)
    }
}

struct AllThree<'a, const N: usize, S> {
    map: &'a Map<'a, S>,
    random: &'a Map<'a, S>,
}

impl<const N: usize, S: Sites<N>> Measurement for AllThree<'_, N, S> {
    type Found = SiteEnergy;
    fn at_site<M: ExactMetric>(
        &self,
        metric: &M,
        site: u32,
        pattern: &mut M::Pattern,
    ) -> SiteEnergy {
        let random = self.random.distance(metric, site, pattern);
        let chosen = self.map.distance(metric, site, pattern);
        let held = Pick::new(self.map.texels[site as usize], chosen, 1.0, 0.0);
        SiteEnergy {
            site,
            chosen,
            best: metric.best_distance(pattern, held),
            random,
        }
    }
}

/// Measures all sites in parallel, through Φ or through a plain image's vectors. `search` is the seed of
/// what bounds a full search, where one is made.
fn with_exact_metric<S, W: Measurement>(
    inputs: Inputs<'_, S>,
    exemplar: &ExemplarLevel<'_>,
    work: W,
    sites: &[u32],
    search: Option<u64>,
    progress: Progress<'_>,
) -> Result<Vec<W::Found>> {
    let level = &inputs.space.levels[0];
    match &level.features {
        Features::Textons { .. } => {
            let metric = GramMetric::new(exemplar, gram(level)?, None);
            over_sites(&metric, &work, sites, progress)
        }
        Features::Plain(_) => {
            let embedding = Embedding::new(level, 1.0);
            let mut metric = FeatureMetric::new(exemplar, &embedding, None);
            if let Some(seed) = search {
                metric = metric.with_projected_windows((seed, 0), false);
            }
            over_sites(&metric, &work, sites, progress)
        }
    }
}

fn over_sites<M: ExactMetric, W: Measurement>(
    metric: &M,
    work: &W,
    sites: &[u32],
    progress: Progress<'_>,
) -> Result<Vec<W::Found>> {
    let init = M::Pattern::default;
    let at_site = |pattern: &mut M::Pattern, &site: &u32| {
        progress.check()?;
        Ok(work.at_site(metric, site, pattern))
    };
    sites.par_iter().map_init(init, at_site).collect()
}
