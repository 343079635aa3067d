//! Weighted sums of texels' appearance vectors: texton centres, the means of their members, and
//! sums with random signs for a sketch.
//!
//! In: planes, and which texels to sum. Out: rows of appearance vectors [sums, planes · 48],
//! component plane · 48 + filter. Planes are filtered forwards, two at a time; a response is summed
//! where it was made and never stored.

use ndarray::{ArrayViewMut2, Axis};
use rayon::prelude::*;
use rustfft::num_complex::Complex32;

use crate::texton::fft_filters::{FftFilters, Workspace};
use crate::texton::texel_sums::TexelSums;
use crate::texton::transpose::transpose;

/// Writes the sums' components for planes, one after another: rows of [sums, planes · 48], which
/// `target` has in one or more blocks, one below another.
pub fn sum_responses(
    filters: &FftFilters,
    texel_sums: &TexelSums,
    planes: &[f32],
    target: Vec<ArrayViewMut2<'_, f32>>,
) {
    columns_of_pairs(target, 2 * filters.count())
        .into_par_iter()
        .zip(planes.par_chunks(2 * filters.texels()))
        .for_each_init(
            || filters.workspace(),
            |work, (target, planes)| sum_pair(filters, texel_sums, planes, work, target),
        );
}

/// The columns that each pair of planes fills, in every block.
fn columns_of_pairs(
    blocks: Vec<ArrayViewMut2<'_, f32>>,
    width: usize,
) -> Vec<Vec<ArrayViewMut2<'_, f32>>> {
    let mut pairs: Vec<Vec<_>> = Vec::new();
    for mut block in blocks {
        for pair in 0..block.ncols().div_ceil(width) {
            let end = width.min(block.ncols());
            let (columns, rest) = block.split_at(Axis(1), end);
            if pair == pairs.len() {
                pairs.push(Vec::new());
            }
            pairs[pair].push(columns);
            block = rest;
        }
    }
    pairs
}

fn sum_pair(
    filters: &FftFilters,
    texel_sums: &TexelSums,
    planes: &[f32],
    work: &mut Workspace,
    mut target: Vec<ArrayViewMut2<'_, f32>>,
) {
    let (filter_count, sum_count) = (filters.count(), texel_sums.count());
    let mut sums = vec![Complex32::default(); filter_count * sum_count];
    let spectrum = filters.spectrum(planes, work);
    for (filter, sums) in sums.chunks_exact_mut(sum_count).enumerate() {
        texel_sums.apply(filters.respond(&spectrum, filter, work), sums);
    }
    let mut rows = vec![Complex32::default(); sums.len()];
    transpose(&sums, sum_count, &mut rows, filter_count, |sum| sum);
    let targets = target.iter_mut().flat_map(|block| block.outer_iter_mut());
    for (mut target, row) in targets.zip(rows.chunks_exact(filter_count)) {
        // The first plane's part, and the second's, if there is one.
        let parts = row
            .iter()
            .map(|sum| sum.re)
            .chain(row.iter().map(|sum| sum.im));
        target.iter_mut().zip(parts).for_each(|(t, v)| *t = v);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::TexelGrid;
    use crate::texton::filter_bank::leung_malik;
    use crate::texton::oracle;
    use ndarray::Array2;

    #[test]
    fn centroids_are_the_means_of_their_members() {
        let bank = leung_malik();
        for tileable in [true, false] {
            let grid = TexelGrid {
                width: 9,
                height: 6,
                tileable,
            };
            let planes: Vec<Vec<f32>> = (0..5)
                .map(|p| {
                    (0..54)
                        .map(|i| ((i * i * 31 + p * 17) % 29) as f32 / 29.0)
                        .collect()
                })
                .collect();
            let labels: Vec<u32> = (0..54).map(|i| (i * i + i / 7) % 5).collect();
            let counts: Vec<u32> = (0..5)
                .map(|j| labels.iter().filter(|&&l| l == j).count() as u32)
                .collect();
            let filters = FftFilters::new(grid, &bank);
            let averages = TexelSums::averages(&labels, &counts, |texel| filters.place(texel));
            let mut centroids = Array2::zeros((5, 5 * 48));
            let (upper, lower) = centroids.view_mut().split_at(Axis(0), 2);
            sum_responses(&filters, &averages, &planes.concat(), vec![upper, lower]);
            let vectors = oracle::appearance_vectors(grid, &bank, &planes);
            for ((texton, d), v) in centroids.indexed_iter() {
                let members = (0..54).filter(|&i| labels[i] == texton as u32);
                let mean =
                    members.map(|i| vectors[[i, d]]).sum::<f64>() / f64::from(counts[texton]);
                assert!((f64::from(*v) - mean).abs() < 1e-6, "{v} against {mean}");
            }
        }
    }
}
