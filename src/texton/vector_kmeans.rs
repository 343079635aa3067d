//! K-means on vectors, for when all pairs of dot products are too many.
//!
//! In: points [points, components]. Out: the same as of
//! [`gram_kmeans`](crate::texton::gram_kmeans). Seeds come by greedy k-means++ over a subsample,
//! are moved there by `linfa-clustering` in the leading components (Bradley and Fayyad 1998: an
//! initial solution refined on a sample), and then Lloyd's steps run on all points until none
//! moves. Blocks are fixed and summed in order in `f64`: the same bits at any thread count.

use linfa::DatasetBase;
use linfa::traits::Fit;
use linfa_clustering::{KMeans, KMeansInit};
use ndarray::{Array1, Array2, ArrayView1, ArrayView2, Axis, s};
use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::matrix::product_of;
use crate::progress::Progress;
use crate::random::Stream;
use crate::texton::gram_kmeans::{self, Clustering};
use crate::texton::scatter_matrix::ScatterMatrix;

/// Points that one task compares with all centres.
const BLOCK: usize = 1024;
/// Points of the subsample for each cluster.
const SAMPLED_PER_CLUSTER: usize = 20;
/// Leading components in which the subsample is clustered.
const LEADING: usize = 64;
/// Steps on the subsample.
const SAMPLE_STEPS: u64 = 20;

/// Clusters points into at most `clusters` clusters. Stops after `max_iterations` steps even when
/// points still move. The leading components should carry most of the points' variance.
pub fn cluster(
    points: ArrayView2<'_, f32>,
    clusters: usize,
    max_iterations: u32,
    random: &mut Stream,
    progress: Progress<'_>,
) -> Result<Clustering> {
    let mut centres = seeds(points, clusters, random, progress)?;
    let mut state = State::nearest(points, &centres);
    let (mut iterations, mut refilled) = (0, 0);
    while iterations < max_iterations {
        refilled += state.refill(centres.nrows());
        centres = state.means(points, centres.nrows());
        let next = State::nearest(points, &centres).or_stay(&state, points, &centres);
        iterations += 1;
        let settled = next.labels == state.labels;
        state = next;
        if settled {
            break;
        }
        progress.check()?;
    }
    refilled += state.refill(centres.nrows());
    Ok(state.finish(points, centres.nrows(), iterations, refilled))
}

/// Centres to begin with, from a subsample.
fn seeds(
    points: ArrayView2<'_, f32>,
    clusters: usize,
    random: &mut Stream,
    progress: Progress<'_>,
) -> Result<Array2<f32>> {
    let wanted = (clusters * SAMPLED_PER_CLUSTER).min(points.nrows());
    let chosen: Vec<usize> = (0..wanted).map(|i| i * points.nrows() / wanted).collect();
    let sample = points.select(Axis(0), &chosen);
    let mut products = ScatterMatrix::new(sample.nrows());
    products.add(sample.t(), progress);
    let found = gram_kmeans::cluster(
        products.finish(progress)?.view(),
        clusters,
        0,
        random,
        progress,
    )?;
    let start = sample.select(Axis(0), &as_indices(&found.nearest));
    refined(&sample, start, random)
}

fn as_indices(points: &[u32]) -> Vec<usize> {
    points.iter().map(|&point| point as usize).collect()
}

/// Moves centres by clustering the sample in its leading components; each becomes the mean of the
/// sample's points that are nearest to it there.
fn refined(sample: &Array2<f32>, start: Array2<f32>, random: &mut Stream) -> Result<Array2<f32>> {
    let leading = s![.., ..LEADING.min(sample.ncols())];
    let inner = sample.slice(leading).to_owned();
    let model = KMeans::params_with_rng(start.nrows(), random.clone())
        .init_method(KMeansInit::Precomputed(start.slice(leading).to_owned()))
        .n_runs(1)
        .max_n_iterations(SAMPLE_STEPS)
        .tolerance(1e-3)
        .fit(&DatasetBase::from(inner.view()))
        .map_err(|error| Error::data("clustering of a subsample", error.to_string()))?;
    let state = State::nearest(inner.view(), model.centroids());
    let mut centres = state.means(sample.view(), start.nrows());
    for (cluster, &count) in state.counts(start.nrows()).iter().enumerate() {
        if count == 0 {
            centres.row_mut(cluster).assign(&start.row(cluster));
        }
    }
    Ok(centres)
}

/// Labels and squared distances.
struct State {
    labels: Vec<u32>,
    distances: Vec<f64>,
}

impl State {
    /// Every point joins its nearest centre.
    fn nearest(points: ArrayView2<'_, f32>, centres: &Array2<f32>) -> Self {
        let norms: Vec<f32> = centres.outer_iter().map(|c| c.dot(&c)).collect();
        let blocks: Vec<Vec<(u32, f64)>> = points
            .axis_chunks_iter(Axis(0), BLOCK)
            .into_par_iter()
            .map(|block| {
                let dots = product_of(block, centres.t());
                let nearest = |(point, dots): (ArrayView1<'_, f32>, ArrayView1<'_, f32>)| {
                    let cluster = least(&dots, &norms);
                    (
                        cluster,
                        squared_distance(point, centres.row(cluster as usize)),
                    )
                };
                block
                    .outer_iter()
                    .zip(dots.outer_iter())
                    .map(nearest)
                    .collect()
            })
            .collect();
        let (labels, distances) = blocks.into_iter().flatten().unzip();
        Self { labels, distances }
    }

    /// Keeps the earlier label where the new one is no nearer beyond rounding.
    fn or_stay(
        mut self,
        earlier: &Self,
        points: ArrayView2<'_, f32>,
        centres: &Array2<f32>,
    ) -> Self {
        for (point, &label) in earlier.labels.iter().enumerate() {
            if self.labels[point] == label {
                continue;
            }
            let stay = squared_distance(points.row(point), centres.row(label as usize));
            if stay <= self.distances[point] {
                (self.labels[point], self.distances[point]) = (label, stay);
            }
        }
        self
    }

    fn counts(&self, clusters: usize) -> Vec<u32> {
        let mut counts = vec![0; clusters];
        self.labels
            .iter()
            .for_each(|&label| counts[label as usize] += 1);
        counts
    }

    /// Gives each empty cluster the farthest point that is not the last of its own; how many.
    fn refill(&mut self, clusters: usize) -> u32 {
        let mut counts = self.counts(clusters);
        let empty: Vec<usize> = (0..clusters)
            .filter(|&cluster| counts[cluster] == 0)
            .collect();
        if empty.is_empty() {
            return 0;
        }
        let mut farthest: Vec<usize> = (0..self.labels.len()).collect();
        farthest.sort_by(|&a, &b| {
            self.distances[b]
                .total_cmp(&self.distances[a])
                .then(a.cmp(&b))
        });
        let mut candidates = farthest.into_iter();
        let mut filled = 0;
        for cluster in empty {
            let movable = |&point: &usize| counts[self.labels[point] as usize] > 1;
            let Some(point) = candidates.find(movable) else {
                break;
            };
            counts[self.labels[point] as usize] -= 1;
            counts[cluster] = 1;
            (self.labels[point], self.distances[point]) = (cluster as u32, 0.0);
            filled += 1;
        }
        filled
    }

    /// Means of the members; zero for an empty cluster.
    fn means(&self, points: ArrayView2<'_, f32>, clusters: usize) -> Array2<f32> {
        let mut members = vec![Vec::new(); clusters];
        for (point, &label) in self.labels.iter().enumerate() {
            members[label as usize].push(point);
        }
        let mut means = Array2::zeros((clusters, points.ncols()));
        means
            .axis_iter_mut(Axis(0))
            .into_par_iter()
            .zip(members)
            .for_each(|(mut mean, members)| {
                let mut sum = Array1::<f64>::zeros(points.ncols());
                for &point in &members {
                    sum.zip_mut_with(&points.row(point), |sum, &v| *sum += f64::from(v));
                }
                let count = members.len().max(1) as f64;
                mean.zip_mut_with(&sum, |mean, sum| *mean = (sum / count) as f32);
            });
        means
    }

    fn finish(
        mut self,
        points: ArrayView2<'_, f32>,
        clusters: usize,
        iterations: u32,
        refilled: u32,
    ) -> Clustering {
        let means = self.means(points, clusters);
        let mut nearest = vec![(f64::INFINITY, 0); clusters];
        for (point, &label) in self.labels.iter().enumerate() {
            let distance = squared_distance(points.row(point), means.row(label as usize));
            self.distances[point] = distance;
            let best = &mut nearest[label as usize];
            if distance < best.0 {
                *best = (distance, point as u32);
            }
        }
        Clustering {
            counts: self.counts(clusters),
            inertia: self.distances.iter().sum(),
            nearest: nearest.into_iter().map(|(_, point)| point).collect(),
            duplicates: 0,
            labels: self.labels,
            iterations,
            refilled,
        }
    }
}

/// The centre with the least |c|² − 2 p·c; of equals the first.
fn least(dots: &ArrayView1<'_, f32>, norms: &[f32]) -> u32 {
    let mut best = (f32::INFINITY, 0);
    for (cluster, (dot, norm)) in dots.iter().zip(norms).enumerate() {
        let value = norm - 2.0 * dot;
        if value < best.0 {
            best = (value, cluster as u32);
        }
    }
    best.1
}

fn squared_distance(a: ArrayView1<'_, f32>, b: ArrayView1<'_, f32>) -> f64 {
    let pairs = a.iter().zip(b);
    pairs.map(|(a, b)| f64::from(a - b)).map(|d| d * d).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::stream;
    use rand::Rng;

    fn points(count: usize) -> Array2<f32> {
        let mut random = stream(5, "points", 0, 0);
        Array2::from_shape_fn((count, 6), |(_, d)| {
            random.gen_range(-1.0..1.0) / (d + 1) as f32
        })
    }

    fn run(points: &Array2<f32>, clusters: usize) -> Clustering {
        let mut random = stream(1, "kmeans", 0, 0);
        cluster(
            points.view(),
            clusters,
            1000,
            &mut random,
            Progress::silent(),
        )
        .unwrap()
    }

    #[test]
    fn labels_are_the_nearest_means() {
        let points = points(2500);
        let found = run(&points, 30);
        let state = State {
            labels: found.labels.clone(),
            distances: vec![0.0; 2500],
        };
        let means = state.means(points.view(), 30);
        let mut inertia = 0.0;
        for (point, &label) in points.outer_iter().zip(&found.labels) {
            let all: Vec<f64> = means
                .outer_iter()
                .map(|m| squared_distance(point, m))
                .collect();
            let least = all.iter().copied().fold(f64::INFINITY, f64::min);
            assert!(all[label as usize] <= least + 1e-6);
            inertia += all[label as usize];
        }
        assert!((found.inertia / inertia - 1.0).abs() < 1e-6);
        assert!(found.counts.iter().all(|&count| count > 0));
    }

    #[test]
    fn it_is_as_good_as_the_gram_route() {
        let points = points(1500);
        let mut random = stream(1, "kmeans", 0, 0);
        let gram = points.dot(&points.t());
        let other =
            gram_kmeans::cluster(gram.view(), 25, 1000, &mut random, Progress::silent()).unwrap();
        let ratio = run(&points, 25).inertia / other.inertia;
        assert!((0.95..1.05).contains(&ratio), "{ratio}");
    }

    #[test]
    fn threads_do_not_change_a_bit() {
        let points = points(3000);
        let with = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            pool.unwrap().install(|| run(&points, 40))
        };
        assert_eq!(with(1), with(8));
    }
}
