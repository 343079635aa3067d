//! Texton analysis from beginning to end (Tong 2002 §4 and §5.1).
//!
//! In: a sample. Out: its vocabulary, level by level, and a report. The images are read to choose
//! representatives, for the texels' dot products (or, where these are too many, twice for a
//! sketch), and for the centres.

use ndarray::Array3;
use serde_json::Value;

use crate::btf::factored::Factors;
use crate::btf::sample::Sample;
use crate::error::{Error, Result};
use crate::format::id::ContentId;
use crate::progress::Progress;
use crate::random::stream;
use crate::texton::eigenplanes::Eigenplanes;
use crate::texton::filter_bank::{FILTERS, leung_malik};
use crate::texton::image_stack::{Channels, ImageStack};
use crate::texton::level::Level;
use crate::texton::level_textons::{self, Found};
use crate::texton::mixed_responses::mix_into;
use crate::texton::options::TextonOptions;
use crate::texton::panels::{Panels, PlaneSource};
use crate::texton::plan::{Plan, Sizes};
use crate::texton::report::{AnalysisReport, LevelReport};
use crate::texton::representatives;
use crate::texton::row_blocks::RowBlocks;
use crate::texton::sub_grid::SubGrid;
use crate::texton::texel_mixtures::TexelMixtures;
use crate::texton::vocabulary::{FactorBasis, FoundVocabulary, VocabularyLevel};

/// What texton analysis finds.
#[derive(Debug)]
pub struct Analysis {
    /// The textons of every level.
    pub vocabulary: FoundVocabulary,
    /// How they were found.
    pub report: AnalysisReport,
}

/// What an analysis would take of memory, and by which routes it would go.
pub fn planned(sample: &Sample, options: &TextonOptions) -> Result<Plan> {
    options.validate()?;
    let stack = ImageStack {
        sample,
        channels: channels(options),
        grids: options.grids(sample)?,
    };
    plan(&stack, options)
}

/// Finds the 3D textons of a sample.
pub fn analyze(
    sample: &Sample,
    options: &TextonOptions,
    progress: Progress<'_>,
) -> Result<Analysis> {
    options.validate()?;
    let stack = ImageStack {
        sample,
        channels: channels(options),
        grids: options.grids(sample)?,
    };
    let plan = plan(&stack, options)?;
    let mut report = AnalysisReport {
        planned_bytes: plan.bytes,
        ..AnalysisReport::default()
    };
    let bank = leung_malik();
    let levels: Vec<Level<'_>> = report.measure("filter bank", || {
        let grids = stack.grids.iter();
        grids.map(|&grid| Level::new(grid, &bank)).collect()
    });
    let representatives = report.measure("representative images", || {
        choose_representatives(&stack, &bank, &plan, options, progress)
    })?;
    report.note_images(
        sample.image_count(),
        representatives.len(),
        plan.image_vectors,
    );
    let factors = standing_for(sample, representatives.len(), stack.channels);
    let eigenplanes = factors.map(|factors| {
        report.measure("eigenplanes", || {
            Eigenplanes::new(factors, &representatives, stack.channels)
        })
    });
    let source = match &eigenplanes {
        Some(planes) => PlaneSource::Eigenplanes(planes),
        None => PlaneSource::Images(&representatives),
    };
    let mut panels = Panels::new(&stack, source, plan.keep_images);
    let sketched = plan.sketched();
    let found = level_textons::find(
        &mut panels,
        &levels,
        sketched,
        options,
        &mut report,
        progress,
    )?;
    let centroids = report.measure("texton centres", || {
        centroids(&mut panels, &levels, &found, progress)
    })?;
    let chosen_by_reading = u32::from(representatives.len() < sample.image_count());
    report.times_read = panels.passes() + chosen_by_reading;
    report.levels = level_reports(&levels, &plan, &found);
    let vocabulary = FoundVocabulary {
        levels: assemble(&levels, found, centroids),
        filters: bank.mapv(|tap| tap as f32),
        channels: stack.channels.count() as u32,
        factor_basis: eigenplanes.map(|planes| FactorBasis {
            rank: planes.rank(),
            sets: planes.sets(),
            matrix: planes.into_inverse_root(),
        }),
        tileable: stack.grids[0].tileable,
        options: recorded(options)?,
        seed: options.seed,
        texel_mm: sample.description().texel_mm,
        sample: sample.id().clone(),
        id: ContentId::of_bytes(&[]),
        representatives,
    };
    Ok(Analysis { vocabulary, report })
}

/// The factors whose planes take the place of so many images: where they are no more than the images'.
fn standing_for(sample: &Sample, images: usize, channels: Channels) -> Option<&Factors> {
    let factors = sample.factors()?;
    (Eigenplanes::count_of(factors) <= images * channels.count()).then_some(factors)
}

fn channels(options: &TextonOptions) -> Channels {
    if options.luminance {
        Channels::Luminance
    } else {
        Channels::Rgb
    }
}

fn plan(stack: &ImageStack<'_>, options: &TextonOptions) -> Result<Plan> {
    let points = |side: u32| options.image_grid.min(side) as usize;
    let sub_grid = points(stack.grids[0].height) * points(stack.grids[0].width);
    let representatives = options.image_count(stack.sample)?;
    let factors = standing_for(stack.sample, representatives, stack.channels);
    let sizes = Sizes {
        grids: &stack.grids,
        textons: (0..stack.grids.len())
            .map(|level| options.textons_at(level))
            .collect(),
        channels: stack.channels.count(),
        images: stack.sample.image_count(),
        representatives,
        eigenplanes: factors.map(Eigenplanes::count_of),
        factor_bytes: stack.sample.factors().map_or(0, Factors::bytes),
        image_components: stack.channels.count() * sub_grid * FILTERS,
    };
    Plan::new(&sizes, options.memory)
}

fn choose_representatives(
    stack: &ImageStack<'_>,
    bank: &Array3<f64>,
    plan: &Plan,
    options: &TextonOptions,
    progress: Progress<'_>,
) -> Result<Vec<u32>> {
    let count = options.image_count(stack.sample)?;
    let held = stack.sample.image_count();
    if count == held {
        return Ok((0..held as u32).collect());
    }
    let sub_grid = SubGrid::new(stack.grids[0], bank, options.image_grid as usize);
    let mut random = stream(options.seed, "representative images", 0, 0);
    let chosen = representatives::choose(
        stack,
        &sub_grid,
        count,
        plan.image_vectors,
        &mut random,
        progress,
    )?;
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
    panels: &mut Panels<'_>,
    levels: &[Level<'_>],
    found: &[Found],
    progress: Progress<'_>,
) -> Result<Vec<RowBlocks>> {
    let components = panels.planes() * FILTERS;
    let mut targets: Vec<_> = levels
        .iter()
        .zip(found)
        .map(|(level, Found { clustering, .. })| {
            let place = |texel| level.filters.place(texel);
            let averages = TexelMixtures::averages(&clustering.labels, &clustering.counts, place);
            let centroids = RowBlocks::zeros(averages.count(), components).map_err(|error| {
                Error::data("texton centres", format!("no memory for them: {error}"))
                    .advice("take fewer --images or --textons")
            })?;
            Ok((averages, centroids))
        })
        .collect::<Result<_>>()?;
    panels.each("texton centres", progress, |first, planes| {
        for (((averages, centroids), planes), level) in targets.iter_mut().zip(planes).zip(levels) {
            let range = level.components(first, planes);
            let target = centroids.columns_mut(range);
            mix_into(&level.filters, averages, planes, target);
        }
    })?;
    Ok(targets.into_iter().map(|(_, rows)| rows).collect())
}

fn level_reports(levels: &[Level<'_>], plan: &Plan, found: &[Found]) -> Vec<LevelReport> {
    let levels = levels.iter().zip(&plan.routes).zip(found);
    levels
        .map(|((level, &route), found)| {
            let sides = [level.grid.width, level.grid.height];
            LevelReport::new(sides, route, &found.clustering, found.fidelity)
        })
        .collect()
}

fn assemble(
    levels: &[Level<'_>],
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

/// The options as a file keeps them: without the memory, which is the machine's affair.
fn recorded(options: &TextonOptions) -> Result<Value> {
    let mut value =
        serde_json::to_value(options).map_err(|error| Error::data("options", error.to_string()))?;
    if let Value::Object(map) = &mut value {
        map.remove("memory");
    }
    Ok(value)
}
