//! Texton analysis from beginning to end (Tong 2002 §4 and §5.1).
//!
//! In: a sample. Out: its vocabulary, level by level, and a report. The images are read to choose
//! representatives, for the texels' dot products (or, where these are too many, twice for a
//! sketch), and for the centres.

use ndarray::{Array2, s};
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
use crate::texton::plan::{Plan, Route, Sizes};
use crate::texton::report::{AnalysisReport, LevelReport};
use crate::texton::representatives::{self, SubGridFilters};
use crate::texton::sketch::{self, Fidelity, ForwardSketch};
use crate::texton::texel_gram::texel_gram;
use crate::texton::vector_kmeans;
use crate::texton::vocabulary::{Vocabulary, VocabularyLevel};

/// Planes' numbers read at once: images a panel times their finest texels.
const PANEL_NUMBERS: usize = 1 << 22;

/// What texton analysis finds.
#[derive(Clone, Debug, PartialEq)]
pub struct Analysis {
    /// The textons of every level.
    pub vocabulary: Vocabulary,
    /// How they were found.
    pub report: AnalysisReport,
}

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

/// The textons of a level, and how faithful the route to them was.
struct Found {
    clustering: Clustering,
    fidelity: Option<Fidelity>,
}

/// Finds the 3D textons of a sample.
pub fn analyze(
    sample: &Sample,
    options: &TextonOptions,
    progress: Progress<'_>,
) -> Result<Analysis> {
    options.validate()?;
    let grids = options.grids(sample)?;
    let channels = if options.luminance {
        Channels::Luminance
    } else {
        Channels::Rgb
    };
    let plan = plan(sample, &grids, channels, options)?;
    let mut report = AnalysisReport {
        planned_bytes: plan.bytes,
        ..AnalysisReport::default()
    };
    let bank = leung_malik();
    let levels: Vec<Level> = report.measure("filter bank", || {
        let level = |&grid| {
            let basis = PlaneBasis::new(grid);
            let transfer = basis.transfer(&bank);
            Level { basis, transfer }
        };
        grids.iter().map(level).collect()
    });
    let stack = ImageStack {
        sample,
        channels,
        grids,
    };
    let representatives = report.measure("representative images", || {
        choose_representatives(&stack, &levels[0], &plan, options, progress)
    })?;
    report.note_images(
        sample.image_count(),
        representatives.len(),
        plan.image_vectors,
    );
    let mut reader = Reader::new(&stack, &levels, &representatives, plan.keep_images);
    let found = cluster_levels(&mut reader, &plan, options, &mut report, progress)?;
    let centroids = report.measure("texton centres", || {
        centroids(&mut reader, &found, progress)
    })?;
    let chosen_by_reading = usize::from(representatives.len() < sample.image_count());
    report.times_read = reader.passes + chosen_by_reading as u32;
    report.levels = level_reports(&levels, &plan, &found);
    let vocabulary = Vocabulary {
        levels: assemble(&levels, found, centroids),
        representatives,
        filters: bank.mapv(|tap| tap as f32),
        channels: channels.count() as u32,
        tileable: stack.grids[0].tileable,
        options: recorded(options)?,
        seed: options.seed,
        sample: sample.id().clone(),
        id: ContentId::of_bytes(&[]),
    };
    Ok(Analysis { vocabulary, report })
}

fn plan(
    sample: &Sample,
    grids: &[TexelGrid],
    channels: Channels,
    options: &TextonOptions,
) -> Result<Plan> {
    let points = |side: u32| options.image_grid.min(side) as usize;
    let (rows, cols) = (points(grids[0].height), points(grids[0].width));
    let sizes = Sizes {
        grids,
        textons: (0..grids.len())
            .map(|level| options.textons_at(level))
            .collect(),
        channels: channels.count(),
        images: sample.image_count(),
        representatives: options.image_count(sample)?,
        image_components: channels.count() * rows * cols * FILTERS,
        image_rows: rows,
    };
    Plan::new(&sizes, options.memory)
}

/// Images read at once.
fn panel(stack: &ImageStack<'_>) -> usize {
    (PANEL_NUMBERS / (stack.grids[0].len() * stack.channels.count())).max(1)
}

fn choose_representatives(
    stack: &ImageStack<'_>,
    finest: &Level,
    plan: &Plan,
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
        (panel(stack), plan.image_vectors),
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

/// Reads the representative images, pass after pass.
struct Reader<'a> {
    stack: &'a ImageStack<'a>,
    levels: &'a [Level],
    representatives: &'a [u32],
    /// Coefficients of every panel, once read, where memory is given for them.
    kept: Option<Vec<Vec<Vec<f32>>>>,
    /// How often the images were read.
    passes: u32,
}

impl<'a> Reader<'a> {
    fn new(
        stack: &'a ImageStack<'a>,
        levels: &'a [Level],
        representatives: &'a [u32],
        keep: bool,
    ) -> Self {
        Self {
            stack,
            levels,
            representatives,
            kept: keep.then(Vec::new),
            passes: 0,
        }
    }

    /// Hands every panel's coefficients to `take`: the first plane's number, and for each level
    /// [image · C + channel, wave].
    fn each_panel(
        &mut self,
        stage: &str,
        progress: Progress<'_>,
        mut take: impl FnMut(usize, &[Vec<f32>]),
    ) -> Result<()> {
        let (panel, channels) = (panel(self.stack), self.stack.channels.count());
        let read_before = self.kept.as_ref().is_some_and(|kept| !kept.is_empty());
        self.passes += u32::from(!read_before);
        progress.begin(stage, self.representatives.len() as u64);
        for (at, images) in self.representatives.chunks(panel).enumerate() {
            let first = at * panel * channels;
            match &mut self.kept {
                Some(kept) if read_before => take(first, &kept[at]),
                kept => {
                    let coefficients = read_coefficients(self.stack, self.levels, images)?;
                    take(first, &coefficients);
                    if let Some(kept) = kept {
                        kept.push(coefficients);
                    }
                }
            }
            progress.advance(images.len() as u64)?;
        }
        progress.end();
        Ok(())
    }
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

/// A panel of one level as a matrix [planes, waves].
fn as_planes<'a>(coefficients: &'a [f32], level: &Level) -> ndarray::ArrayView2<'a, f32> {
    let waves = level.grid().len();
    as_rows(coefficients, coefficients.len() / waves, waves)
}

/// The textons of all levels, finest first.
fn cluster_levels(
    reader: &mut Reader<'_>,
    plan: &Plan,
    options: &TextonOptions,
    report: &mut AnalysisReport,
    progress: Progress<'_>,
) -> Result<Vec<Found>> {
    let sketched = plan
        .routes
        .iter()
        .filter(|&&route| route == Route::Sketch)
        .count();
    let levels = reader.levels;
    let [covariances, directions] = report.measure("image dot products", || {
        first_pass(reader, sketched, options, progress)
    })?;
    let sketches = report.measure("sketch", || sketch_pass(reader, directions, progress))?;
    let mut found = Vec::new();
    for (at, (coordinates, exact)) in sketches.into_iter().enumerate() {
        found.push(report.measure(format!("textons of level {at}"), || {
            cluster_sketch(coordinates, &exact, &levels[at], at, options, progress)
        })?);
    }
    for (at, covariance) in (sketched..).zip(covariances) {
        let level = &levels[at];
        let gram = report.measure(format!("texel dot products of level {at}"), || {
            texel_gram(covariance, &level.basis, &level.transfer, progress)
        })?;
        let clustering = report.measure(format!("textons of level {at}"), || {
            best_clustering(&gram, at, options, progress)
        })?;
        found.push(Found {
            clustering,
            fidelity: None,
        });
    }
    for (at, found) in found.iter().enumerate() {
        check_count(&found.clustering, at, options, progress)?;
    }
    Ok(found)
}

/// Ĉ of the levels on the Gram route, and for the `sketched` finer ones the directions.
fn first_pass(
    reader: &mut Reader<'_>,
    sketched: usize,
    options: &TextonOptions,
    progress: Progress<'_>,
) -> Result<[Vec<Array2<f32>>; 2]> {
    let levels = reader.levels;
    let components = reader.representatives.len() * reader.stack.channels.count() * FILTERS;
    let (for_sketch, for_gram) = levels.split_at(sketched);
    let mut sums: Vec<_> = for_gram
        .iter()
        .map(|level| OuterProducts::new(level.grid().len()))
        .collect();
    let mut mixtures = Vec::new();
    for (at, level) in for_sketch.iter().enumerate() {
        let mut random = stream(options.seed, "sketch", at as u32, 0);
        let functions = sketch::random_mixtures(level.grid().len(), &mut random);
        let rows = functions.len() / level.grid().len();
        let backward = BackwardFilters::of_functions(&level.basis, &level.transfer, &functions);
        mixtures.push((backward, Array2::zeros((rows, components))));
    }
    reader.each_panel("image dot products", progress, |first, coefficients| {
        let (for_sketch, for_gram) = coefficients.split_at(sketched);
        for ((sum, numbers), level) in sums.iter_mut().zip(for_gram).zip(&levels[sketched..]) {
            sum.add(as_planes(numbers, level));
        }
        for (((backward, rows), numbers), level) in mixtures.iter_mut().zip(for_sketch).zip(levels)
        {
            let planes = as_planes(numbers, level);
            let range = first * FILTERS..(first + planes.nrows()) * FILTERS;
            backward.centroids_into(planes, rows.slice_mut(s![.., range]));
        }
    })?;
    let covariances = sums.into_iter().map(OuterProducts::finish).collect();
    let directions = mixtures
        .into_iter()
        .map(|(_, rows)| sketch::orthonormal_rows(&rows))
        .collect();
    Ok([covariances, directions])
}

/// Coordinates of every texel of the sketched levels, and the exact dot products of some texels.
fn sketch_pass(
    reader: &mut Reader<'_>,
    directions: Vec<Array2<f32>>,
    progress: Progress<'_>,
) -> Result<Vec<(Array2<f32>, Exact)>> {
    if directions.is_empty() {
        return Ok(Vec::new());
    }
    let levels = reader.levels;
    let mut sketches: Vec<_> = levels
        .iter()
        .zip(directions)
        .map(|(level, directions)| {
            let sketch = ForwardSketch::new(&level.basis, &level.transfer, directions);
            let probes = SubGridFilters::new(&level.basis, &level.transfer, sketch::PROBES);
            let products = OuterProducts::new(probes.points().len());
            (sketch, probes, products)
        })
        .collect();
    reader.each_panel("sketch", progress, |first, coefficients| {
        for (((sketch, probes, products), numbers), level) in
            sketches.iter_mut().zip(coefficients).zip(levels)
        {
            let planes = as_planes(numbers, level);
            sketch.add(planes, first);
            for response in probes.responses(planes).outer_iter() {
                let Some(numbers) = response.to_slice() else {
                    continue;
                };
                products.add(as_rows(numbers, probes.points().len(), FILTERS).reversed_axes());
            }
        }
    })?;
    let finished = sketches.into_iter().map(|(sketch, probes, products)| {
        let exact = Exact {
            texels: probes.points(),
            gram: products.finish(),
        };
        (sketch.finish(), exact)
    });
    Ok(finished.collect())
}

/// Exact dot products of some texels.
struct Exact {
    texels: Vec<usize>,
    gram: Array2<f32>,
}

fn cluster_sketch(
    coordinates: Array2<f32>,
    exact: &Exact,
    level: &Level,
    at: usize,
    options: &TextonOptions,
    progress: Progress<'_>,
) -> Result<Found> {
    let probes = coordinates.select(ndarray::Axis(0), &exact.texels);
    let fidelity = Fidelity::measure(probes.view(), &exact.gram);
    let points = sketch::principal(coordinates);
    let mut clustering = best_of(at, options, progress, |random| {
        let clusters = options.textons_at(at);
        vector_kmeans::cluster(
            points.view(),
            clusters,
            options.max_iterations,
            random,
            progress,
        )
    })?;
    clustering.inertia += fidelity.lost_per_texel * level.grid().len() as f64;
    Ok(Found {
        clustering,
        fidelity: Some(fidelity),
    })
}

fn best_clustering(
    gram: &Array2<f32>,
    at: usize,
    options: &TextonOptions,
    progress: Progress<'_>,
) -> Result<Clustering> {
    best_of(at, options, progress, |random| {
        let clusters = options.textons_at(at);
        gram_kmeans::cluster(
            gram.view(),
            clusters,
            options.max_iterations,
            random,
            progress,
        )
    })
}

/// The best of `restarts` runs of K-means on one level.
fn best_of(
    level: usize,
    options: &TextonOptions,
    progress: Progress<'_>,
    run: impl Fn(&mut crate::random::Stream) -> Result<Clustering>,
) -> Result<Clustering> {
    progress.begin(
        format!("textons of level {level}"),
        u64::from(options.restarts),
    );
    let mut best: Option<Clustering> = None;
    for restart in 0..options.restarts {
        let found = run(&mut stream(
            options.seed,
            "textons",
            level as u32,
            u64::from(restart),
        ))?;
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
    reader: &mut Reader<'_>,
    found: &[Found],
    progress: Progress<'_>,
) -> Result<Vec<Array2<f32>>> {
    let levels = reader.levels;
    let components = reader.representatives.len() * reader.stack.channels.count() * FILTERS;
    let mut targets: Vec<_> = levels
        .iter()
        .zip(found)
        .map(|(level, Found { clustering, .. })| {
            let backward = BackwardFilters::new(
                &level.basis,
                &level.transfer,
                &clustering.labels,
                &clustering.counts,
            );
            (
                backward,
                Array2::zeros((clustering.counts.len(), components)),
            )
        })
        .collect();
    reader.each_panel("texton centres", progress, |first, coefficients| {
        for (((backward, centroids), numbers), level) in
            targets.iter_mut().zip(coefficients).zip(levels)
        {
            let planes = as_planes(numbers, level);
            let range = first * FILTERS..(first + planes.nrows()) * FILTERS;
            backward.centroids_into(planes, centroids.slice_mut(s![.., range]));
        }
    })?;
    Ok(targets
        .into_iter()
        .map(|(_, centroids)| centroids)
        .collect())
}

fn level_reports(levels: &[Level], plan: &Plan, found: &[Found]) -> Vec<LevelReport> {
    levels
        .iter()
        .zip(&plan.routes)
        .zip(found)
        .map(|((level, &route), found)| {
            let sides = [level.grid().width, level.grid().height];
            LevelReport::new(sides, route, &found.clustering, found.fidelity)
        })
        .collect()
}

fn assemble(
    levels: &[Level],
    found: Vec<Found>,
    centroids: Vec<Array2<f32>>,
) -> Vec<VocabularyLevel> {
    levels
        .iter()
        .zip(found)
        .zip(centroids)
        .map(
            |((level, Found { clustering, .. }), centroids)| VocabularyLevel {
                grid: level.grid(),
                labels: clustering
                    .labels
                    .iter()
                    .map(|&label| label as u16)
                    .collect(),
                centroids,
                counts: clustering.counts,
                inertia: clustering.inertia,
                iterations: clustering.iterations,
            },
        )
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
