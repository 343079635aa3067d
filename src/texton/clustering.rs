//! The textons of every level: which texels are alike (Tong 2002 §4 and §5.1).
//!
//! In: the representative images, and the route each level takes. Out: one clustering per level. The
//! finer levels may be sketched, for want of memory; all others go through all dot products of
//! their texels. Every pass over the images serves all levels.

use ndarray::{Array2, Axis, s};

use crate::error::{Error, Result};
use crate::progress::Progress;
use crate::random::{Stream, stream};
use crate::texton::filtered_level::FilteredLevel;
use crate::texton::gram_kmeans::{self, Clustering};
use crate::texton::image_batches::ImageBatches;
use crate::texton::image_products::{ImageProducts, LevelProducts};
use crate::texton::options::TextonOptions;
use crate::texton::report::AnalysisReport;
use crate::texton::response_sums::sum_responses;
use crate::texton::sketch::{self, Coordinates, Fidelity, Probes};
use crate::texton::texel_gram::texel_gram;
use crate::texton::texel_sums::TexelSums;
use crate::texton::vector_kmeans;

/// The textons of a level, and how faithful the route to them was.
pub struct Found {
    /// Which texels are alike.
    pub clustering: Clustering,
    /// Of a sketch, what it loses.
    pub fidelity: Option<Fidelity>,
}

/// Finds the textons of all levels, finest first; the `sketched` finest ones through a sketch. The dot products
/// of the images are summed here, unless other runs have `summed` them for all levels.
pub fn find(
    batches: &mut ImageBatches<'_>,
    levels: &[FilteredLevel<'_>],
    sketched: usize,
    summed: Option<ImageProducts>,
    options: &TextonOptions,
    report: &mut AnalysisReport,
    progress: Progress<'_>,
) -> Result<Vec<Found>> {
    let (mut found, products) = match summed {
        Some(products) => (Vec::new(), products),
        None => sketch_and_sum(batches, levels, sketched, options, report, progress)?,
    };
    for products in products.into_levels() {
        let at = found.len();
        found.push(cluster_products(
            products,
            &levels[at],
            at,
            options,
            report,
            progress,
        )?);
    }
    for (at, found) in found.iter().enumerate() {
        tell_if_fewer(&found.clustering, at, options, progress);
    }
    Ok(found)
}

/// Reads the images: the textons of the sketched levels, and the dot products of the images on the others.
fn sketch_and_sum(
    batches: &mut ImageBatches<'_>,
    levels: &[FilteredLevel<'_>],
    sketched: usize,
    options: &TextonOptions,
    report: &mut AnalysisReport,
    progress: Progress<'_>,
) -> Result<(Vec<Found>, ImageProducts)> {
    // Prepare the sums of both routes.
    let (for_sketch, for_gram) = levels.split_at(sketched);
    let grids: Vec<_> = for_gram.iter().map(|level| level.grid).collect();
    let mut products = ImageProducts::new(&grids);
    let components = batches.planes() * levels[0].filters.count();
    let mut sketched_levels: Vec<_> = for_sketch
        .iter()
        .enumerate()
        .map(|(at, level)| SketchedLevel::new(level, at, components, options))
        .collect();
    // Add every batch of images to them.
    report.measure("image dot products", || {
        batches.each("image dot products", progress, |batch| {
            let (for_sketch, for_gram) = batch.planes.split_at(sketched);
            match batch.is_block {
                true => products.add_block(for_gram, progress),
                false => products.add(for_gram, progress),
            }
            if batch.ends_block && !batch.is_block {
                products.end_block();
            }
            let levels = sketched_levels.iter_mut().zip(for_sketch);
            levels.for_each(|(level, planes)| level.add(batch.first, planes));
        })
    })?;
    // Finish the sketches.
    let found = sketch_levels(batches, sketched_levels, options, report, progress)?;
    Ok((found, products))
}

/// Clusters a level whose texels are compared through all their dot products.
fn cluster_products(
    products: LevelProducts,
    level: &FilteredLevel<'_>,
    at: usize,
    options: &TextonOptions,
    report: &mut AnalysisReport,
    progress: Progress<'_>,
) -> Result<Found> {
    let gram = report.measure(format!("texel dot products of level {at}"), || {
        let (basis, covariance) = products.into_total();
        let transfer = basis.transfer(level.bank);
        texel_gram(covariance.finish(progress)?, &basis, &transfer, progress)
    })?;
    let clustering = report.measure(format!("textons of level {at}"), || {
        best_of(at, options, progress, |random| {
            let (clusters, steps) = (options.textons_at(at), options.max_iterations);
            gram_kmeans::cluster(gram.view(), clusters, steps, random, progress)
        })
    })?;
    Ok(Found {
        clustering,
        fidelity: None,
    })
}

/// A level on its way to a sketch: sums of its texels' appearance vectors with random signs.
struct SketchedLevel<'a> {
    level: &'a FilteredLevel<'a>,
    texel_sums: TexelSums,
    /// [sums, components].
    rows: Array2<f32>,
}

impl<'a> SketchedLevel<'a> {
    fn new(
        level: &'a FilteredLevel<'a>,
        at: usize,
        components: usize,
        options: &TextonOptions,
    ) -> Self {
        let mut random = stream(options.seed, "sketch", at as u32, 0);
        let texels = level.grid.len();
        let count = sketch::COORDINATES.min(texels);
        let place = |texel| level.filters.place(texel);
        Self {
            level,
            texel_sums: TexelSums::random(count, texels, place, &mut random),
            rows: Array2::zeros((count, components)),
        }
    }

    fn add(&mut self, first: usize, planes: &[f32]) {
        let range = self.level.components(first, planes);
        let rows = self.rows.slice_mut(s![.., range]);
        sum_responses(&self.level.filters, &self.texel_sums, planes, vec![rows]);
    }
}

/// Textons of the sketched levels.
fn sketch_levels(
    batches: &mut ImageBatches<'_>,
    sketched_levels: Vec<SketchedLevel<'_>>,
    options: &TextonOptions,
    report: &mut AnalysisReport,
    progress: Progress<'_>,
) -> Result<Vec<Found>> {
    if sketched_levels.is_empty() {
        return Ok(Vec::new());
    }
    // Span the subspace of each level by its random sums.
    let mut sketches: Vec<(Coordinates<'_>, Probes)> = sketched_levels
        .into_iter()
        .map(|SketchedLevel { level, rows, .. }| {
            let directions = sketch::orthonormal_rows(&rows)?;
            let probes = Probes::new(level.grid, level.bank);
            Ok((Coordinates::new(&level.filters, directions), probes))
        })
        .collect::<Result<_>>()?;
    // Take the coordinates of all texels in it.
    report.measure("sketch", || {
        batches.each("sketch", progress, |batch| {
            for ((coordinates, probes), planes) in sketches.iter_mut().zip(batch.planes) {
                coordinates.add(planes, batch.first);
                probes.add(planes, progress);
            }
        })
    })?;
    // Cluster them.
    let levels = sketches.into_iter().enumerate();
    let cluster = |(at, (coordinates, probes)): (usize, (Coordinates<'_>, Probes))| {
        report.measure(format!("textons of level {at}"), || {
            cluster_sketch(coordinates.finish(), probes, at, options, progress)
        })
    };
    levels.map(cluster).collect()
}

fn cluster_sketch(
    coordinates: Array2<f32>,
    probes: Probes,
    at: usize,
    options: &TextonOptions,
    progress: Progress<'_>,
) -> Result<Found> {
    let (texels, exact) = probes.finish(progress)?;
    let fidelity = Fidelity::measure(coordinates.select(Axis(0), &texels).view(), &exact)?;
    let points = sketch::principal(coordinates, progress)?;
    let mut clustering = best_of(at, options, progress, |random| {
        let (clusters, steps) = (options.textons_at(at), options.max_iterations);
        vector_kmeans::cluster(points.view(), clusters, steps, random, progress)
    })?;
    clustering.inertia += fidelity.lost_per_texel * points.nrows() as f64;
    Ok(Found {
        clustering,
        fidelity: Some(fidelity),
    })
}

/// The best of `restarts` runs of K-means on one level.
fn best_of(
    level: usize,
    options: &TextonOptions,
    progress: Progress<'_>,
    run: impl Fn(&mut Stream) -> Result<Clustering>,
) -> Result<Clustering> {
    let restarts = options.restarts;
    progress.begin(format!("textons of level {level}"), u64::from(restarts));
    let mut best: Option<Clustering> = None;
    for restart in 0..u64::from(restarts) {
        let found = run(&mut stream(options.seed, "textons", level as u32, restart))?;
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

/// Says where a level has fewer distinct texels than textons were asked for: it has as many textons. Coarser levels
/// that have one for each of their few texels are not worth a word.
fn tell_if_fewer(
    found: &Clustering,
    level: usize,
    options: &TextonOptions,
    progress: Progress<'_>,
) {
    let (asked, distinct) = (options.textons_at(level), found.counts.len());
    let every_texel = level > 0 && distinct == found.labels.len();
    if distinct == asked || every_texel {
        return;
    }
    let what = match (level, distinct) {
        (0, 1) => "all texels of the sample are alike; taking one texton".into(),
        (0, _) => format!("the sample has only {distinct} distinct texels; taking as many textons"),
        (_, 1) => format!("all texels of level {level} are alike; taking one texton"),
        _ => format!("level {level} has only {distinct} distinct texels; taking as many textons"),
    };
    progress.warn(format!("{what} instead of {asked}"));
}
