//! Samples between four texels, packed: a cell of 2 × 2 sites and the place in it, 8 bytes.

use std::sync::Arc;

use crate::sites::level::SampleLocation;

/// One part in so many is the finest step of a place in a cell.
const STEPS: u16 = u16::MAX;

/// One sample of one site: a cell and a place in it.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct CellSample {
    /// Index into [`CellStencils::cells`], or [`CellSample::OUTSIDE`]'s.
    pub cell: u32,
    /// How far the sample lies to the right and down from the cell's first site, in 1/65535.
    pub place: [u16; 2],
}

impl CellSample {
    /// A sample beyond the surface.
    pub const OUTSIDE: Self = Self {
        cell: u32::MAX,
        place: [0; 2],
    };

    /// A place in a cell, each part from 0 to 1.
    pub fn new(cell: u32, place: [f64; 2]) -> Self {
        let steps = |part: f64| (part.clamp(0.0, 1.0) * f64::from(STEPS)).round() as u16;
        Self {
            cell,
            place: place.map(steps),
        }
    }

    /// The sample among the sites of its cell: top left, top right, bottom left, bottom right.
    #[inline(always)]
    pub fn locate(self, cells: &[[u32; 4]]) -> SampleLocation<4> {
        if self.cell == Self::OUTSIDE.cell {
            return SampleLocation::Outside;
        }
        let sites = cells[self.cell as usize];
        match self.place {
            [0, 0] => SampleLocation::AtSite(sites[0]),
            [STEPS, 0] => SampleLocation::AtSite(sites[1]),
            [0, STEPS] => SampleLocation::AtSite(sites[2]),
            [STEPS, STEPS] => SampleLocation::AtSite(sites[3]),
            place => SampleLocation::Between(sites, bilinear(place.map(part))),
        }
    }
}

#[inline(always)]
fn part(steps: u16) -> f32 {
    f32::from(steps) / f32::from(STEPS)
}

/// The weights of a cell's sites at a place in it.
#[inline(always)]
pub fn bilinear([x, y]: [f32; 2]) -> [f32; 4] {
    [(1.0 - x) * (1.0 - y), x * (1.0 - y), (1.0 - x) * y, x * y]
}

/// The samples of every site of a level.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CellStencils {
    /// Samples per site.
    pub samples_per_site: usize,
    /// The sites of each cell.
    pub cells: Arc<Vec<[u32; 4]>>,
    /// Site after site, `samples_per_site` each, in the template's order.
    pub samples: Vec<CellSample>,
}

impl CellStencils {
    /// Where the samples of one site fall.
    #[inline(always)]
    pub fn of_site(&self, site: usize) -> impl Iterator<Item = SampleLocation<4>> + '_ {
        let samples = &self.samples[site * self.samples_per_site..][..self.samples_per_site];
        samples.iter().map(|sample| sample.locate(&self.cells))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_are_sites_and_all_else_is_blended() {
        let cells = [[5, 6, 7, 8]];
        let locate = |place| CellSample::new(0, place).locate(&cells);
        assert_eq!(locate([0.0, 0.0]), SampleLocation::AtSite(5));
        assert_eq!(locate([1.0, 0.0]), SampleLocation::AtSite(6));
        assert_eq!(locate([0.0, 1.0]), SampleLocation::AtSite(7));
        assert_eq!(locate([1.0, 1.0]), SampleLocation::AtSite(8));
        let SampleLocation::Between(sites, weights) = locate([0.25, 0.5]) else {
            panic!("not blended");
        };
        assert_eq!(sites, cells[0]);
        for (weight, expected) in weights.iter().zip([0.375, 0.125, 0.375, 0.125]) {
            assert!((weight - expected).abs() < 1e-4);
        }
        assert_eq!(CellSample::OUTSIDE.locate(&cells), SampleLocation::Outside);
    }
}
