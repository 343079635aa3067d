//! Coherence and drift: whether texture coordinates run along edges as the surface does.

use nalgebra::Matrix2;

use crate::grid::{TexCoord, TexelGrid};

/// An edge between two sites, and where the second lies seen from the first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SiteEdge {
    /// The site with the smaller index.
    pub from: u32,
    /// The other.
    pub to: u32,
    /// Offset of `to` in the (s, t) plane of `from`, in texels of level 0.
    pub offset: [f32; 2],
}

/// The figures of [`Quality`](super::Quality) that need edges only.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coherence {
    /// Share of edges within half a texel.
    pub half: f64,
    /// Share within one.
    pub one: f64,
    /// The matrix M (rows s, t) that minimises Σ‖Δ − M o‖² over edges with |Δ|∞ ≤ 2 + |o|∞.
    pub drift: [[f64; 2]; 2],
    /// Mean edge length, in texels.
    pub mean_edge: f64,
}

impl Coherence {
    /// Measures the coordinates along all edges.
    pub fn measure(grid: TexelGrid, coords: &[TexCoord], edges: &[SiteEdge]) -> Self {
        let (mut half, mut one, mut length) = (0usize, 0usize, 0.0);
        let (mut cross, mut square) = (Matrix2::zeros(), Matrix2::zeros());
        for edge in edges {
            let [x, y] = edge.offset.map(f64::from);
            let (from, to) = (coords[edge.from as usize], coords[edge.to as usize]);
            let (ds, dt) = grid.difference(from, to);
            let (ds, dt) = (f64::from(ds), f64::from(dt));
            let apart = (ds - x).abs().max((dt - y).abs());
            half += usize::from(apart <= 0.5);
            one += usize::from(apart <= 1.0);
            length += x.hypot(y);
            if ds.abs().max(dt.abs()) <= 2.0 + x.abs().max(y.abs()) {
                cross += Matrix2::new(ds * x, ds * y, dt * x, dt * y);
                square += Matrix2::new(x * x, x * y, x * y, y * y);
            }
        }
        let count = edges.len().max(1) as f64;
        let drift = square
            .try_inverse()
            .map_or_else(Matrix2::zeros, |inverse| cross * inverse);
        Self {
            half: half as f64 / count,
            one: one as f64 / count,
            drift: [
                [drift[(0, 0)], drift[(0, 1)]],
                [drift[(1, 0)], drift[(1, 1)]],
            ],
            mean_edge: length / count,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::index::TexelIndex;

    const GRID: TexelGrid = TexelGrid {
        width: 16,
        height: 12,
        tileable: true,
    };

    /// Edges right and up over a 6×6 field of sites, and the coordinates M gives them.
    fn field(m: [[f32; 2]; 2]) -> (Vec<TexCoord>, Vec<SiteEdge>) {
        let coord = |x: f32, y: f32| TexCoord {
            s: (3.5 + m[0][0] * x + m[0][1] * y).rem_euclid(16.0),
            t: (4.5 + m[1][0] * x + m[1][1] * y).rem_euclid(12.0),
        };
        let sites = (0..36).map(|i| ((i % 6) as f32, (i / 6) as f32));
        let mut edges = Vec::new();
        for i in 0..36u32 {
            for (to, offset) in [(i + 1, [1.0, 0.0]), (i + 6, [0.0, 1.0])] {
                let same_row = to == i + 6 || i % 6 < 5;
                if to < 36 && same_row {
                    edges.push(SiteEdge {
                        from: i,
                        to,
                        offset,
                    });
                }
            }
        }
        (sites.map(|(x, y)| coord(x, y)).collect(), edges)
    }

    #[test]
    fn a_copy_is_coherent_and_does_not_drift() {
        let (coords, edges) = field([[1.0, 0.0], [0.0, 1.0]]);
        let found = Coherence::measure(GRID, &coords, &edges);
        assert_eq!((found.half, found.one), (1.0, 1.0));
        assert_eq!(found.mean_edge, 1.0);
        for (row, expected) in found.drift.iter().zip([[1.0, 0.0], [0.0, 1.0]]) {
            for (found, expected) in row.iter().zip(expected) {
                assert!((found - expected).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn a_mirrored_and_stretched_map_shows_in_the_drift() {
        let (coords, edges) = field([[-1.0, 0.25], [0.0, 1.5]]);
        let found = Coherence::measure(GRID, &coords, &edges);
        assert!((found.drift[0][0] + 1.0).abs() < 1e-5);
        assert!((found.drift[0][1] - 0.25).abs() < 1e-5);
        assert!((found.drift[1][1] - 1.5).abs() < 1e-5);
        assert!(found.half < 0.6);
    }

    #[test]
    fn one_constant_texel_has_no_drift_matrix_but_zero() {
        let at = GRID.centre(TexelIndex(5));
        let (_, edges) = field([[1.0, 0.0], [0.0, 1.0]]);
        let found = Coherence::measure(GRID, &[at; 36], &edges);
        assert_eq!(found.drift, [[0.0; 2]; 2]);
        assert_eq!((found.half, found.one), (0.0, 1.0));
    }
}
