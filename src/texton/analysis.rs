//! Texton analysis from beginning to end (Tong 2002 §4 and §5.1).
//!
//! In: a sample. Out: its vocabulary, level by level, and a report. The images are read to choose
//! representatives, for the texels' dot products (or, where these are too many, twice for a
//! sketch), and for the centres.

use ndarray::Array3;

use crate::btf::sample::Sample;
use crate::error::{Error, Result};
use crate::format::id::ContentId;
use crate::progress::Progress;
use crate::texton::clustering::{self, Found};
use crate::texton::eigenplanes::Eigenplanes;
use crate::texton::filter_bank::{FILTERS, leung_malik};
use crate::texton::filtered_level::FilteredLevel;
use crate::texton::image_batches::{ImageBatches, PlaneSource};
use crate::texton::options::TextonOptions;
use crate::texton::parts::Parts;
use crate::texton::plan::Plan;
use crate::texton::report::{AnalysisReport, LevelReport};
use crate::texton::representatives;
use crate::texton::response_sums::sum_responses;
use crate::texton::row_blocks::RowBlocks;
use crate::texton::study::{self, Study};
use crate::texton::texel_sums::TexelSums;
use crate::texton::vocabulary::{FactorBasis, FoundVocabulary, VocabularyLevel};

/// What texton analysis finds.
#[derive(Debug)]
pub struct Analysis {
    /// The textons of every level.
    pub vocabulary: FoundVocabulary,
    /// How they were found.
    pub report: AnalysisReport,
}

/// Finds the 3D textons of a sample.
pub fn analyze(
    sample: &Sample,
    options: &TextonOptions,
    progress: Progress<'_>,
) -> Result<Analysis> {
    find(&Study::new(sample, options)?, None, progress)
}

/// Finds the textons of a study. What its `parts` hold is read from them and not made from the images; the textons
/// are the same.
pub fn find(
    study: &Study<'_>,
    mut parts: Option<Parts>,
    progress: Progress<'_>,
) -> Result<Analysis> {
    let Study {
        stack,
        options,
        plan,
        ..
    } = study;
    let mut report = AnalysisReport {
        planned_bytes: plan.bytes,
        ..AnalysisReport::default()
    };
    // Make the filters of every level.
    let bank = leung_malik();
    let levels: Vec<FilteredLevel<'_>> = report.measure("filter bank", || {
        let grids = stack.grids.iter();
        grids.map(|&grid| FilteredLevel::new(grid, &bank)).collect()
    });
    let planes = ChosenPlanes::of(study, &bank, parts.as_mut(), &mut report, progress)?;
    // Find the textons of every level, and their centres.
    let blocks = study.blocks_of(planes.source());
    let mut batches = ImageBatches::new(stack, planes.source(), blocks, plan.keep_images);
    let summed = match &mut parts {
        Some(parts) => parts.image_products(study)?,
        None => None,
    };
    let found = clustering::find(
        &mut batches,
        &levels,
        plan.sketched(),
        summed,
        options,
        &mut report,
        progress,
    )?;
    let centroids = report.measure("texton centres", || {
        centroids(&mut batches, &levels, &found, progress)
    })?;
    // Report, and put the vocabulary together.
    let chosen_by_reading =
        parts.is_none() && planes.representatives.len() < stack.sample.image_count();
    report.times_read = batches.passes() + u32::from(chosen_by_reading);
    report.levels = level_reports(&levels, plan, &found);
    let vocabulary = FoundVocabulary {
        levels: assemble(&levels, found, centroids),
        ..planes.described(study, &bank)?
    };
    Ok(Analysis { vocabulary, report })
}

/// The images whose filter responses make up the appearance vectors.
struct ChosenPlanes<'a> {
    representatives: Vec<u32>,
    /// The planes that stand for them, where the sample is factored.
    eigenplanes: Option<Eigenplanes<'a>>,
}

impl<'a> ChosenPlanes<'a> {
    /// Chooses the images, and makes the planes that stand for them.
    fn of(
        study: &Study<'a>,
        bank: &Array3<f64>,
        parts: Option<&mut Parts>,
        report: &mut AnalysisReport,
        progress: Progress<'_>,
    ) -> Result<Self> {
        let Study { stack, plan, .. } = study;
        let representatives = report.measure("representative images", || {
            choose_representatives(study, bank, parts, progress)
        })?;
        report.note_images(
            stack.sample.image_count(),
            representatives.len(),
            plan.image_vectors,
        );
        let factors = study::standing_for(stack.sample, representatives.len(), stack.channels);
        let eigenplanes = factors.map(|factors| {
            report.measure("eigenplanes", || {
                Eigenplanes::new(factors, &representatives, stack.channels)
            })
        });
        Ok(Self {
            representatives,
            eigenplanes,
        })
    }

    fn source(&self) -> PlaneSource<'_> {
        match &self.eigenplanes {
            Some(planes) => PlaneSource::Eigenplanes(planes),
            None => PlaneSource::Images(&self.representatives),
        }
    }

    /// A vocabulary of these images that has no levels yet.
    fn described(self, study: &Study<'_>, bank: &Array3<f64>) -> Result<FoundVocabulary> {
        let Study { stack, options, .. } = study;
        let sample = stack.sample;
        let factor_basis = self.eigenplanes.map(|planes| FactorBasis {
            rank: planes.rank(),
            sets: planes.sets(),
            matrix: planes.into_inverse_root(),
        });
        Ok(FoundVocabulary {
            levels: Vec::new(),
            representatives: self.representatives,
            filters: bank.mapv(|tap| tap as f32),
            channels: stack.channels.count() as u32,
            factor_basis,
            tileable: stack.grids[0].tileable,
            options: study::recorded(options)?,
            seed: options.seed,
            texel_mm: sample.description().texel_mm,
            sample: sample.id().clone(),
            id: ContentId::of_bytes(&[]),
        })
    }
}

fn choose_representatives(
    study: &Study<'_>,
    bank: &Array3<f64>,
    parts: Option<&mut Parts>,
    progress: Progress<'_>,
) -> Result<Vec<u32>> {
    let Some(count) = study.chosen()? else {
        return Ok((0..study.stack.sample.image_count() as u32).collect());
    };
    let mut random = study::random_of_images(study.options);
    let appearance = study.appearance(bank, &mut random);
    let vectors = match parts {
        Some(parts) => {
            parts.image_vectors(study.stack.sample.image_count(), appearance.columns())?
        }
        None => appearance.all(progress)?,
    };
    let held = study.plan.image_vectors;
    let chosen = representatives::choose(vectors, held, count, &mut random, progress)?;
    if chosen.len() < count {
        progress.warn(format!(
            "the sample has only {} distinct images; taking these instead of {count}",
            chosen.len()
        ));
    }
    Ok(chosen)
}

/// The textons' appearance vectors, level by level: the means of their members.
fn centroids(
    batches: &mut ImageBatches<'_>,
    levels: &[FilteredLevel<'_>],
    found: &[Found],
    progress: Progress<'_>,
) -> Result<Vec<RowBlocks>> {
    let components = batches.planes() * FILTERS;
    let mut targets: Vec<_> = levels
        .iter()
        .zip(found)
        .map(|(level, Found { clustering, .. })| {
            let place = |texel| level.filters.place(texel);
            let averages = TexelSums::averages(&clustering.labels, &clustering.counts, place);
            let centroids = RowBlocks::zeros(averages.count(), components).map_err(|error| {
                Error::data("texton centres", format!("no memory for them: {error}"))
                    .advice("take fewer --images or --textons")
            })?;
            Ok((averages, centroids))
        })
        .collect::<Result<_>>()?;
    batches.each("texton centres", progress, |batch| {
        let planes = batch.planes;
        for (((averages, centroids), planes), level) in targets.iter_mut().zip(planes).zip(levels) {
            let range = level.components(batch.first, planes);
            let target = centroids.columns_mut(range);
            sum_responses(&level.filters, averages, planes, target);
        }
    })?;
    Ok(targets.into_iter().map(|(_, rows)| rows).collect())
}

fn level_reports(levels: &[FilteredLevel<'_>], plan: &Plan, found: &[Found]) -> Vec<LevelReport> {
    let levels = levels.iter().zip(&plan.routes).zip(found);
    levels
        .map(|((level, &route), found)| {
            let sides = [level.grid.width, level.grid.height];
            LevelReport::new(sides, route, &found.clustering, found.fidelity)
        })
        .collect()
}

fn assemble(
    levels: &[FilteredLevel<'_>],
    found: Vec<Found>,
    centroids: Vec<RowBlocks>,
) -> Vec<VocabularyLevel<RowBlocks>> {
    let levels = levels.iter().zip(found).zip(centroids);
    levels
        .map(|((level, Found { clustering, .. }), centroids)| {
            let labels = clustering.labels.iter();
            VocabularyLevel {
                grid: level.grid,
                labels: labels.map(|&label| label as u16).collect(),
                centroids,
                counts: clustering.counts,
                inertia: clustering.inertia,
                iterations: clustering.iterations,
            }
        })
        .collect()
}
