//! The options that all methods of synthesis share, and those of each.

use serde::Serialize;

use crate::error::{Error, Result};
use crate::synthesis::option_ranges::{at_least_one, few_rounds};
use crate::synthesis::own_options::OwnOptions;
pub use crate::synthesis::recipes::Method;
use crate::synthesis::recipes::adaptive::options::AdaptiveOptions;
use crate::synthesis::recipes::choosy::options::ChoosyOptions;
use crate::synthesis::recipes::multiscale::options::MultiscaleOptions;
use crate::synthesis::recipes::progressive::options::ProgressiveOptions;
pub use crate::synthesis::recipes::tong::options::{CandidateSearch, KCoherenceOptions};

/// How the neighbourhoods of a site and a texel are compared.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum MetricKind {
    /// Through the Gram matrix Φ, in double precision (Tong 2002 §5.1): the reference.
    Gram,
    /// Through a factor of the centred Φ: the same distances as short dense vectors.
    #[default]
    Embedded,
}

/// What synthesis can be asked.
#[derive(Clone, Debug, PartialEq, Serialize, clap::Args)]
#[serde(rename_all = "kebab-case")]
#[command(next_help_heading = "Synthesis")]
pub struct SynthesisOptions {
    /// The method of synthesis, by its paper
    #[arg(long, value_enum, default_value_t = Self::default().method)]
    pub method: Method,
    /// Levels of the pyramid, the finest included. With 1, the finest level grows from one random site. [default:
    /// k-coherence and wei-levoy on a mesh: chosen by its number of vertices; adaptive: 2; coherent: 1; otherwise as
    /// many as the windows fit]
    #[arg(long)]
    pub levels: Option<u32>,
    /// Width of the neighbourhood; it must match the table's
    #[arg(long)]
    pub neighborhood: Option<u32>,
    /// How neighbourhoods are compared
    #[arg(long, value_enum, default_value_t = Self::default().metric)]
    pub metric: MetricKind,
    /// Share of the centred Gram matrix's spectrum that the embedded metric keeps, above 0 and at most 1; features of
    /// plain images are always kept whole
    #[arg(long, default_value_t = Self::default().spectrum)]
    pub spectrum: f64,
    /// Passes per level: 1 only copies from the coarser level, 2 also compares two-level neighbourhoods (Tong 2002),
    /// and each further one repeats the second
    #[arg(long, default_value_t = Self::default().passes)]
    pub passes: u32,
    /// Options of k-coherence.
    #[command(flatten)]
    #[serde(flatten)]
    pub k_coherence: KCoherenceOptions,
    /// Options of the adaptive method.
    #[command(flatten)]
    #[serde(flatten)]
    pub adaptive: AdaptiveOptions,
    /// Options of the multiscale method.
    #[command(flatten)]
    #[serde(flatten)]
    pub multiscale: MultiscaleOptions,
    /// Options of the progressive method.
    #[command(flatten)]
    #[serde(flatten)]
    pub progressive: ProgressiveOptions,
    /// Options of choosy sampling.
    #[command(flatten)]
    #[serde(flatten)]
    pub choosy: ChoosyOptions,
    /// Seed of everything drawn at random.
    #[arg(skip)]
    pub seed: u64,
}

impl Default for SynthesisOptions {
    fn default() -> Self {
        Self {
            method: Method::default(),
            levels: None,
            neighborhood: None,
            metric: MetricKind::default(),
            spectrum: 0.97,
            passes: 3,
            k_coherence: KCoherenceOptions::default(),
            adaptive: AdaptiveOptions::default(),
            multiscale: MultiscaleOptions::default(),
            progressive: ProgressiveOptions::default(),
            choosy: ChoosyOptions::default(),
            seed: 0,
        }
    }
}

impl SynthesisOptions {
    /// Checks every field by itself; [`check`](crate::synthesis::check) holds them against the inputs.
    pub fn validate(&self) -> Result<()> {
        at_least_one("levels", self.levels.map_or(1, u64::from))?;
        few_rounds("passes", self.passes, 1)?;
        check_neighborhood(self.neighborhood)?;
        if !(self.spectrum > 0.0 && self.spectrum <= 1.0) {
            return Err(Error::option(
                "spectrum",
                self.spectrum.to_string(),
                "a share above 0, at most 1",
            ));
        }
        for (_, own) in self.own_options() {
            own.validate()?;
        }
        self.check_method()
    }

    /// Refuses options that the method does not use, and values that do not suit it.
    fn check_method(&self) -> Result<()> {
        let changed = self.changed();
        self.refuse_foreign(|name| changed.contains(&name))?;
        (self.method.description().check_options)(self)?;
        self.refuse_replaced(|name| changed.contains(&name))
    }

    /// The options of single methods, each with the method that has them.
    pub(crate) fn own_options(&self) -> impl Iterator<Item = (Method, &dyn OwnOptions)> {
        Method::ALL.iter().filter_map(|&method| {
            let own = method.description().own_options?;
            Some((method, own(self)))
        })
    }
}

fn check_neighborhood(width: Option<u32>) -> Result<()> {
    match width {
        Some(width) if width % 2 == 0 => Err(Error::option(
            "neighborhood",
            width.to_string(),
            "an odd width, as 5 or 7",
        )),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(change: impl FnOnce(&mut SynthesisOptions)) -> String {
        let mut options = SynthesisOptions::default();
        change(&mut options);
        options.validate().unwrap_err().to_string()
    }

    #[test]
    fn the_defaults_are_valid() {
        SynthesisOptions::default().validate().unwrap();
    }

    #[test]
    fn every_field_is_checked() {
        assert!(message(|o| o.k_coherence.k = Some(0)).contains("--k: 0"));
        assert!(message(|o| o.levels = Some(0)).contains("--levels: 0"));
        assert!(message(|o| o.neighborhood = Some(6)).contains("an odd width"));
        assert!(message(|o| o.spectrum = 0.0).contains("--spectrum: 0"));
        assert!(message(|o| o.spectrum = f64::NAN).contains("--spectrum: NaN"));
        assert!(message(|o| o.k_coherence.coherence = 0.5).contains("--coherence: 0.5"));
        assert!(
            message(|o| o.k_coherence.distance_floor = -0.1).contains("--distance-floor: -0.1")
        );
        assert!(message(|o| o.passes = 0).contains("--passes: 0"));
        assert!(message(|o| o.k_coherence.reuse_penalty = -0.1).contains("--reuse-penalty: -0.1"));
        assert!(message(|o| o.k_coherence.start_passes = 0).contains("--start-passes: 0"));
        assert!(
            message(|o| o.k_coherence.start_passes = u32::MAX).contains("1 to 1000: each visits")
        );
        assert!(message(|o| o.passes = 1001).contains("--passes: 1001"));
        assert!(message(|o| o.k_coherence.repair_rounds = u32::MAX).contains("0 to 1000"));
        assert!(message(|o| o.k_coherence.coherence = 1e308).contains("1 to 1e12"));
    }

    #[test]
    fn options_of_another_method_are_refused() {
        let found = message(|o| {
            o.method = Method::WeiLevoy;
            o.k_coherence.coherence = 2.0;
        });
        assert!(
            found.contains("--coherence: given with --method wei-levoy"),
            "{found}"
        );
        let found = message(|o| o.adaptive.rings = 5);
        assert!(
            found.contains("--rings: given with --method k-coherence"),
            "{found}"
        );
        let found = message(|o| {
            o.method = Method::Adaptive;
            o.metric = MetricKind::Gram;
        });
        assert!(found.contains("--metric"), "{found}");
        let of = |method, change: fn(&mut SynthesisOptions)| {
            message(|o| {
                o.method = method;
                change(o);
            })
        };
        let found = of(Method::Multiscale, |o| o.passes = 2);
        assert!(
            found.contains("this one has a fixed number of passes"),
            "{found}"
        );
        let found = of(Method::Choosy, |o| o.levels = Some(2));
        assert!(found.contains("this one has --subdivisions"), "{found}");
        let found = of(Method::Coherent, |o| o.choosy.dimensions = 9);
        assert!(
            found.contains("--dimensions: given with --method coherent"),
            "{found}"
        );
        let found = of(Method::Coherent, |o| o.levels = Some(2));
        assert!(
            found.contains("--levels: given with --method coherent"),
            "{found}"
        );
        let found = of(Method::Coherent, |o| o.multiscale.matches = 4);
        assert!(
            found.contains("--matches: given with --method coherent"),
            "{found}"
        );
    }
}
