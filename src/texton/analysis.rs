//! Texton analysis from beginning to end (Tong 2002 §4 and §5.1).
//!
//! In: a sample. Out: its vocabulary, level by level. The images are read at most three times: to
//! choose representatives, for the texels' dot products, and for the centres.

use ndarray::Array2;
use serde_json::Value;

use crate::btf::sample::Sample;
use crate::error::{Error, Result};
use crate::format::id::ContentId;
use crate::grid::TexelGrid;
use crate::progress::Progress;
use crate::random::stream;
use crate::texton::basis::{PlaneBasis, Transfer};
use crate::texton::centroids::BackwardFilters;
use crate::texton::filter_bank::{FILTERS, leung_malik};
use crate::texton::gram_kmeans::{self, Clustering};
use crate::texton::image_stack::{Channels, ImageStack};
use crate::texton::matrix::as_rows;
use crate::texton::options::TextonOptions;
use crate::texton::outer_products::OuterProducts;
use crate::texton::representatives::{self, SubGridFilters};
use crate::texton::texel_gram::texel_gram;
use crate::texton::vocabulary::{Vocabulary, VocabularyLevel};

/// Planes' numbers read at once: images a panel times their finest texels.
const PANEL_NUMBERS: usize = 1 << 22;

/// A level's grid and what filters do on it.
struct Level {
    basis: PlaneBasis,
    transfer: Transfer,
}

impl Level {
    fn grid(&self) -> TexelGrid {
        self.basis.grid
    }
}

/// Finds the 3D textons of a sample.
pub fn analyze(
    sample: &Sample,
    options: &TextonOptions,
    progress: Progress<'_>,
) -> Result<Vocabulary> {
    options.validate()?;
    let grids = options.grids(sample)?;
    let bank = leung_malik();
    let levels: Vec<Level> = grids
        .iter()
        .map(|&grid| {
            let basis = PlaneBasis::new(grid);
            let transfer = basis.transfer(&bank);
            Level { basis, transfer }
        })
        .collect();
    let channels = if options.luminance {
        Channels::Luminance
    } else {
        Channels::Rgb
    };
    let stack = ImageStack {
        sample,
        channels,
        grids,
    };
    let representatives = choose_representatives(&stack, &levels[0], options, progress)?;
    let covariances = covariances(&stack, &levels, &representatives, progress)?;
    let clusterings = cluster_levels(&levels, covariances, options, progress)?;
    let centroids = centroids(&stack, &levels, &representatives, &clusterings, progress)?;
    Ok(Vocabulary {
        levels: assemble(&levels, clusterings, centroids),
        representatives,
        filters: bank.mapv(|tap| tap as f32),
        channels: channels.count() as u32,
        tileable: stack.grids[0].tileable,
        options: recorded(options)?,
        seed: options.seed,
        sample: sample.id().clone(),
        id: ContentId::of_bytes(&[]),
    })
}

/// Images read at once.
fn panel(stack: &ImageStack<'_>) -> usize {
    (PANEL_NUMBERS / (stack.grids[0].len() * stack.channels.count())).max(1)
}

fn choose_representatives(
    stack: &ImageStack<'_>,
    finest: &Level,
    options: &TextonOptions,
    progress: Progress<'_>,
) -> Result<Vec<u32>> {
    let (count, held) = (
        options.image_count(stack.sample)?,
        stack.sample.image_count(),
    );
    if count == held {
        return Ok((0..held as u32).collect());
    }
    let points = options.image_grid as usize;
    let filters = SubGridFilters::new(&finest.basis, &finest.transfer, points);
    let mut random = stream(options.seed, "representative images", 0, 0);
    let chosen = representatives::choose(
        stack,
        &finest.basis,
        &filters,
        count,
        panel(stack),
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

/// Ĉ of every level, over the representative images.
fn covariances(
    stack: &ImageStack<'_>,
    levels: &[Level],
    representatives: &[u32],
    progress: Progress<'_>,
) -> Result<Vec<Array2<f32>>> {
    let mut sums: Vec<_> = levels
        .iter()
        .map(|level| OuterProducts::new(level.grid().len()))
        .collect();
    progress.begin("image dot products", representatives.len() as u64);
    for images in representatives.chunks(panel(stack)) {
        let coefficients = read_coefficients(stack, levels, images)?;
        for ((sum, numbers), level) in sums.iter_mut().zip(&coefficients).zip(levels) {
            let waves = level.grid().len();
            sum.add(as_rows(numbers, numbers.len() / waves, waves));
        }
        progress.advance(images.len() as u64)?;
    }
    progress.end();
    Ok(sums.into_iter().map(OuterProducts::finish).collect())
}

/// Coefficients of images at every level, [level][image · C + channel, wave].
fn read_coefficients(
    stack: &ImageStack<'_>,
    levels: &[Level],
    images: &[u32],
) -> Result<Vec<Vec<f32>>> {
    let mut planes = stack.read(images)?;
    for (planes, level) in planes.iter_mut().zip(levels) {
        level.basis.analyze(planes);
    }
    Ok(planes)
}

fn cluster_levels(
    levels: &[Level],
    covariances: Vec<Array2<f32>>,
    options: &TextonOptions,
    progress: Progress<'_>,
) -> Result<Vec<Clustering>> {
    let mut found = Vec::new();
    for (at, (level, covariance)) in levels.iter().zip(covariances).enumerate() {
        let gram = texel_gram(covariance, &level.basis, &level.transfer, progress)?;
        let clustering = best_clustering(&gram, at, options, progress)?;
        check_count(&clustering, at, options, progress)?;
        found.push(clustering);
    }
    Ok(found)
}

/// The best of `restarts` runs of K-means on one level.
fn best_clustering(
    gram: &Array2<f32>,
    level: usize,
    options: &TextonOptions,
    progress: Progress<'_>,
) -> Result<Clustering> {
    progress.begin(
        format!("textons of level {level}"),
        u64::from(options.restarts),
    );
    let mut best: Option<Clustering> = None;
    for restart in 0..options.restarts {
        let mut random = stream(options.seed, "textons", level as u32, u64::from(restart));
        let found = gram_kmeans::cluster(
            gram.view(),
            options.textons_at(level),
            options.max_iterations,
            &mut random,
            progress,
        )?;
        if best
            .as_ref()
            .is_none_or(|best| found.inertia < best.inertia)
        {
            best = Some(found);
        }
        progress.advance(1)?;
    }
    progress.end();
    best.ok_or_else(|| Error::option("restarts", "0", "at least 1"))
}

/// The finest level must have the textons that were asked for; coarser ones take what there is.
fn check_count(
    found: &Clustering,
    level: usize,
    options: &TextonOptions,
    progress: Progress<'_>,
) -> Result<()> {
    let (asked, distinct) = (options.textons_at(level), found.counts.len());
    if distinct == asked {
        return Ok(());
    }
    if level == 0 {
        return Err(Error::option(
            "textons",
            format!("{asked}, but the sample has only {distinct} distinct texels"),
            format!("at most {distinct}"),
        ));
    }
    progress.warn(format!(
        "level {level} has only {distinct} distinct texels; taking as many textons instead of {asked}"
    ));
    Ok(())
}

/// The textons' appearance vectors, level by level.
fn centroids(
    stack: &ImageStack<'_>,
    levels: &[Level],
    representatives: &[u32],
    clusterings: &[Clustering],
    progress: Progress<'_>,
) -> Result<Vec<Array2<f32>>> {
    let image_components = stack.channels.count() * FILTERS;
    let components = representatives.len() * image_components;
    let mut out: Vec<Array2<f32>> = clusterings
        .iter()
        .map(|found| Array2::zeros((found.counts.len(), components)))
        .collect();
    let backward: Vec<_> = levels
        .iter()
        .zip(clusterings)
        .map(|(level, found)| {
            BackwardFilters::new(&level.basis, &level.transfer, &found.labels, &found.counts)
        })
        .collect();
    progress.begin("texton centres", representatives.len() as u64);
    let mut from = 0;
    for images in representatives.chunks(panel(stack)) {
        let to = from + images.len() * image_components;
        let coefficients = read_coefficients(stack, levels, images)?;
        for (at, numbers) in coefficients.iter().enumerate() {
            let waves = levels[at].grid().len();
            let planes = as_rows(numbers, numbers.len() / waves, waves);
            let target = out[at].slice_mut(ndarray::s![.., from..to]);
            backward[at].centroids_into(planes, target);
        }
        from = to;
        progress.advance(images.len() as u64)?;
    }
    progress.end();
    Ok(out)
}

fn assemble(
    levels: &[Level],
    clusterings: Vec<Clustering>,
    centroids: Vec<Array2<f32>>,
) -> Vec<VocabularyLevel> {
    levels
        .iter()
        .zip(clusterings)
        .zip(centroids)
        .map(|((level, found), centroids)| VocabularyLevel {
            grid: level.grid(),
            labels: found.labels.iter().map(|&label| label as u16).collect(),
            centroids,
            counts: found.counts,
            inertia: found.inertia,
            iterations: found.iterations,
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
