//! Stencils: where a neighbourhood's samples fall among the sites, as a few weighted sites each.
//!
//! A stencil depends on mesh, field and scale alone, so it is computed once and used for any
//! exemplar. A sample lies in a *cell*, a triangle, and stores the cell and two weights: 8 bytes.

use crate::sites::level::SampleLocation;

/// One sample of one site: a cell and the weights of its first two sites.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct PackedSample {
    /// Index into [`PatchStencils::cells`], or [`PackedSample::NO_CELL`].
    pub cell: u32,
    /// Weights of the cell's first and second site, in 1/65535; the third has the rest.
    pub weights: [u16; 2],
}

impl PackedSample {
    /// `cell` of a sample that falls outside every patch triangle.
    pub const NO_CELL: u32 = u32::MAX;
    /// A sample that falls outside every patch triangle: it holds the default texton.
    pub const OUTSIDE: Self = Self {
        cell: Self::NO_CELL,
        weights: [0, 0],
    };

    /// Packs a cell and barycentric weights (clamped to the cell, rounded to 1/65535).
    pub fn new(cell: u32, weights: [f32; 3]) -> Self {
        let clamped = weights.map(|w| w.max(0.0));
        let sum: f32 = clamped.iter().sum();
        let first = (clamped[0] / sum * 65535.0).round() as u16;
        let second = ((clamped[1] / sum * 65535.0).round() as u16).min(u16::MAX - first);
        Self {
            cell,
            weights: [first, second],
        }
    }

    /// The three weights; they sum to 1.
    #[inline]
    pub fn barycentric(self) -> [f32; 3] {
        if self.weights[0] == u16::MAX {
            return [1.0, 0.0, 0.0];
        }
        let [first, second] = self.weights.map(u32::from);
        [first, second, 65535 - first - second].map(|w| w as f32 / 65535.0)
    }
}

/// The samples of every vertex of a mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PatchStencils {
    /// Samples per site.
    pub samples_per_site: usize,
    /// The sites of each cell, on the level that is sampled.
    pub cells: Vec<[u32; 3]>,
    /// Site after site, `samples_per_site` each, in the template's order.
    pub samples: Vec<PackedSample>,
}

impl PatchStencils {
    /// Where the samples of one site fall, in the template's order.
    #[inline(always)]
    pub fn of_site(&self, site: usize) -> impl Iterator<Item = SampleLocation<3>> + '_ {
        let samples = &self.samples[site * self.samples_per_site..][..self.samples_per_site];
        samples.iter().map(|&sample| self.locate(sample))
    }

    #[inline(always)]
    fn locate(&self, sample: PackedSample) -> SampleLocation<3> {
        if sample.cell == PackedSample::NO_CELL {
            return SampleLocation::Outside;
        }
        let sites = self.cells[sample.cell as usize];
        match sample.weights[0] {
            u16::MAX => SampleLocation::AtSite(sites[0]),
            _ => SampleLocation::Between(sites, sample.barycentric()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_survive_packing() {
        for weights in [
            [1.0, 0.0, 0.0],
            [0.2, 0.3, 0.5],
            [0.5, 0.5, -1e-4],
            [0.0, 0.0, 1.0],
        ] {
            let packed = PackedSample::new(3, weights);
            let back = packed.barycentric();
            assert!((back.iter().sum::<f32>() - 1.0).abs() < 1e-6);
            for (w, b) in weights.iter().zip(back) {
                assert!((w - b).abs() < 1e-3, "{weights:?} {back:?}");
            }
        }
    }
}
