//! Stencils: where a neighbourhood's samples fall among the sites, as a few weighted sites each.
//!
//! A stencil depends on mesh, field and scale alone, so it is computed once and used for any
//! exemplar. On a mesh a sample lies in a *cell*, a triangle, and stores the cell and two weights: 8
//! bytes. On a flat grid it coincides with a site.

use either::Either;
use glam::{DVec2, Vec2};

use crate::mesh::grid_window::GridWindow;

/// Positions of a neighbourhood's samples round its centre, in texels of their level, x along s,
/// y along t (so template offset (drow, dcol) lies at (dcol, −drow)).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Template {
    /// One position per sample, in the order of the neighbourhood's offsets.
    pub positions: Vec<Vec2>,
    /// How many positions lie on each ring or inside it, the centre first; empty for a template that is
    /// not ordered by rings. The samples before `ring_ends[m]` are the neighbourhood of m rings.
    pub ring_ends: Vec<usize>,
}

impl Template {
    /// The square window of odd `width`, row by row from the top left, centre included.
    pub fn square(width: u32) -> Self {
        let half = i64::from(width / 2);
        let positions = (-half..=half)
            .flat_map(|drow| (-half..=half).map(move |dcol| Vec2::new(dcol as f32, -drow as f32)))
            .collect();
        Self {
            positions,
            ring_ends: Vec::new(),
        }
    }

    /// The round neighbourhood (Chen 2008 §4.2): where circles of radius 1 to `rings` meet the lines x = i
    /// and y = j of the unit grid through the centre. The centre comes first, then ring by ring,
    /// counter-clockwise from +x.
    pub fn round(rings: u32) -> Self {
        let mut template = Self {
            positions: vec![Vec2::ZERO],
            ring_ends: vec![1],
        };
        for radius in 1..=i64::from(rings) {
            let mut ring = grid_crossings(radius);
            ring.sort_by(|a, b| turn_of(*a).total_cmp(&turn_of(*b)));
            template.positions.extend(ring.iter().map(|p| p.as_vec2()));
            template.ring_ends.push(template.positions.len());
        }
        template
    }
}

/// Where the circle of a whole radius meets the lines of the unit grid, each point once.
fn grid_crossings(radius: i64) -> Vec<DVec2> {
    let mut points = Vec::new();
    for line in -radius..=radius {
        let squared = radius * radius - line * line;
        let (at, across) = (line as f64, (squared as f64).sqrt());
        let ends = if squared == 0 {
            vec![0.0]
        } else {
            vec![across, -across]
        };
        points.extend(ends.iter().map(|&end| DVec2::new(at, end)));
        // A point on two lines is listed once, with the lines x = i.
        if across.fract() != 0.0 {
            points.extend(ends.iter().map(|&end| DVec2::new(end, at)));
        }
    }
    points
}

/// The angle of a point from +x, counter-clockwise, in turns from 0 up to 1.
pub fn turn_of(point: DVec2) -> f64 {
    let turn = point.y.atan2(point.x) / std::f64::consts::TAU;
    // A turn of −10⁻¹⁷ and one make 1 in floating point.
    turn.rem_euclid(1.0) % 1.0
}

/// One sample of one site: a cell and the weights of its first two sites.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct PackedSample {
    /// Index into [`Stencils::cells`], or [`PackedSample::NO_CELL`].
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

/// Where a sample falls.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SampleLocation {
    /// Outside every patch triangle, or off the grid.
    Outside,
    /// On a site.
    AtSite(u32),
    /// Between three sites, with their weights.
    InCell([u32; 3], [f32; 3]),
}

/// The samples of every site of a level, for one template.
#[derive(Clone, Debug, PartialEq)]
pub enum Stencils {
    /// Those of a mesh's patches.
    OfPatches(PatchStencils),
    /// Those of a flat grid.
    OfGrid(GridWindow),
}

/// The samples of every vertex of a mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PatchStencils {
    /// Samples a site.
    pub samples_per_site: usize,
    /// The sites of each cell, on the level that is sampled.
    pub cells: Vec<[u32; 3]>,
    /// Site after site, `samples_per_site` each, in the template's order.
    pub samples: Vec<PackedSample>,
}

impl Stencils {
    /// Samples a site.
    pub fn samples_per_site(&self) -> usize {
        match self {
            Self::OfPatches(stencils) => stencils.samples_per_site,
            Self::OfGrid(window) => window.samples_per_site(),
        }
    }

    /// Where the samples of one site fall, in the template's order.
    #[inline(always)]
    pub fn of_site(&self, site: usize) -> impl Iterator<Item = SampleLocation> + '_ {
        match self {
            Self::OfPatches(stencils) => Either::Left(stencils.of_site(site)),
            Self::OfGrid(window) => Either::Right(window.of_site(site)),
        }
    }

    /// Sites that have samples.
    pub fn site_count(&self) -> usize {
        match self {
            Self::OfPatches(stencils) => stencils.samples.len() / stencils.samples_per_site.max(1),
            Self::OfGrid(window) => window.site_count(),
        }
    }
}

impl PatchStencils {
    /// Where the samples of one site fall, in the template's order.
    #[inline(always)]
    pub fn of_site(&self, site: usize) -> impl Iterator<Item = SampleLocation> + '_ {
        let samples = &self.samples[site * self.samples_per_site..][..self.samples_per_site];
        samples.iter().map(|&sample| self.locate(sample))
    }

    #[inline(always)]
    fn locate(&self, sample: PackedSample) -> SampleLocation {
        if sample.cell == PackedSample::NO_CELL {
            return SampleLocation::Outside;
        }
        let sites = self.cells[sample.cell as usize];
        match sample.weights[0] {
            u16::MAX => SampleLocation::AtSite(sites[0]),
            _ => SampleLocation::InCell(sites, sample.barycentric()),
        }
    }
}

impl SampleLocation {
    /// The sites that the sample reads.
    #[inline(always)]
    pub fn sites(&self) -> &[u32] {
        match self {
            Self::Outside => &[],
            Self::AtSite(site) => std::slice::from_ref(site),
            Self::InCell(sites, _) => sites,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_square_template_reads_like_an_image() {
        let template = Template::square(3);
        assert_eq!(template.positions[0], Vec2::new(-1.0, 1.0));
        assert_eq!(template.positions[4], Vec2::ZERO);
        assert_eq!(template.positions[5], Vec2::new(1.0, 0.0));
    }

    #[test]
    fn rings_of_the_round_template_are_prefixes_and_lie_on_the_grid() {
        let template = Template::round(5);
        // 8m − 4 points on ring m; the eight points (±3, ±4) and (±4, ±3) lie on two lines each.
        assert_eq!(template.ring_ends, [1, 5, 17, 37, 65, 93]);
        assert_eq!(Template::round(3).positions, template.positions[..37]);
        for ring in 1..=5 {
            let of_ring =
                &template.positions[template.ring_ends[ring - 1]..template.ring_ends[ring]];
            assert_eq!(of_ring[0], Vec2::new(ring as f32, 0.0));
            let turns: Vec<f64> = of_ring.iter().map(|p| turn_of(p.as_dvec2())).collect();
            assert!(turns.windows(2).all(|pair| pair[1] - pair[0] > 1e-3));
            for p in of_ring {
                assert!((p.length() - ring as f32).abs() < 1e-5);
                assert!(p.x.fract() == 0.0 || p.y.fract() == 0.0, "{p}");
            }
        }
    }

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
