//! Feature vectors of a level: a point in ℝᵈ for every feature row, with the distances that Φ
//! defines.
//!
//! With J = I − 11ᵀ/nₜ the centred Gram matrix Φc = J Φ J = F Fᵀ of nₜ textons has
//! ‖Fᵢ − Fⱼ‖² = Φᵢᵢ + Φⱼⱼ − 2Φᵢⱼ, and as the weights of a surface texton sum to 1 the same holds for
//! blends. The default texton, the textons' mean, is the origin, exactly. F has the eigenvectors of
//! Φc, scaled, as its columns; keeping only the leading ones keeps a share of the spectrum.
//! Plain images have their vectors already: they are centred and kept whole.

use nalgebra::{DMatrix, SymmetricEigen};
use ndarray::{Array2, Array3};

use crate::exemplar::space::{Features, SpaceLevel};
use crate::lanes::{LANES, LaneBlock};

/// The feature vectors of a level, the default's last.
#[derive(Clone, Debug, PartialEq)]
pub struct Embedding {
    /// Numbers a vector before padding.
    pub dimensions: usize,
    /// Blocks a vector.
    pub blocks: usize,
    /// Vectors, the default's included.
    pub rows: usize,
    /// The first blocks of all vectors, then their second ones, and so on: the first say most.
    vectors: Vec<LaneBlock>,
    /// Share of the spectrum kept.
    pub kept: f64,
}

impl Embedding {
    /// The feature vectors of a level, keeping a share `spectrum` of Φc's spectrum.
    pub fn new(level: &SpaceLevel, spectrum: f64) -> Self {
        match &level.features {
            Features::Textons { gram, .. } => Self::of_gram(gram, spectrum),
            Features::Plain(vectors) => Self::of_vectors(vectors),
        }
    }

    /// One block of every vector, by feature row.
    #[inline(always)]
    pub fn plane(&self, block: usize) -> &[LaneBlock] {
        &self.vectors[block * self.rows..][..self.rows]
    }

    fn of_gram(gram: &Array2<f32>, spectrum: f64) -> Self {
        let centred = centred(gram);
        let count = centred.nrows();
        let eigen = SymmetricEigen::new(centred);
        let leading = leading(eigen.eigenvalues.as_slice(), spectrum);
        let total: f64 = eigen.eigenvalues.iter().map(|value| value.max(0.0)).sum();
        let held: f64 = leading.iter().map(|&i| eigen.eigenvalues[i].max(0.0)).sum();
        let component = |row: usize, &column: &usize| {
            eigen.eigenvectors[(row, column)] * eigen.eigenvalues[column].max(0.0).sqrt()
        };
        let rows = (0..count).map(|row| {
            let numbers = leading.iter().map(move |column| component(row, column));
            numbers.map(|number| number as f32)
        });
        Self {
            kept: if total > 0.0 { held / total } else { 1.0 },
            ..Self::pack(leading.len(), count, rows)
        }
    }

    fn of_vectors(vectors: &Array3<f32>) -> Self {
        let (height, width, dimensions) = vectors.dim();
        let count = height * width;
        let mut mean = vec![0.0; dimensions];
        for (index, &value) in vectors.iter().enumerate() {
            mean[index % dimensions] += f64::from(value) / count as f64;
        }
        let (values, mean): (Vec<f32>, _) = (vectors.iter().copied().collect(), &mean);
        let rows = values.chunks_exact(dimensions).map(|row| {
            let centred = row.iter().zip(mean).map(|(&v, m)| f64::from(v) - m);
            centred.map(|number| number as f32)
        });
        Self::pack(dimensions, count, rows)
    }

    /// Packs `count` vectors, and the default's, which is the origin.
    fn pack(
        dimensions: usize,
        count: usize,
        rows: impl Iterator<Item = impl Iterator<Item = f32>>,
    ) -> Self {
        let blocks = dimensions.div_ceil(LANES).max(1);
        let rows_in_all = count + 1;
        let mut vectors = vec![[0.0; LANES]; rows_in_all * blocks];
        for (row, numbers) in rows.enumerate() {
            for (dimension, number) in numbers.enumerate() {
                vectors[dimension / LANES * rows_in_all + row][dimension % LANES] = number;
            }
        }
        Self {
            dimensions,
            blocks,
            rows: rows_in_all,
            vectors,
            kept: 1.0,
        }
    }
}

/// J Φ J of the textons, the default's row and column left out.
fn centred(gram: &Array2<f32>) -> DMatrix<f64> {
    let count = gram.nrows() - 1;
    let phi = DMatrix::from_fn(count, count, |i, j| f64::from(gram[(i, j)]));
    let means: Vec<f64> = (0..count)
        .map(|i| phi.row(i).iter().sum::<f64>() / count as f64)
        .collect();
    let mean = means.iter().sum::<f64>() / count as f64;
    DMatrix::from_fn(count, count, |i, j| {
        0.5 * (phi[(i, j)] + phi[(j, i)]) - means[i] - means[j] + mean
    })
}

/// The fewest leading positive eigenvalues whose sum is at least `spectrum` of all positive ones.
fn leading(values: &[f64], spectrum: f64) -> Vec<usize> {
    let mut order: Vec<usize> = (0..values.len()).filter(|&i| values[i] > 0.0).collect();
    order.sort_by(|&a, &b| values[b].total_cmp(&values[a]).then(a.cmp(&b)));
    if spectrum >= 1.0 {
        return order;
    }
    let total: f64 = order.iter().map(|&i| values[i]).sum();
    let mut held = 0.0;
    let enough = order.iter().position(|&i| {
        held += values[i];
        held >= spectrum * total
    });
    order.truncate(enough.map_or(order.len(), |last| last + 1));
    order
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthesis::tests::fixtures;

    fn numbers(embedding: &Embedding, row: u32) -> impl Iterator<Item = f32> {
        let blocks = 0..embedding.blocks;
        blocks.flat_map(move |block| embedding.plane(block)[row as usize])
    }

    fn squared_distance(embedding: &Embedding, a: u32, b: u32) -> f64 {
        let pairs = numbers(embedding, a).zip(numbers(embedding, b));
        pairs.map(|(x, y)| f64::from(x - y).powi(2)).sum()
    }

    #[test]
    fn distances_are_those_of_the_gram_matrix() {
        let gram = fixtures::random_gram(5, 20, 50);
        let embedding = Embedding::of_gram(&gram, 1.0);
        let scale = f64::from(gram[(0, 0)]);
        for i in 0..=20 {
            for j in 0..=20 {
                let phi = |a, b| f64::from(gram[(a, b)]);
                let expected = phi(i, i) + phi(j, j) - 2.0 * phi(i, j);
                let found = squared_distance(&embedding, i as u32, j as u32);
                assert!((found - expected).abs() < 1e-5 * scale, "{i} {j}");
            }
        }
    }

    #[test]
    fn the_default_texton_is_the_origin() {
        let embedding = Embedding::of_gram(&fixtures::random_gram(1, 7, 9), 1.0);
        assert!(numbers(&embedding, 7).all(|v| v == 0.0));
    }

    #[test]
    fn the_spectrum_is_cut_where_asked() {
        assert_eq!(leading(&[1.0, 6.0, -0.1, 3.0], 0.6), [1]);
        assert_eq!(leading(&[1.0, 6.0, -0.1, 3.0], 0.61), [1, 3]);
        assert_eq!(leading(&[1.0, 6.0, -0.1, 3.0], 1.0), [1, 3, 0]);
        assert_eq!(leading(&[0.0, 0.0], 0.5), [0usize; 0]);
        let embedding = Embedding::of_gram(&fixtures::random_gram(2, 30, 40), 0.7);
        assert!(embedding.kept >= 0.7 && embedding.kept < 0.8);
        assert!(embedding.dimensions < 20);
    }
}
