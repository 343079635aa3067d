//! The options that all methods of synthesis share, and those of each.

use serde::Serialize;

use crate::error::{Error, Result};
use crate::synthesis::option_ranges::{at_least_one, few_rounds};
use crate::synthesis::recipes::adaptive::options::AdaptiveOptions;
use crate::synthesis::recipes::choosy::options::ChoosyOptions;
use crate::synthesis::recipes::multiscale::options::MultiscaleOptions;
use crate::synthesis::recipes::progressive::options::ProgressiveOptions;
pub use crate::synthesis::recipes::tong::options::{KCoherenceOptions, Search};

/// The method of synthesis, by its paper.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// Tong 2002: coherent texels and the nearest of each, level after level
    #[default]
    KCoherence,
    /// Wei and Levoy 2001: every texel is compared at every site; slow, for comparison
    WeiLevoy,
    /// Chen and Dong 2008: round neighbourhoods of growing size on the same sites at every level
    Adaptive,
    /// Ying 2001 §4: every texel is compared, first on the coarser level alone; one of the nearest is drawn at random
    Multiscale,
    /// Ying 2001 §5: continues the patches of finished sites at real coordinates; one level, one pass, fast
    Coherent,
    /// Zhang 2003 §5: textures that change over the surface, with masks that keep elements whole
    Progressive,
    /// Castellanos and Williams: isotropic textures on faces, without an orientation
    Choosy,
}

impl Method {
    /// Its name on the command line and in maps.
    pub fn name(self) -> &'static str {
        match self {
            Self::KCoherence => "k-coherence",
            Self::WeiLevoy => "wei-levoy",
            Self::Adaptive => "adaptive",
            Self::Multiscale => "multiscale",
            Self::Coherent => "coherent",
            Self::Progressive => "progressive",
            Self::Choosy => "choosy",
        }
    }
}

/// Refuses choosy sampling on sites that are no faces:
/// [`synthesize_faces`](crate::synthesis::recipes::choosy::synthesize_faces) is its way in.
pub(crate) fn needs_faces() -> Error {
    Error::option(
        "method",
        "choosy, which writes on faces",
        "--onto faces as well",
    )
}

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
    /// Levels of the pyramid, the finest included; 1 grows the finest level from one random site [default: chosen for
    /// a mesh, else the table's; 2 with --method adaptive; with --method multiscale those that its windows fit;
    /// --method coherent has 1]
    #[arg(long)]
    pub levels: Option<u32>,
    /// Width of the neighbourhood; it must be the table's
    #[arg(long)]
    pub neighborhood: Option<u32>,
    /// How neighbourhoods are compared
    #[arg(long, value_enum, default_value_t = Self::default().metric)]
    pub metric: MetricKind,
    /// Share of the centred Gram matrix's spectrum that the embedded metric keeps (above 0, to 1);
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
        self.k_coherence.validate()?;
        self.adaptive.validate()?;
        self.multiscale.validate()?;
        self.progressive.validate()?;
        self.choosy.check()?;
        self.check_method()
    }

    /// Levels of the adaptive method, of at most `most`: two unless more are asked for, as the circles of
    /// coarser levels are wide.
    pub fn adaptive_levels(&self, most: usize) -> usize {
        self.levels.map_or(most.min(2), |levels| levels as usize)
    }

    /// Refuses options that the method does not use.
    fn check_method(&self) -> Result<()> {
        // Refuse options of other methods.
        let name = self.method.name();
        if self.method != Method::KCoherence {
            self.k_coherence.refuse_for(name)?;
        }
        if self.method != Method::Adaptive {
            self.adaptive.refuse_for(name)?;
        }
        if self.method != Method::Multiscale {
            self.multiscale.refuse_for(name)?;
        }
        if self.method != Method::Progressive {
            self.progressive.refuse_for(name)?;
        }
        if self.method != Method::Choosy {
            self.choosy.refuse_for(name)?;
        }
        // Refuse too few passes.
        if self.method == Method::Progressive && self.passes < 2 {
            let found = format!("{} with --method {name}", self.passes);
            return Err(Error::option(
                "passes",
                found,
                "2 or more: the first is a guess",
            ));
        }
        match self.unused_option() {
            None => Ok(()),
            Some((option, has)) => Err(Error::option(
                option,
                format!("given with --method {name}"),
                format!("another method: this one has {has}"),
            )),
        }
    }

    /// A given one of the options that several methods share, and what this method has instead of it.
    fn unused_option(&self) -> Option<(&'static str, &'static str)> {
        // Tell which shared options the method has no use for.
        let default = Self::default();
        let (levels, metric, neighborhood, passes) = match self.method {
            Method::KCoherence | Method::WeiLevoy => return None,
            Method::Adaptive => (false, true, true, true),
            Method::Multiscale => (false, false, true, true),
            Method::Coherent => (true, true, true, true),
            Method::Choosy => return self.unused_by_choosy(),
            Method::Progressive => (false, true, true, false),
        };
        // Find one that was given.
        let given = [
            (
                levels && self.levels.is_some_and(|levels| levels != 1),
                "levels",
                "one level",
            ),
            (
                metric && self.metric != default.metric,
                "metric",
                "a metric of its own",
            ),
            (
                neighborhood && self.neighborhood.is_some(),
                "neighborhood",
                "neighbourhoods of its own",
            ),
            (
                passes && self.passes != default.passes,
                "passes",
                "a fixed number of passes",
            ),
        ];
        let first = given.into_iter().find(|(given, ..)| *given);
        first.map(|(_, option, has)| (option, has))
    }

    /// An option that choosy sampling has another word for, or no use of.
    fn unused_by_choosy(&self) -> Option<(&'static str, &'static str)> {
        let default = Self::default();
        let given = [
            (
                self.levels.is_some(),
                "levels",
                "--subdivisions, one less than levels",
            ),
            (
                self.metric != default.metric,
                "metric",
                "a metric of its own",
            ),
            (
                self.neighborhood.is_some(),
                "neighborhood",
                "neighbourhoods of its own",
            ),
            (self.passes != default.passes, "passes", "--iterations"),
        ];
        let first = given.into_iter().find(|(given, ..)| *given);
        first.map(|(_, option, has)| (option, has))
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
