//! The metric that suits a level of an exemplar and the options, for work that is generic over metrics.

use crate::error::{Error, Result};
use crate::exemplar::embedding::Embedding;
use crate::exemplar::level::ExemplarLevel;
use crate::exemplar::space::{Features, Space, SpaceLevel};
use crate::synthesis::metric::Metric;
use crate::synthesis::metric::embedded::EmbeddedMetric;
use crate::synthesis::metric::feature_metric::FeatureMetric;
use crate::synthesis::metric::gram::GramMetric;
use crate::synthesis::options::MetricKind;
use ndarray::Array2;

/// Work on a level, whatever its metric.
pub trait WithMetric {
    /// What comes of it.
    type Found;

    /// Does the work.
    fn run<M: Metric>(self, metric: &M) -> Self::Found;
}

/// Which metric is wanted.
#[derive(Clone, Copy, Debug)]
pub struct MetricChoice {
    /// Through Φ, or through a factor of it.
    pub kind: MetricKind,
    /// Share of Φ's spectrum that the factor keeps.
    pub spectrum: f64,
    /// Whether every whole texel is searched at any site: [bounds](super::lower_bounds) are prepared.
    pub searches_all: bool,
    /// Whether many candidates are compared at most sites: bounds pay for plain images.
    pub refines: bool,
    /// The seed of the bounds' directions.
    pub seed: u64,
}

/// Does the work on level `level` of a space with the metric of a choice; windows on the parent level count
/// where the exemplar's level has them.
pub fn with_metric<W: WithMetric>(
    space: &Space,
    exemplar: &ExemplarLevel<'_>,
    level: usize,
    choice: MetricChoice,
    work: W,
) -> Result<W::Found> {
    let MetricChoice { spectrum, seed, .. } = choice;
    let above = exemplar.coarse.as_ref().map(|_| &space.levels[level + 1]);
    let own = &space.levels[level];
    // Compare through Φ.
    if choice.kind == MetricKind::Gram {
        let coarse = above.map(gram).transpose()?;
        return Ok(work.run(&GramMetric::new(exemplar, gram(own)?, coarse)));
    }
    // Compare through vectors.
    let fine = Embedding::new(own, spectrum);
    let coarse = above.map(|above| Embedding::new(above, spectrum));
    Ok(match &own.features {
        Features::Plain(_) => {
            let mut metric = FeatureMetric::new(exemplar, &fine, coarse.as_ref());
            if choice.searches_all || choice.refines {
                metric = metric.with_projected_windows((seed, level as u32), choice.searches_all);
            }
            work.run(&metric)
        }
        Features::Textons { .. } => {
            let mut metric = EmbeddedMetric::new(exemplar, &fine, coarse.as_ref());
            if choice.searches_all {
                metric = metric.with_projected_windows(seed, level as u32);
            }
            work.run(&metric)
        }
    })
}

/// Φ of a level; an error for plain images, which have none.
pub fn gram(level: &SpaceLevel) -> Result<&Array2<f32>> {
    match &level.features {
        Features::Textons { gram, .. } => Ok(gram),
        Features::Plain(_) => Err(Error::option(
            "metric",
            "gram, but a plain image has no Gram matrix",
            "embedded",
        )),
    }
}
