//! A few weighted sums over the texels of a plane: averages of clusters, or sums with random signs.
//!
//! In: labels, or a random stream. Out: sums of complex responses, member by member in a fixed
//! order. Sparse: a texel is in one average, or in a few random sums.

use rand::Rng;
use rustfft::num_complex::Complex32;

use crate::random::Stream;

/// Random sums that each texel enters (Martinsson and Tropp 2020 §9.2: eight signs a column do).
const ENTERED: usize = 8;

/// Weighted sums over places in an image.
pub struct TexelSums {
    /// Every sum and how many members it has, the shortest first: the processor foresees the end
    /// of a loop that is as long as the one before.
    lengths: Vec<(usize, usize)>,
    /// Place and weight of every member, sum after sum in that order.
    members: Vec<(u32, f32)>,
}

impl TexelSums {
    /// The averages of the texels of each label; `place` says where a texel stands.
    pub fn averages(labels: &[u32], counts: &[u32], place: impl Fn(usize) -> usize) -> Self {
        let weight = |label: u32| (counts[label as usize] as f32).recip();
        let numbered = labels.iter().enumerate();
        let entries = numbered.map(|(texel, &label)| (label, place(texel), weight(label)));
        Self::of_entries(counts.len(), entries.collect())
    }

    /// Sums with random signs; every texel enters a few of them.
    pub fn random(
        count: usize,
        texels: usize,
        place: impl Fn(usize) -> usize,
        random: &mut Stream,
    ) -> Self {
        let mut entries = Vec::with_capacity(texels * ENTERED);
        for texel in 0..texels {
            for _ in 0..ENTERED {
                let sign = if random.r#gen() { 1.0 } else { -1.0 };
                entries.push((random.gen_range(0..count as u32), place(texel), sign));
            }
        }
        Self::of_entries(count, entries)
    }

    fn of_entries(count: usize, mut entries: Vec<(u32, usize, f32)>) -> Self {
        let mut lengths: Vec<(usize, usize)> = (0..count).map(|sum| (sum, 0)).collect();
        for &(sum, ..) in &entries {
            lengths[sum as usize].1 += 1;
        }
        let length_of: Vec<usize> = lengths.iter().map(|&(_, length)| length).collect();
        lengths.sort_by_key(|&(sum, length)| (length, sum));
        entries.sort_by_key(|&(sum, place, _)| (length_of[sum as usize], sum, place));
        let members = entries.iter();
        Self {
            lengths,
            members: members
                .map(|&(_, place, weight)| (place as u32, weight))
                .collect(),
        }
    }

    /// How many sums there are.
    pub fn count(&self) -> usize {
        self.lengths.len()
    }

    /// The sums of an image's numbers.
    pub fn apply(&self, image: &[Complex32], sums: &mut [Complex32]) {
        let mut rest = self.members.as_slice();
        for &(sum, length) in &self.lengths {
            let (members, others) = rest.split_at(length);
            let weighted = members.iter();
            sums[sum] = weighted
                .map(|&(place, weight)| image[place as usize] * weight)
                .sum();
            rest = others;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::stream;

    #[test]
    fn averages_are_means_of_their_members() {
        let image = [1.0, 9.0, 2.0, 3.0].map(|v| Complex32::new(v, -v));
        let averages = TexelSums::averages(&[1, 0, 1], &[1, 2], |texel| texel + 1);
        let mut sums = [Complex32::default(); 2];
        averages.apply(&image, &mut sums);
        assert_eq!(sums, [2.0, 6.0].map(|v| Complex32::new(v, -v)));
    }

    #[test]
    fn random_sums_take_every_texel_a_few_times() {
        let sums = TexelSums::random(5, 30, |texel| 2 * texel, &mut stream(1, "m", 0, 0));
        let mut entered = [0; 60];
        for &(place, weight) in &sums.members {
            assert_eq!(weight.abs(), 1.0);
            entered[place as usize] += 1;
        }
        let expected: [usize; 60] = std::array::from_fn(|place| ENTERED * (1 - place % 2));
        assert_eq!((entered, sums.count()), (expected, 5));
    }
}
