//! Labels of a mask as vectors: the corners of a regular simplex, so that any two labels are equally far apart
//! and blends of labels can be compared.

use crate::exemplar::controls::MASK_LABELS;

/// Numbers per vector.
pub const LABEL_DIMENSIONS: usize = MASK_LABELS as usize - 1;

/// The corners of a regular tetrahedron with edges of length 1.
const CORNERS: [[f64; LABEL_DIMENSIONS]; MASK_LABELS as usize] = [
    [0.0, 0.0, 0.0],
    [1.0, 0.0, 0.0],
    [0.5, 0.866_025_403_784_438_6, 0.0],
    [0.5, 0.288_675_134_594_812_9, 0.816_496_580_927_726],
];

/// The vectors of all labels and of their mean in a mask, one after the other, scaled so that their mean squared
/// distance from the mean is `variance`.
pub fn label_vectors(mask: &[u32], variance: f64) -> Vec<f32> {
    let mut mean = [0.0; LABEL_DIMENSIONS];
    for &label in mask {
        for (sum, number) in mean.iter_mut().zip(CORNERS[label as usize]) {
            *sum += number / mask.len() as f64;
        }
    }
    let away = |&label: &u32| -> f64 {
        let pairs = CORNERS[label as usize].into_iter().zip(mean);
        pairs.map(|(number, mean)| (number - mean).powi(2)).sum()
    };
    let found = mask.iter().map(away).sum::<f64>() / mask.len() as f64;
    let scale = match found > 0.0 {
        true => (variance / found).sqrt(),
        false => 1.0,
    };
    let all = CORNERS.into_iter().chain([mean]).flatten();
    all.map(|number| (scale * number) as f32).collect()
}

/// The mean squared distance of the vectors of some rows from their mean.
pub fn spread(rows: &[u32], vectors: &[f32], dimensions: usize) -> f64 {
    let vector = |row: u32| &vectors[row as usize * dimensions..][..dimensions];
    let count = rows.len() as f64;
    let mut sums = vec![[0.0; 2]; dimensions];
    for &row in rows {
        for (sums, &number) in sums.iter_mut().zip(vector(row)) {
            sums[0] += f64::from(number) / count;
            sums[1] += f64::from(number).powi(2) / count;
        }
    }
    sums.iter()
        .map(|[mean, square]| (square - mean.powi(2)).max(0.0))
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_are_equally_far_apart_and_spread_as_asked() {
        let mask: Vec<u32> = (0..100).map(|at| [0, 0, 1, 2, 3][at % 5]).collect();
        let vectors = label_vectors(&mask, 2.5);
        assert_eq!(vectors.len(), 5 * LABEL_DIMENSIONS);
        assert!((spread(&mask, &vectors, LABEL_DIMENSIONS) - 2.5).abs() < 1e-5);
        let vector = |label: usize| &vectors[label * LABEL_DIMENSIONS..][..LABEL_DIMENSIONS];
        let apart = |a: usize, b: usize| -> f32 {
            vector(a)
                .iter()
                .zip(vector(b))
                .map(|(a, b)| (a - b).powi(2))
                .sum()
        };
        for (a, b) in [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)] {
            assert!((apart(a, b) - apart(0, 1)).abs() < 1e-5);
        }
    }
}
