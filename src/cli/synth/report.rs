//! What `synth` reports: options and quality figures, for a person and as JSON.

use std::time::Duration;

use serde::Serialize;
use serde_json::json;

use crate::cli::outcome::Outcome;
use crate::maps::vertex_map::SurfaceTextonMap;
use crate::sites::target::{Target, TargetSites};
use crate::synthesis::check::Plan;
use crate::synthesis::method::Figure;
use crate::synthesis::options::SynthesisOptions;
use crate::synthesis::quality::Quality;
use crate::synthesis::quality::agreement::Agreement;

/// What a report calls itself.
pub const FORMAT: &str = "mesotex-synthesis-report";

/// The `--report` file: the same for the same inputs, options and seed.
#[derive(Debug, Serialize)]
pub struct Report {
    #[serde(flatten)]
    map: MapFigures,
    /// Of an atlas.
    #[serde(flatten)]
    atlas: Option<AtlasFigures>,
    options: SynthesisOptions,
    #[serde(flatten)]
    quality: Quality,
    metric_agreement: Option<Agreement>,
    /// Of a method that admits only some texels: choices on the finest level for which no texel that neighbours proposed was
    /// admitted, so that all that are admitted were compared.
    #[serde(skip_serializing_if = "Option::is_none")]
    searched: Option<u64>,
}

/// What was made, and of what.
#[derive(Debug, Serialize)]
struct MapFigures {
    format: &'static str,
    version: u32,
    vertices: usize,
    exemplar: [u32; 2],
    texel: f64,
    seed: u64,
    /// Of methods that try the nearest of coherent texels.
    k: Option<usize>,
    levels: usize,
    /// Why these, where they were chosen.
    #[serde(skip_serializing_if = "Option::is_none")]
    levels_reason: Option<String>,
    method: &'static str,
    /// Whether circles were marched, where the method has them.
    circles: Option<&'static str>,
}

/// How the neighbourhoods of an atlas were sampled at the finest level.
#[derive(Clone, Debug, Serialize)]
pub struct AtlasFigures {
    /// Texels along each side.
    resolution: u32,
    /// Charts.
    charts: usize,
    /// How often a control mesh was subdivided, where its faces are the charts.
    #[serde(skip_serializing_if = "Option::is_none")]
    subdivisions: Option<u32>,
    /// The mean stretch of the samples, and that of the best 95 % of texels at the most.
    stretch_mean: f32,
    stretch_95: f32,
    /// Shares of samples beyond the surface, and without a place in a chart.
    samples_outside: f64,
    samples_marched: f64,
}

impl AtlasFigures {
    /// The figures of a target, if it is an atlas.
    pub fn of(target: &Target) -> Option<Self> {
        let (TargetSites::Atlas(sites), Some(atlas)) = (&target.sites, &target.surface.atlas)
        else {
            return None;
        };
        let finest = sites.levels.first()?;
        let mut stretch = atlas.stretch(finest);
        stretch.retain(|stretch| stretch.is_finite());
        stretch.sort_by(f32::total_cmp);
        let counts = atlas.counts.first()?;
        let share = |of: u64| of as f64 / (counts.valued + counts.outside).max(1) as f64;
        Some(Self {
            resolution: atlas.points.width,
            charts: atlas.atlas.charts,
            subdivisions: atlas.subdivisions,
            stretch_mean: stretch.iter().sum::<f32>() / stretch.len().max(1) as f32,
            stretch_95: stretch
                .get(stretch.len() * 95 / 100)
                .copied()
                .unwrap_or(0.0),
            samples_outside: share(counts.outside),
            samples_marched: share(counts.marched),
        })
    }

    fn line(&self) -> String {
        let faces = self.subdivisions.map_or(String::new(), |steps| {
            format!(", the faces of a control mesh subdivided {steps} times")
        });
        format!(
            "{0}x{0} texels, {1} charts{faces}: samples stretch the texture by {2:.3} on average, and by at most {3:.3} at \
             95 % of the texels",
            self.resolution, self.charts, self.stretch_mean, self.stretch_95
        )
    }
}

/// How long it took.
#[derive(Clone, Copy, Debug)]
pub struct Seconds {
    pub(super) prepare: f64,
    pub(super) synthesis: f64,
}

impl Seconds {
    /// Of the time until the target was prepared, and until the map was done.
    pub fn new(prepared: Duration, done: Duration) -> Self {
        Self {
            prepare: prepared.as_secs_f64(),
            synthesis: (done - prepared).as_secs_f64(),
        }
    }
}

impl Report {
    /// The report of a finished map.
    pub fn new(
        map: &SurfaceTextonMap,
        options: &SynthesisOptions,
        (plan, levels_reason): (&Plan, Option<String>),
        (circles, atlas): (Option<&'static str>, Option<AtlasFigures>),
        quality: Quality,
        metric_agreement: Option<Agreement>,
        searched: u64,
    ) -> Self {
        let figures = MapFigures {
            format: FORMAT,
            version: 1,
            vertices: map.mesh.positions.len(),
            exemplar: map.header.exemplar,
            texel: map.header.texel,
            seed: map.header.seed,
            k: options.method.reports(Figure::K).then_some(plan.k),
            levels: plan.levels,
            levels_reason,
            method: options.method.name(),
            circles,
        };
        Self {
            map: figures,
            atlas,
            options: options.clone(),
            quality,
            metric_agreement,
            searched: options.method.reports(Figure::Searched).then_some(searched),
        }
    }

    /// What the user reads.
    pub fn outcome(&self, seconds: Seconds) -> Outcome {
        let found = &self.quality;
        let [[a, b], [c, d]] = found.drift;
        let Seconds { prepare, synthesis } = seconds;
        // Tell size and time.
        let mut outcome = Outcome::default()
            .line(format!(
                "{} {}, {} levels{}: prepared in {prepare:.1} s, synthesized in {synthesis:.1} s",
                self.map.vertices,
                match self.atlas {
                    Some(_) => "texels",
                    None => "vertices",
                },
                self.map.levels,
                self.map.k.map_or(String::new(), |k| format!(", k {k}"))
            ))
            // Tell how the texture follows the surface.
            .line(format!(
                "coherence {:.3} within half a texel (good: above 0.4), {:.3} within one (above 0.7); mean edge \
                 {:.2} texels",
                found.coherence_half, found.coherence_one, found.mean_edge
            ))
            .line(format!("drift [[{a:.3}, {b:.3}], [{c:.3}, {d:.3}]] (good: within 0.1 of the identity)"));
        if let Some(reason) = &self.map.levels_reason {
            outcome = outcome.line(format!("{} levels: {reason}", self.map.levels));
        }
        // Tell what was measured beside.
        if let Some(found) = found.energies {
            outcome = outcome.line(format!(
                "energy {:.3} times that of a random map (good: below 0.3), {:.3} times that of the best texels, measured \
                 at {} sites (good: below 1.1)",
                found.energy, found.energy_ratio_full, found.energy_sites
            ));
        }
        if let Some(atlas) = &self.atlas {
            outcome = outcome.line(atlas.line());
        }
        if let Some(circles) = self.map.circles {
            outcome = outcome.line(format!("circles round every vertex: {circles}"));
        }
        if let Some(chi2) = found.histogram_chi2 {
            outcome = outcome.line(format!(
                "histogram distance {chi2:.4} (χ² of texton counts, surface against sample; good: below 0.01)"
            ));
        }
        if let Some(found) = found.fragments {
            outcome = outcome.line(format!(
                "{} elements of the mask, {} of them fragments: {:.2} % (in the exemplar {:.2} %)",
                found.components,
                found.fragments,
                100.0 * found.fragment_share,
                100.0 * found.exemplar_fragment_share
            ));
        }
        if let Some(searched) = self.searched {
            outcome = outcome.line(format!(
                "{searched} choices compared all texels of the site's transition, because neighbours proposed none"
            ));
        }
        if let Some(found) = self.metric_agreement {
            outcome = outcome.line(format!(
                "metric agreement: the embedded metric chooses as well as Φ at {:.3} of the sites (good: near 1); its mean \
                 score is {:.4} times that of Φ; with the whole spectrum, agreement is {:.4}",
                found.embedded, found.embedded_cost, found.whole_spectrum
            ));
        }
        // Add all figures.
        if let Ok(serde_json::Value::Object(figures)) = serde_json::to_value(self) {
            outcome.figures = figures;
        }
        outcome.figure(
            "seconds",
            json!({"prepare": prepare, "synthesis": synthesis}),
        )
    }
}
