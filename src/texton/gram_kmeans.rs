//! K-means where only the points' dot products are known.
//!
//! In: K [points, points]. Out: labels, the clusters' sizes and the sum of squared distances of
//! every point to the mean of its cluster. A distance to a mean needs sums of K's entries alone:
//! |v_i − μ_j|² = K_ii − 2 S_ij / n_j + T_j / n_j², S_ij = Σ_{m∈j} K_im, T_j = Σ_{m∈j} S_mj.
//!
//! Seeds come by greedy k-means++ (Arthur and Vassilvitskii 2007, the best of a few draws), then
//! Lloyd's steps run until no point moves, so that centres are the means of their members and
//! every member is nearest to its own. Sums are `f64` and over fixed ranges: the same bits at any
//! thread count.

use ndarray::ArrayView2;
use rand::Rng;
use rayon::prelude::*;

use crate::error::Result;
use crate::progress::Progress;
use crate::random::Stream;

/// Points closer than this share of their squared norms are one point: it is `f32`'s rounding.
const SAME_POINT: f64 = 1e-6;
/// A point moves only for a gain beyond this share of its squared norm.
const LEAST_GAIN: f64 = 1e-12;
/// Beyond this share of moved points the sums are made again instead of corrected.
const RECOMPUTE_SHARE: usize = 8;

/// What K-means found.
#[derive(Clone, Debug, PartialEq)]
pub struct Clustering {
    /// Cluster of every point.
    pub labels: Vec<u32>,
    /// Points of every cluster, none 0.
    pub counts: Vec<u32>,
    /// The member nearest to each cluster's mean.
    pub nearest: Vec<u32>,
    /// Sum of squared distances of all points to their cluster's mean.
    pub inertia: f64,
    /// Lloyd steps taken.
    pub iterations: u32,
    /// Empty clusters that were given the farthest point.
    pub refilled: u32,
    /// Points that are the same as an earlier one of their cluster, to `f32`'s rounding.
    pub duplicates: u32,
}

/// Clusters the points of `gram` into `clusters` clusters, or into as many as there are distinct
/// points, if fewer. Stops after `max_iterations` steps even when points still move.
pub fn cluster(
    gram: ArrayView2<'_, f32>,
    clusters: usize,
    max_iterations: u32,
    random: &mut Stream,
    progress: Progress<'_>,
) -> Result<Clustering> {
    let points = Points::new(gram);
    let seeds = points.seeds(clusters, random, progress)?;
    let mut state = State::new(&points, &seeds);
    progress.check()?;
    let mut iterations = 0;
    while iterations < max_iterations && state.step(&points) {
        iterations += 1;
        progress.check()?;
    }
    Ok(state.finish(&points, iterations))
}

/// The points by their dot products.
struct Points<'a> {
    gram: ArrayView2<'a, f32>,
    /// Squared norms.
    norms: Vec<f64>,
}

impl<'a> Points<'a> {
    fn new(gram: ArrayView2<'a, f32>) -> Self {
        let norms = gram.diag().iter().map(|&v| f64::from(v).max(0.0)).collect();
        Self { gram, norms }
    }

    fn len(&self) -> usize {
        self.norms.len()
    }

    fn row(&self, point: usize) -> &[f32] {
        match self.gram.row(point).to_slice() {
            Some(row) => row,
            None => unreachable!("dot products are stored in rows"),
        }
    }

    /// Squared distance of two points, 0 where they are one to `f32`'s rounding.
    #[inline]
    fn distance(&self, row: &[f32], from: usize, to: usize) -> f64 {
        let norms = self.norms[from] + self.norms[to];
        let distance = norms - 2.0 * f64::from(row[to]);
        if distance > SAME_POINT * norms {
            distance
        } else {
            0.0
        }
    }

    /// Greedy k-means++: each seed the best of 2 + ln k draws by squared distance.
    fn seeds(
        &self,
        clusters: usize,
        random: &mut Stream,
        progress: Progress<'_>,
    ) -> Result<Vec<usize>> {
        let draws = 2 + (clusters as f64).ln() as usize;
        let mut seeds = vec![random.gen_range(0..self.len())];
        let mut closest = self.closest(&vec![f64::INFINITY; self.len()], seeds[0]);
        while seeds.len() < clusters {
            progress.check()?;
            let candidates = draw(&closest, draws, random);
            let tried: Vec<Vec<f64>> = candidates
                .par_iter()
                .map(|&candidate| self.closest(&closest, candidate))
                .collect();
            let potentials = tried.iter().map(|closest| closest.iter().sum::<f64>());
            let best = potentials.enumerate().min_by(|a, b| a.1.total_cmp(&b.1));
            let Some((best, _)) = best else { break };
            seeds.push(candidates[best]);
            closest.clone_from(&tried[best]);
        }
        Ok(seeds)
    }

    /// Squared distances to the nearest seed, with one more seed.
    fn closest(&self, closest: &[f64], seed: usize) -> Vec<f64> {
        let row = self.row(seed);
        let nearer = |(to, &closest): (usize, &f64)| self.distance(row, seed, to).min(closest);
        closest.iter().enumerate().map(nearer).collect()
    }
}

/// Draws points by weight; none when all weights are 0.
fn draw(weights: &[f64], count: usize, random: &mut Stream) -> Vec<usize> {
    let mut sum = 0.0;
    let cumulative: Vec<f64> = weights
        .iter()
        .map(|weight| {
            sum += weight;
            sum
        })
        .collect();
    if sum <= 0.0 {
        return Vec::new();
    }
    (0..count)
        .map(|_| {
            let at = random.r#gen::<f64>() * sum;
            cumulative.partition_point(|&c| c <= at)
        })
        .filter(|&point| point < weights.len())
        .collect()
}

/// Labels and the sums of dot products they imply.
struct State {
    clusters: usize,
    labels: Vec<u32>,
    counts: Vec<u32>,
    /// S_ij, [points, clusters].
    sums: Vec<f64>,
    refilled: u32,
}

/// A point that changes its cluster.
struct Move {
    point: usize,
    from: u32,
    to: u32,
}

impl State {
    /// Every point joins its nearest seed.
    fn new(points: &Points<'_>, seeds: &[usize]) -> Self {
        let nearest_seed = |point: usize| {
            let row = points.row(point);
            let mut best = (f64::INFINITY, 0);
            for (cluster, &seed) in seeds.iter().enumerate() {
                let distance = points.distance(row, point, seed);
                if distance < best.0 {
                    best = (distance, cluster as u32);
                }
            }
            best.1
        };
        let labels: Vec<u32> = (0..points.len())
            .into_par_iter()
            .map(nearest_seed)
            .collect();
        let mut state = Self {
            clusters: seeds.len(),
            labels,
            counts: Vec::new(),
            sums: vec![0.0; points.len() * seeds.len()],
            refilled: 0,
        };
        state.count();
        state.sum_anew(points);
        state
    }

    fn count(&mut self) {
        self.counts = vec![0; self.clusters];
        for &label in &self.labels {
            self.counts[label as usize] += 1;
        }
    }

    fn sum_anew(&mut self, points: &Points<'_>) {
        let labels = &self.labels;
        self.sums
            .par_chunks_mut(self.clusters)
            .enumerate()
            .for_each(|(point, sums)| {
                sums.fill(0.0);
                for (&label, &dot) in labels.iter().zip(points.row(point)) {
                    sums[label as usize] += f64::from(dot);
                }
            });
    }

    fn correct_sums(&mut self, points: &Points<'_>, moves: &[Move]) {
        self.sums
            .par_chunks_mut(self.clusters)
            .enumerate()
            .for_each(|(point, sums)| {
                let row = points.row(point);
                for step in moves {
                    let dot = f64::from(row[step.point]);
                    sums[step.from as usize] -= dot;
                    sums[step.to as usize] += dot;
                }
            });
    }

    /// T_j / n_j² and 2 / n_j of every cluster; an empty one is out of reach.
    fn centres(&self) -> Vec<(f64, f64)> {
        let mut own = vec![0.0; self.clusters];
        for (point, &label) in self.labels.iter().enumerate() {
            own[label as usize] += self.sums[point * self.clusters + label as usize];
        }
        own.iter()
            .zip(&self.counts)
            .map(|(&own, &count)| match f64::from(count) {
                0.0 => (f64::INFINITY, 0.0),
                n => (own / (n * n), 2.0 / n),
            })
            .collect()
    }

    /// One Lloyd step; whether any point moved.
    fn step(&mut self, points: &Points<'_>) -> bool {
        let centres = self.centres();
        let mut moves: Vec<Move> = (0..points.len())
            .into_par_iter()
            .filter_map(|point| {
                let from = self.labels[point];
                let to = self.nearest_cluster(points, &centres, point);
                (to != from).then_some(Move { point, from, to })
            })
            .collect();
        self.apply(&moves);
        moves.extend(self.refill(points, &centres));
        if moves.len() * RECOMPUTE_SHARE > points.len() {
            self.sum_anew(points);
        } else {
            self.correct_sums(points, &moves);
        }
        !moves.is_empty()
    }

    fn apply(&mut self, moves: &[Move]) {
        for step in moves {
            self.labels[step.point] = step.to;
            self.counts[step.from as usize] -= 1;
            self.counts[step.to as usize] += 1;
        }
    }

    /// The nearest centre; the point's own unless another is nearer beyond rounding.
    fn nearest_cluster(&self, points: &Points<'_>, centres: &[(f64, f64)], point: usize) -> u32 {
        let sums = &self.sums[point * self.clusters..][..self.clusters];
        let own = self.labels[point];
        let (offset, factor) = centres[own as usize];
        let stay = offset - factor * sums[own as usize] - LEAST_GAIN * points.norms[point];
        let mut best = (stay, own);
        for (cluster, (&(offset, factor), sum)) in centres.iter().zip(sums).enumerate() {
            let value = offset - factor * sum;
            if value < best.0 {
                best = (value, cluster as u32);
            }
        }
        best.1
    }

    /// Gives each empty cluster the point farthest from its centre, not the last of its cluster.
    fn refill(&mut self, points: &Points<'_>, centres: &[(f64, f64)]) -> Vec<Move> {
        let empty: Vec<u32> = (0..self.clusters as u32)
            .filter(|&cluster| self.counts[cluster as usize] == 0)
            .collect();
        if empty.is_empty() {
            return Vec::new();
        }
        let mut farthest: Vec<(f64, usize)> = (0..points.len())
            .map(|point| (self.distance(points, centres, point), point))
            .collect();
        farthest.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        let mut moves = Vec::new();
        let mut candidates = farthest.into_iter().map(|(_, point)| point);
        for to in empty {
            let movable = |&point: &usize| self.counts[self.labels[point] as usize] > 1;
            let Some(point) = candidates.find(movable) else {
                break;
            };
            let step = Move {
                point,
                from: self.labels[point],
                to,
            };
            self.apply(std::slice::from_ref(&step));
            self.refilled += 1;
            moves.push(step);
        }
        moves
    }

    /// Squared distance of a point to its cluster's centre.
    fn distance(&self, points: &Points<'_>, centres: &[(f64, f64)], point: usize) -> f64 {
        let own = self.labels[point] as usize;
        let (offset, factor) = centres[own];
        if !offset.is_finite() {
            return 0.0;
        }
        let distance =
            points.norms[point] + offset - factor * self.sums[point * self.clusters + own];
        distance.max(0.0)
    }

    fn finish(self, points: &Points<'_>, iterations: u32) -> Clustering {
        let centres = self.centres();
        let mut nearest = vec![(f64::INFINITY, 0); self.clusters];
        let mut inertia = 0.0;
        for point in 0..points.len() {
            let distance = self.distance(points, &centres, point);
            inertia += distance;
            let best = &mut nearest[self.labels[point] as usize];
            if distance < best.0 {
                *best = (distance, point as u32);
            }
        }
        let duplicates = self.duplicates(points);
        Clustering {
            labels: self.labels,
            counts: self.counts,
            nearest: nearest.into_iter().map(|(_, point)| point).collect(),
            inertia,
            iterations,
            refilled: self.refilled,
            duplicates,
        }
    }

    /// Points that are the same as an earlier member of their cluster.
    fn duplicates(&self, points: &Points<'_>) -> u32 {
        let mut members = vec![Vec::new(); self.clusters];
        for (point, &label) in self.labels.iter().enumerate() {
            members[label as usize].push(point);
        }
        let repeats = |members: &Vec<usize>| {
            let repeated = |at: &usize| {
                let point = members[*at];
                let row = points.row(point);
                members[..*at]
                    .iter()
                    .any(|&earlier| points.distance(row, point, earlier) == 0.0)
            };
            (0..members.len()).filter(repeated).count() as u32
        };
        members.par_iter().map(repeats).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::stream;
    use ndarray::Array2;

    fn points(count: usize, dimensions: usize) -> Array2<f32> {
        let mut random = stream(5, "points", 0, 0);
        Array2::from_shape_fn((count, dimensions), |_| random.gen_range(-1.0..1.0))
    }

    fn run(gram: &Array2<f32>, clusters: usize, seed: u64) -> Clustering {
        let mut random = stream(seed, "kmeans++", 0, 0);
        cluster(gram.view(), clusters, 1000, &mut random, Progress::silent()).unwrap()
    }

    /// Means, squared distances to all means, by the definition.
    fn distances(points: &Array2<f32>, found: &Clustering) -> Array2<f64> {
        let mut means = Array2::<f64>::zeros((found.counts.len(), points.ncols()));
        for (point, &label) in points.outer_iter().zip(&found.labels) {
            let mut mean = means.row_mut(label as usize);
            mean += &(point.mapv(f64::from) / f64::from(found.counts[label as usize]));
        }
        Array2::from_shape_fn((points.nrows(), means.nrows()), |(i, j)| {
            let difference = points.row(i).mapv(f64::from) - means.row(j);
            difference.dot(&difference)
        })
    }

    #[test]
    fn labels_are_the_nearest_means_and_inertia_is_their_sum() {
        let points = points(300, 7);
        let found = run(&points.dot(&points.t()), 20, 1);
        let distances = distances(&points, &found);
        let mut inertia = 0.0;
        for (row, &label) in distances.outer_iter().zip(&found.labels) {
            let least = row.iter().copied().fold(f64::INFINITY, f64::min);
            assert!(row[label as usize] <= least + 1e-6);
            inertia += row[label as usize];
        }
        assert!((found.inertia / inertia - 1.0).abs() < 1e-6);
        assert_eq!(found.counts.iter().sum::<u32>(), 300);
        for (cluster, &member) in found.nearest.iter().enumerate() {
            assert_eq!(found.labels[member as usize], cluster as u32);
        }
    }

    #[test]
    fn separate_clusters_are_found() {
        let centres = points(6, 4) * 100.0;
        let points = Array2::from_shape_fn((60, 4), |(i, d)| {
            centres[[i % 6, d]] + (i / 6) as f32 * 0.01
        });
        let found = run(&points.dot(&points.t()), 6, 3);
        for i in 0..60 {
            assert_eq!(found.labels[i], found.labels[i % 6]);
        }
        assert_eq!(found.counts, [10; 6]);
    }

    #[test]
    fn fewer_distinct_points_give_fewer_clusters() {
        let few = points(5, 3);
        let points = Array2::from_shape_fn((40, 3), |(i, d)| few[[i % 5, d]]);
        let found = run(&points.dot(&points.t()), 12, 1);
        assert_eq!(found.counts.len(), 5);
        assert!(found.inertia < 1e-4);
        let zeros = run(&Array2::zeros((9, 9)), 3, 1);
        assert_eq!((zeros.counts, zeros.inertia), (vec![9], 0.0));
    }

    #[test]
    fn empty_clusters_take_the_farthest_point() {
        let points = points(30, 3);
        let gram = points.dot(&points.t());
        let points = Points::new(gram.view());
        let mut state = State::new(&points, &[0, 1]);
        state.clusters = 3;
        state.sums = vec![0.0; 90];
        state.count();
        state.sum_anew(&points);
        let centres = state.centres();
        let farthest = (0..30).max_by(|&a, &b| {
            let at = |p| state.distance(&points, &centres, p);
            at(a).total_cmp(&at(b))
        });
        let moves = state.refill(&points, &centres);
        assert_eq!(moves.len(), 1);
        assert_eq!((Some(moves[0].point), moves[0].to), (farthest, 2));
        assert_eq!(state.counts[2], 1);
    }

    #[test]
    fn threads_do_not_change_a_bit() {
        let points = points(500, 9);
        let gram = points.dot(&points.t());
        let with = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            pool.unwrap().install(|| run(&gram, 30, 7))
        };
        let single = with(1);
        assert_eq!(single, with(2));
        assert_eq!(single, with(8));
    }
}
