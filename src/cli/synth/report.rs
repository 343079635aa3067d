//! What `synth` reports: options and quality figures, for a person and as JSON.

use std::time::Duration;

use serde::Serialize;
use serde_json::json;

use crate::cli::outcome::Outcome;
use crate::maps::vertex_map::SurfaceTextonMap;
use crate::synthesis::check::Plan;
use crate::synthesis::options::{Method, SynthesisOptions};
use crate::synthesis::quality::Quality;
use crate::synthesis::quality::agreement::Agreement;

/// What a report calls itself.
pub const FORMAT: &str = "mesotex-synthesis-report";

/// The `--report` file: the same for the same inputs, options and seed.
#[derive(Debug, Serialize)]
pub struct Report {
    format: &'static str,
    version: u32,
    vertices: usize,
    exemplar: [u32; 2],
    texel: f64,
    seed: u64,
    /// Of k-coherence alone.
    k: Option<usize>,
    levels: usize,
    method: &'static str,
    /// Whether circles were marched, where the method has them.
    circles: Option<&'static str>,
    options: SynthesisOptions,
    #[serde(flatten)]
    quality: Quality,
    metric_agreement: Option<Agreement>,
}

/// How long it took.
#[derive(Clone, Copy, Debug)]
pub struct Seconds {
    prepare: f64,
    synthesis: f64,
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
        plan: &Plan,
        circles: Option<&'static str>,
        quality: Quality,
        metric_agreement: Option<Agreement>,
    ) -> Self {
        Self {
            format: FORMAT,
            version: 1,
            vertices: map.mesh.positions.len(),
            exemplar: map.exemplar,
            texel: map.texel,
            seed: map.seed,
            k: (options.method == Method::KCoherence).then_some(plan.k),
            levels: plan.levels,
            method: options.method.name(),
            circles,
            options: options.clone(),
            quality,
            metric_agreement,
        }
    }

    /// What the user reads.
    pub fn outcome(&self, seconds: Seconds) -> Outcome {
        let found = &self.quality;
        let [[a, b], [c, d]] = found.drift;
        let Seconds { prepare, synthesis } = seconds;
        let mut outcome = Outcome::default()
            .line(format!(
                "{} vertices, {} levels{}: prepared in {prepare:.1} s, synthesized in {synthesis:.1} s",
                self.vertices,
                self.levels,
                self.k.map_or(String::new(), |k| format!(", k {k}"))
            ))
            .line(format!(
                "coherence {:.3} within half a texel, {:.3} within one; mean edge {:.2} texels",
                found.coherence_half, found.coherence_one, found.mean_edge
            ))
            .line(format!("drift [[{a:.3}, {b:.3}], [{c:.3}, {d:.3}]]"));
        if let Some(found) = found.energies {
            outcome = outcome.line(format!(
                "energy {:.3} of a random map's, {:.3} of the best texels' (at {} sites)",
                found.energy, found.energy_ratio_full, found.energy_sites
            ));
        }
        if let Some(circles) = self.circles {
            outcome = outcome.line(format!("circles round every vertex: {circles}"));
        }
        if let Some(chi2) = found.histogram_chi2 {
            outcome = outcome.line(format!(
                "histogram distance {chi2:.4} (χ², surface against sample)"
            ));
        }
        if let Some(found) = self.metric_agreement {
            outcome = outcome.line(format!(
                "metric: picks what Φ does at {:.3} of sites, for {:.4} of its score; whole spectrum {:.4}",
                found.embedded, found.embedded_cost, found.whole_spectrum
            ));
        }
        if let Ok(serde_json::Value::Object(figures)) = serde_json::to_value(self) {
            outcome.figures = figures;
        }
        outcome.figure(
            "seconds",
            json!({"prepare": prepare, "synthesis": synthesis}),
        )
    }
}
