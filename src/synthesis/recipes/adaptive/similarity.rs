//! The adaptive similarity of neighbourhoods (Chen 2008 §5.2): sizes grow ring by ring until one candidate is
//! left.
//!
//! At every size the squared differences of all samples inside it are summed, pairs more than two standard deviations
//! above the mean of their window left out, and the sum is added to those of the smaller sizes. Only candidates whose
//! total is at most the mean minus the standard deviation of all continue to the next size. The best is always among
//! them: of two candidates, mean − σ is the smaller total itself.

use crate::synthesis::metric::dense::{DenseMetric, DensePattern};

/// Pairs whose difference is so many standard deviations above the mean are outliers.
const OUTLIER: f32 = 2.0;

/// Candidates while sizes grow; working memory of one thread.
#[derive(Clone, Debug, Default)]
pub struct Contest {
    /// Candidates that are left: texel, total so far.
    left: Vec<(u32, f32)>,
    /// The squared differences of their samples, one after the other.
    differences: Vec<Vec<f32>>,
}

impl Contest {
    /// The texel that is left, of candidates that are each listed once; `None` of none. Ties go to the smaller
    /// index. `ring_ends` are those of the template.
    pub fn winner(
        &mut self,
        metric: &DenseMetric,
        pattern: &DensePattern,
        candidates: impl Iterator<Item = u32>,
        ring_ends: &[usize],
    ) -> Option<u32> {
        self.left.clear();
        self.left.extend(candidates.map(|texel| (texel, 0.0)));
        if self.left.len() < 2 {
            return self.left.first().map(|&(texel, _)| texel);
        }
        self.differences
            .resize_with(self.left.len().max(self.differences.len()), Vec::new);
        for (&(texel, _), differences) in self.left.iter().zip(&mut self.differences) {
            metric.differences(pattern, texel, differences);
        }
        // The innermost size is the first ring with its centre.
        for &end in ring_ends.iter().skip(1) {
            let counted = pattern.counts[..end].iter().sum();
            for ((_, total), differences) in self.left.iter_mut().zip(&self.differences) {
                *total += without_outliers(&differences[..end], &pattern.counts[..end], counted);
            }
            self.keep_the_nearest();
            if self.left.len() == 1 {
                break;
            }
        }
        let best = self.left.iter().copied().reduce(nearer);
        best.map(|(texel, _)| texel)
    }

    /// Keeps the candidates at or below mean − σ, and the best.
    fn keep_the_nearest(&mut self) {
        let count = self.left.len() as f32;
        let mean = self.left.iter().map(|(_, total)| total).sum::<f32>() / count;
        let square = |total: &f32| (total - mean) * (total - mean);
        let variance = self
            .left
            .iter()
            .map(|(_, total)| square(total))
            .sum::<f32>()
            / count;
        let best = self.left.iter().copied().reduce(nearer);
        let limit = (mean - variance.sqrt()).max(best.map_or(0.0, |(_, total)| total));
        let mut kept = 0;
        for at in 0..self.left.len() {
            if self.left[at].1 <= limit {
                self.left.swap(kept, at);
                self.differences.swap(kept, at);
                kept += 1;
            }
        }
        self.left.truncate(kept);
    }
}

/// The nearer of two candidates.
fn nearer(a: (u32, f32), b: (u32, f32)) -> (u32, f32) {
    match (b.1, b.0) < (a.1, a.0) {
        true => b,
        false => a,
    }
}

/// The sum of the differences of samples that count, outliers left out.
fn without_outliers(differences: &[f32], counts: &[f32], counted: f32) -> f32 {
    if counted == 0.0 {
        return 0.0;
    }
    let (sum, squares) = differences
        .iter()
        .fold((0.0, 0.0), |(sum, squares), d| (sum + d, squares + d * d));
    let mean = sum / counted;
    let deviation = (squares / counted - mean * mean).max(0.0).sqrt();
    let limit = mean + OUTLIER * deviation;
    let inside = differences.iter().zip(counts);
    inside
        .map(|(d, counts)| if *d <= limit { d * counts } else { 0.0 })
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pairs_far_above_the_others_are_left_out() {
        let mut differences = vec![1.0; 20];
        differences[7] = 100.0;
        let all = vec![1.0; 20];
        assert_eq!(without_outliers(&differences, &all, 20.0), 19.0);
        assert_eq!(without_outliers(&[2.0; 5], &[1.0; 5], 5.0), 10.0);
        // What does not count is 0 and changes no mean.
        let (mut more, mut counts) = (differences.clone(), all);
        more.extend([0.0; 10]);
        counts.extend([0.0; 10]);
        assert_eq!(without_outliers(&more, &counts, 20.0), 19.0);
    }

    #[test]
    fn candidates_go_on_at_or_below_mean_minus_deviation() {
        let mut contest = Contest {
            left: vec![(9, 1.0), (4, 10.0), (5, 10.0), (6, 11.0), (7, 1.0)],
            differences: vec![Vec::new(); 5],
        };
        contest.keep_the_nearest();
        let left: Vec<u32> = contest.left.iter().map(|(texel, _)| *texel).collect();
        assert_eq!(left, [9, 7]);
        // Of two, the smaller.
        contest.left = vec![(3, 2.0), (2, 5.0)];
        contest.keep_the_nearest();
        assert_eq!(contest.left, [(3, 2.0)]);
        contest.left = vec![(3, 2.0), (2, 2.0)];
        contest.keep_the_nearest();
        assert_eq!(contest.left.len(), 2);
    }
}
