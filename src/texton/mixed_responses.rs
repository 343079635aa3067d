//! Weighted sums of texels' appearance vectors: texton centres, the means of their members, and
//! random mixtures for a sketch.
//!
//! In: planes, and which texels to sum. Out: rows of appearance vectors [sums, planes · 48],
//! component plane · 48 + filter. Planes are filtered forwards, two at a time; a response is summed
//! where it was made and never stored.

use ndarray::{ArrayViewMut2, Axis};
use rayon::prelude::*;
use rustfft::num_complex::Complex32;

use crate::texton::plane_filters::{PlaneFilters, Workspace};
use crate::texton::texel_mixtures::TexelMixtures;

/// Writes the sums' components for planes, one after another, into [sums, planes · 48].
pub fn mix_into(
    filters: &PlaneFilters,
    mixtures: &TexelMixtures,
    planes: &[f32],
    mut target: ArrayViewMut2<'_, f32>,
) {
    target
        .axis_chunks_iter_mut(Axis(1), 2 * filters.count())
        .into_par_iter()
        .zip(planes.par_chunks(2 * filters.texels()))
        .for_each_init(
            || filters.workspace(),
            |work, (target, planes)| mix_pair(filters, mixtures, planes, work, target),
        );
}

fn mix_pair(
    filters: &PlaneFilters,
    mixtures: &TexelMixtures,
    planes: &[f32],
    work: &mut Workspace,
    mut target: ArrayViewMut2<'_, f32>,
) {
    let count = filters.count();
    let mut sums = vec![Complex32::default(); mixtures.count()];
    let mut rows = vec![0.0; sums.len() * 2 * count];
    let spectrum = filters.spectrum(planes, work);
    for filter in 0..count {
        mixtures.apply(filters.respond(&spectrum, filter, work), &mut sums);
        for (row, sum) in rows.chunks_exact_mut(2 * count).zip(&sums) {
            (row[filter], row[count + filter]) = (sum.re, sum.im);
        }
    }
    // A last plane without a partner has but the first half.
    for (mut target, row) in target.outer_iter_mut().zip(rows.chunks_exact(2 * count)) {
        target.iter_mut().zip(row).for_each(|(t, &v)| *t = v);
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
            let filters = PlaneFilters::new(grid, &bank);
            let averages = TexelMixtures::averages(&labels, &counts, |texel| filters.place(texel));
            let mut centroids = Array2::zeros((5, 5 * 48));
            mix_into(&filters, &averages, &planes.concat(), centroids.view_mut());
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
