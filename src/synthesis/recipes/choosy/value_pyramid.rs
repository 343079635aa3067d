//! Gaussian and Laplacian pyramids of numbers on faces (Castellanos and Williams §3.3, after Burt and Adelson 1983).

use crate::error::Result;
use crate::progress::Progress;
use crate::synthesis::recipes::choosy::face_values::FaceValues;
use crate::synthesis::recipes::choosy::kernel::FaceKernel;

/// The two pyramids, the coarsest level first.
#[derive(Clone, Debug, PartialEq)]
pub struct ValuePyramid {
    /// G_k: the finest level as it was given, every coarser one reduced from the next finer.
    pub gaussian: Vec<FaceValues>,
    /// L_k = G_k − project(G_(k−1)); level 0 has none and is empty.
    pub laplacian: Vec<FaceValues>,
}

impl ValuePyramid {
    /// The pyramids of values on the finest level; a kernel per level.
    pub fn new(
        kernels: &[FaceKernel<'_>],
        finest: FaceValues,
        progress: Progress<'_>,
    ) -> Result<Self> {
        let mut gaussian = vec![finest];
        for kernel in kernels.iter().skip(1).rev() {
            gaussian.push(kernel.reduce(&gaussian[gaussian.len() - 1]));
            progress.check()?;
        }
        gaussian.reverse();
        let mut laplacian = vec![FaceValues::default()];
        for (kernel, levels) in kernels.iter().skip(1).zip(gaussian.windows(2)) {
            laplacian.push(levels[1].clone().plus(-1.0, &kernel.project(&levels[0])));
            progress.check()?;
        }
        Ok(Self {
            gaussian,
            laplacian,
        })
    }
}

/// G_k from L_k and G_(k−1).
pub fn expanded(
    kernel: &FaceKernel<'_>,
    laplacian: &FaceValues,
    coarser: &FaceValues,
) -> FaceValues {
    kernel.project(coarser).plus(1.0, laplacian)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random;
    use crate::sites::faces::triangular_grid::TriangularGrid;
    use crate::synthesis::recipes::choosy::kernel::kernels;
    use rand::Rng;

    #[test]
    fn pyramids_can_be_inverted() {
        let grid = TriangularGrid::new(24, 3).unwrap();
        let kernels = kernels(&grid.pyramid, &[1.2, 1.3, 1.1]);
        let mut stream = random::stream(5, "values", 0, 0);
        let count = grid.pyramid.levels[2].count();
        let finest = FaceValues {
            channels: 3,
            numbers: (0..3 * count).map(|_| stream.gen_range(0.0..1.0)).collect(),
        };
        let pyramid = ValuePyramid::new(&kernels, finest.clone(), Progress::silent()).unwrap();
        let mut held = pyramid.gaussian[0].clone();
        for (kernel, laplacian) in kernels.iter().zip(&pyramid.laplacian).skip(1) {
            held = expanded(kernel, laplacian, &held);
        }
        for (held, wanted) in held.numbers.iter().zip(&finest.numbers) {
            assert!((held - wanted).abs() <= 1e-5 * wanted.abs().max(0.1));
        }
        // Coarser levels vary less.
        let spread = |values: &FaceValues| {
            let numbers = || values.numbers.iter().map(|&n| f64::from(n));
            let mean = numbers().sum::<f64>() / values.numbers.len() as f64;
            numbers().map(|n| (n - mean).powi(2)).sum::<f64>() / values.numbers.len() as f64
        };
        let spreads: Vec<f64> = pyramid.gaussian.iter().map(spread).collect();
        assert!(
            spreads[0] < spreads[1] && spreads[1] < 0.3 * spreads[2],
            "{spreads:?}"
        );
    }
}
