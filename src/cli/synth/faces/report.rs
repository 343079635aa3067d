//! What `synth --onto faces` reports, for a person and as JSON.

use serde::Serialize;
use serde_json::json;

use crate::byte_size::ByteSize;
use crate::cli::outcome::Outcome;
use crate::cli::synth::report::{FORMAT, Seconds};
use crate::exemplar::space::Space;
use crate::maps::face_map::{FaceMap, Square};
use crate::maps::vertex_map::SurfaceTextonMap;
use crate::mesh::face_colors::Coloring;
use crate::sites::faces::level::FaceLevel;
use crate::sites::faces::pyramid::FacePyramid;
use crate::synthesis::faces::exemplar::SquareExemplar;
use crate::synthesis::faces::histograms::{
    HistogramDistances, histogram_distances, texton_distance,
};
use crate::synthesis::options::SynthesisOptions;
use crate::synthesis::recipes::choosy::ChoosyResult;

/// The `--report` file: the same for the same inputs, options and seed.
#[derive(Debug, Serialize)]
pub(super) struct FaceReport {
    #[serde(flatten)]
    map: MapFigures,
    options: SynthesisOptions,
    /// Eigenvalues of the neighbourhoods, from the coarsest level on.
    eigenvalues: Vec<Vec<f64>>,
    /// Numbers per texel.
    channels: usize,
    /// Share of Φ's spectrum that these keep; 1 for plain images.
    spectrum_kept: f64,
    /// The largest distance of histograms; null for textons.
    histogram_l1: Option<f64>,
    histograms: Vec<HistogramDistances>,
    /// Distance of the texton histograms; null for plain images.
    histogram_chi2: Option<f64>,
    /// Bytes that the work was expected to take.
    memory: u64,
}

/// What was made, and of what.
#[derive(Debug, Serialize)]
struct MapFigures {
    format: &'static str,
    version: u32,
    faces: usize,
    exemplar: [u32; 2],
    /// Left column, top row and side of what is used of the sample.
    square: [u32; 3],
    texel: f64,
    seed: u64,
    levels: usize,
    method: &'static str,
    /// `given`, `retiled` or `barycentric`: how the base mesh came to have two colours.
    base_mesh: &'static str,
    /// Faces of the surface, from the coarsest level on.
    level_faces: Vec<usize>,
    /// Triangles of one of the sample's grids, from the coarsest level on.
    sample_faces: Vec<usize>,
}

impl FaceReport {
    /// The report of a finished map, whose faces have their centres at the vertices of `centers`.
    pub(super) fn new(
        (map, result, surface): (&FaceMap, &ChoosyResult, &FacePyramid),
        (space, exemplar, centers): (&Space, &SquareExemplar, &SurfaceTextonMap),
        (options, seed): (&SynthesisOptions, u64),
        (coloring, memory): (Coloring, u64),
    ) -> Self {
        // Compare the histograms of surface and sample.
        let Square { left, top, side } = map.square;
        let finest = surface.levels.len() - 1;
        let histograms = histogram_distances(space, exemplar, &result.colors);
        let distances = histograms.iter().flat_map(|channel| &channel.l1).copied();
        let counts = |levels: &[FaceLevel]| levels.iter().map(FaceLevel::count).collect();
        // Put the figures together.
        let map = MapFigures {
            format: FORMAT,
            version: 1,
            faces: map.mesh.triangles.len(),
            exemplar: map.header.exemplar,
            square: [left, top, side],
            texel: map.header.texel,
            seed,
            levels: surface.levels.len(),
            method: options.method.name(),
            base_mesh: match coloring {
                Coloring::Given => "given",
                Coloring::Retiled => "retiled",
                Coloring::Barycentric => "barycentric",
            },
            level_faces: counts(&surface.levels),
            sample_faces: counts(&result.sample.grid.pyramid.levels),
        };
        Self {
            map,
            options: SynthesisOptions {
                seed,
                ..options.clone()
            },
            eigenvalues: result.eigenvalues.clone(),
            channels: exemplar.channels,
            spectrum_kept: exemplar.kept,
            histogram_l1: distances.reduce(f64::max),
            histograms,
            histogram_chi2: texton_distance(space, centers, &surface.levels[finest].areas),
            memory,
        }
    }

    /// What the user reads.
    pub(super) fn outcome(&self, seconds: Seconds) -> Outcome {
        let Seconds { prepare, synthesis } = seconds;
        // Tell size and time.
        let counts: Vec<String> = self.map.level_faces.iter().map(usize::to_string).collect();
        let mut outcome = Outcome::default()
            .line(format!(
                "{} faces, {} levels ({}): prepared in {prepare:.1} s, synthesized in {synthesis:.1} s",
                self.map.faces,
                self.map.levels,
                counts.join(", ")
            ))
            .line(match self.map.base_mesh {
                "given" => "base mesh: the given one, which has two colours",
                "retiled" => "base mesh: retiled, in two colours",
                _ => "base mesh: retiled and subdivided barycentrically, because no two colours were found",
            })
            .line(format!("a texel covers {:.6} mesh units", self.map.texel));
        // Tell how flat the neighbourhoods are, and how far the histograms lie apart.
        if let Some([first, rest @ ..]) = self.eigenvalues.last().map(Vec::as_slice) {
            let ratio = |at: usize| rest.get(at).map_or(f64::INFINITY, |value| first / value);
            outcome = outcome.line(format!(
                "eigenvalues of neighbourhoods: the first is {:.0} times the second and {:.0} times the twentieth",
                ratio(0),
                ratio(18)
            ));
        }
        if let Some(distance) = self.histogram_l1 {
            outcome = outcome.line(format!(
                "histogram distance {distance:.4} (L1 of 50 bins, the largest of {} numbers; 0 is the sample's own)",
                self.histograms.iter().map(|channel| channel.l1.len()).sum::<usize>()
            ));
        }
        if let Some(distance) = self.histogram_chi2 {
            outcome = outcome.line(format!(
                "histogram distance {distance:.4} (χ² of textons, surface against sample)"
            ));
        }
        outcome = outcome.line(format!("about {} of memory", ByteSize(self.memory)));
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
