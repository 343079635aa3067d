//! Labels of a mask as vectors: the corners of a regular simplex, so that any two labels are equally far apart
//! and blends of labels can be compared.

use crate::exemplar::controls::MASK_LABELS;

/// Numbers per vector at most.
const DIMENSIONS: usize = MASK_LABELS as usize - 1;

/// The corners of a regular tetrahedron with edges of length 1. The first ones are those of a triangle, and of an edge.
const CORNERS: [[f64; DIMENSIONS]; MASK_LABELS as usize] = [
    [0.0, 0.0, 0.0],
    [1.0, 0.0, 0.0],
    [0.5, 0.866_025_403_784_438_6, 0.0],
    [0.5, 0.288_675_134_594_812_9, 0.816_496_580_927_726],
];

/// The vectors of labels.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LabelVectors {
    /// The vector of every label up to the largest, then the mean in the mask, one after the other.
    pub vectors: Vec<f32>,
    /// Numbers per vector: one for two labels.
    pub dimensions: usize,
}

impl LabelVectors {
    /// The number of the mean's vector.
    pub fn mean(&self) -> u32 {
        self.dimensions as u32 + 1
    }
}

/// The vectors of the labels of a mask, scaled so that their mean squared distance from the mean is `variance`.
pub fn label_vectors(mask: &[u32], variance: f64) -> LabelVectors {
    let dimensions = mask
        .iter()
        .max()
        .map_or(1, |&largest| largest.max(1) as usize);
    let mut mean = [0.0; DIMENSIONS];
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
    let all = CORNERS[..=dimensions].iter().chain([&mean]);
    let numbers = all.flat_map(|vector| &vector[..dimensions]);
    LabelVectors {
        vectors: numbers.map(|number| (scale * number) as f32).collect(),
        dimensions,
    }
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
        for labels in 2..=4 {
            let mask: Vec<u32> = (0..100).map(|at| at % 5 % labels).collect();
            let found = label_vectors(&mask, 2.5);
            let dimensions = found.dimensions;
            assert_eq!(dimensions, labels as usize - 1);
            assert_eq!(found.vectors.len(), (labels as usize + 1) * dimensions);
            assert_eq!(found.mean(), labels);
            assert!((spread(&mask, &found.vectors, dimensions) - 2.5).abs() < 1e-5);
            let vector = |label: u32| &found.vectors[label as usize * dimensions..][..dimensions];
            let apart = |a: u32, b: u32| -> f32 {
                let pairs = vector(a).iter().zip(vector(b));
                pairs.map(|(a, b)| (a - b).powi(2)).sum()
            };
            for (a, b) in (0..labels).flat_map(|a| (0..a).map(move |b| (a, b))) {
                assert!((apart(a, b) - apart(0, 1)).abs() < 1e-5);
            }
        }
    }
}
