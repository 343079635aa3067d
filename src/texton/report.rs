//! What texton analysis reports about itself: time per stage, routes, inertia, cluster sizes.

use std::time::Instant;

use serde::Serialize;

use crate::texton::gram_kmeans::Clustering;
use crate::texton::plan::Route;
use crate::texton::representatives::ImageVectors;
use crate::texton::sketch::Fidelity;

/// The report of one analysis.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct AnalysisReport {
    /// Wall-clock time of every stage, in order.
    pub stages: Vec<StageTime>,
    /// Images of the sample.
    pub images: usize,
    /// Images the appearance vectors are made of.
    pub representatives: usize,
    /// How often the most-read image was read.
    pub times_read: u32,
    /// Whether image appearance vectors were folded to few numbers.
    pub image_vectors_folded: bool,
    /// Bytes the plan expected to take at most.
    pub planned_bytes: u64,
    /// Level by level, finest first.
    pub levels: Vec<LevelReport>,
}

/// Time of one stage.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StageTime {
    /// What was done.
    pub name: String,
    /// Wall-clock seconds.
    pub seconds: f64,
}

/// What happened on one level.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LevelReport {
    /// Columns of texels.
    pub width: u32,
    /// Rows of texels.
    pub height: u32,
    /// How the textons were found.
    pub route: Route,
    /// Textons found.
    pub textons: usize,
    /// Sum of squared distances of the texels to their texton.
    pub inertia: f64,
    /// Lloyd steps.
    pub iterations: u32,
    /// Empty clusters given another point.
    pub refilled: u32,
    /// Texels that are the same as an earlier one (Gram route).
    pub duplicates: u32,
    /// Texels of each texton.
    pub cluster_sizes: Vec<u32>,
    /// Share of the variance the route works with: 1 on the Gram route.
    pub explained_variance: f64,
    /// Mean share by which squared distances are too short: 0 on the Gram route.
    pub distortion: f64,
}

impl LevelReport {
    /// The report of a level's clustering.
    pub fn new(
        sides: [u32; 2],
        route: Route,
        found: &Clustering,
        fidelity: Option<Fidelity>,
    ) -> Self {
        Self {
            width: sides[0],
            height: sides[1],
            route,
            textons: found.counts.len(),
            inertia: found.inertia,
            iterations: found.iterations,
            refilled: found.refilled,
            duplicates: found.duplicates,
            cluster_sizes: found.counts.clone(),
            explained_variance: fidelity.map_or(1.0, |f| f.explained_variance),
            distortion: fidelity.map_or(0.0, |f| f.distortion),
        }
    }
}

impl AnalysisReport {
    /// Does a stage and notes its time.
    pub fn measure<T>(&mut self, name: impl Into<String>, stage: impl FnOnce() -> T) -> T {
        let start = Instant::now();
        let result = stage();
        self.stages.push(StageTime {
            name: name.into(),
            seconds: start.elapsed().as_secs_f64(),
        });
        result
    }

    /// Notes how images are held.
    pub fn note_images(&mut self, images: usize, representatives: usize, held: ImageVectors) {
        self.images = images;
        self.representatives = representatives;
        self.image_vectors_folded = held == ImageVectors::Folded;
    }
}
