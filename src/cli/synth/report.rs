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
use crate::synthesis::quality::figures::{QualityFigure, figures};

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
    /// The same as people read it.
    #[serde(skip)]
    figures: Vec<QualityFigure>,
    metric_agreement: Option<Agreement>,
    /// Of a method that admits only some texels: choices on the finest level for which no texel that neighbours
    /// proposed was admitted, so that all that are admitted were compared.
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
        let made = MapFigures {
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
            map: made,
            atlas,
            options: options.clone(),
            figures: figures(&quality, map.header.polish > 0),
            quality,
            metric_agreement,
            searched: options.method.reports(Figure::Searched).then_some(searched),
        }
    }

    /// What the user reads.
    pub fn outcome(&self, seconds: Seconds) -> Outcome {
        let lines = self.of_the_map(seconds).into_iter();
        let mut outcome = lines
            .chain(self.of_its_quality())
            .fold(Outcome::default(), Outcome::line);
        // Add all figures.
        if let Ok(serde_json::Value::Object(figures)) = serde_json::to_value(self) {
            outcome.figures = figures;
        }
        let Seconds { prepare, synthesis } = seconds;
        outcome.figure(
            "seconds",
            json!({"prepare": prepare, "synthesis": synthesis}),
        )
    }

    /// Size, time, levels and sites, a line each.
    fn of_the_map(&self, Seconds { prepare, synthesis }: Seconds) -> Vec<String> {
        let mut lines = vec![format!(
            "{} {}, mean edge {:.2} texels, {} levels{}: prepared in {prepare:.1} s, synthesized in {synthesis:.1} s",
            self.map.vertices,
            match self.atlas {
                Some(_) => "texels",
                None => "vertices",
            },
            self.quality.mean_edge,
            self.map.levels,
            self.map.k.map_or(String::new(), |k| format!(", k {k}"))
        )];
        let reason = self.map.levels_reason.iter();
        lines.extend(reason.map(|reason| format!("{} levels: {reason}", self.map.levels)));
        lines.extend(self.atlas.iter().map(AtlasFigures::line));
        let circles = self.map.circles.iter();
        lines.extend(circles.map(|circles| format!("circles round every vertex: {circles}")));
        lines
    }

    /// The quality figures, a line each, and where they are explained.
    fn of_its_quality(&self) -> Vec<String> {
        // Tell the figures with their good ranges.
        let line = |figure: &QualityFigure| {
            let QualityFigure {
                name, value, range, ..
            } = figure;
            format!("{name} {value} (good: {range})")
        };
        let mut lines: Vec<String> = self.figures.iter().map(line).collect();
        // Tell what only some methods and exemplars have.
        if let Some(found) = self.quality.fragments {
            lines.push(format!(
                "{} elements of the mask, {} of them fragments: {:.2} % (in the exemplar {:.2} %)",
                found.components,
                found.fragments,
                100.0 * found.fragment_share,
                100.0 * found.exemplar_fragment_share
            ));
        }
        if let Some(searched) = self.searched {
            lines.push(format!(
                "{searched} choices compared all texels of the site's transition, because neighbours proposed none"
            ));
        }
        if let Some(found) = self.metric_agreement {
            lines.push(format!(
                "metric agreement: the embedded metric chooses as well as Φ at {:.3} of the sites (good: near 1); its mean \
                 score is {:.4} times that of Φ; with the whole spectrum, agreement is {:.4}",
                found.embedded, found.embedded_cost, found.whole_spectrum
            ));
        }
        // Tell where they are explained.
        lines.push("docs/synthesis.md explains these figures.".into());
        lines
    }
}
