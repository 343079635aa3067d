//! Coherence and drift: whether texture coordinates run along edges as the surface does.

use nalgebra::Matrix2;
use rayon::prelude::*;

use crate::grid::{TexCoord, TexelGrid};
use crate::sites::level::SiteEdge;

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

/// Edges summed by one task.
const CHUNK: usize = 1 << 13;

impl Coherence {
    /// Measures the coordinates along all edges.
    pub fn measure(grid: TexelGrid, coords: &[TexCoord], edges: &[SiteEdge]) -> Self {
        let sums = edges.par_chunks(CHUNK);
        let sums: Vec<Sums> = sums.map(|edges| Sums::of(grid, coords, edges)).collect();
        let all = sums.into_iter().fold(Sums::default(), Sums::plus);
        let count = edges.len().max(1) as f64;
        let inverse = all.square.try_inverse();
        let drift = inverse.map_or_else(Matrix2::zeros, |inverse| all.cross * inverse);
        Self {
            half: all.half as f64 / count,
            one: all.one as f64 / count,
            drift: [
                [drift[(0, 0)], drift[(0, 1)]],
                [drift[(1, 0)], drift[(1, 1)]],
            ],
            mean_edge: all.length / count,
        }
    }
}

/// What is summed over some edges.
#[derive(Clone, Copy, Default)]
struct Sums {
    /// Edges within half a texel, and within one.
    half: usize,
    one: usize,
    length: f64,
    /// Σ Δ oᵀ and Σ o oᵀ of the edges that say how the texture drifts.
    cross: Matrix2<f64>,
    square: Matrix2<f64>,
}

impl Sums {
    fn of(grid: TexelGrid, coords: &[TexCoord], edges: &[SiteEdge]) -> Self {
        let mut sums = Self::default();
        for edge in edges {
            let [x, y] = edge.offset.map(f64::from);
            let (from, to) = (coords[edge.from as usize], coords[edge.to as usize]);
            let (ds, dt) = grid.difference(from, to);
            let (ds, dt) = (f64::from(ds), f64::from(dt));
            let apart = (ds - x).abs().max((dt - y).abs());
            sums.half += usize::from(apart <= 0.5);
            sums.one += usize::from(apart <= 1.0);
            sums.length += (x * x + y * y).sqrt();
            if ds.abs().max(dt.abs()) <= 2.0 + x.abs().max(y.abs()) {
                sums.cross += Matrix2::new(ds * x, ds * y, dt * x, dt * y);
                sums.square += Matrix2::new(x * x, x * y, x * y, y * y);
            }
        }
        sums
    }

    fn plus(self, other: Self) -> Self {
        Self {
            half: self.half + other.half,
            one: self.one + other.one,
            length: self.length + other.length,
            cross: self.cross + other.cross,
            square: self.square + other.square,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::index::TexelIndex;
    use crate::mesh::reading::UserMesh;
    use crate::mesh::shapes;
    use crate::progress::Progress;
    use crate::sites::target::{Target, TargetSurface};
    use crate::sites::vertices::surface;
    use crate::sites::vertices::surface_options::SurfaceOptions;
    use glam::Vec3;

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
    fn sums_in_chunks_are_the_sums_of_all() {
        let (coords, edges) = field([[1.0, 0.125], [0.25, 0.75]]);
        let many = edges.repeat(CHUNK.div_ceil(20));
        assert!(many.len() > 2 * CHUNK);
        let (one, all) = [&edges, &many]
            .map(|edges| Coherence::measure(GRID, &coords, edges))
            .into();
        let close = |a: f64, b: f64| (a - b).abs() < 1e-9;
        assert!(close(one.half, all.half) && close(one.one, all.one));
        let drifts = one
            .drift
            .as_flattened()
            .iter()
            .zip(all.drift.as_flattened());
        assert!(drifts.into_iter().all(|(&a, &b)| close(a, b)));
        assert!(close(one.mean_edge, all.mean_edge));
    }

    #[test]
    fn one_constant_texel_has_no_drift_matrix_but_zero() {
        let at = GRID.centre(TexelIndex(5));
        let (_, edges) = field([[1.0, 0.0], [0.0, 1.0]]);
        let found = Coherence::measure(GRID, &[at; 36], &edges);
        assert_eq!(found.drift, [[0.0; 2]; 2]);
        assert_eq!((found.half, found.one), (0.0, 1.0));
    }

    const TEXEL: f64 = 0.5;
    const TILE: TexelGrid = TexelGrid {
        width: 8,
        height: 8,
        tileable: true,
    };

    /// A plane cut down its middle, of scale 1 left and 2 right of the cut.
    fn plane_of_two_scales() -> TargetSurface {
        let (mut mesh, mut right) = (shapes::grid(6, 6, 0.5), shapes::grid(6, 6, 0.5));
        let half = mesh.positions.len();
        mesh.positions
            .extend(right.positions.iter().map(|p| *p + 3.0 * Vec3::X));
        right
            .triangles
            .iter_mut()
            .flatten()
            .for_each(|v| *v += half as u32);
        mesh.triangles.extend(right.triangles);
        let scale: Vec<f32> = (0..2 * half)
            .map(|v| if v < half { 1.0 } else { 2.0 })
            .collect();
        let user = UserMesh {
            from_file: (0..2 * half as u32).collect(),
            orientation: Some(vec![Vec3::X; 2 * half]),
            scale: Some(scale),
            mesh,
            ..UserMesh::default()
        };
        let options = SurfaceOptions {
            levels: 1,
            texel: Some(TEXEL),
            neighborhood: 3,
            ..SurfaceOptions::default()
        };
        let surface = surface::prepare(&user, &options, None, Progress::silent()).unwrap();
        Target::of_surface(surface, &user).surface
    }

    /// Coordinates that run over the surface at one texel a `TEXEL` times the scale.
    fn copied(target: &TargetSurface) -> Vec<TexCoord> {
        let positions = target.mesh.positions.iter();
        let scale = target.scale.as_ref().unwrap();
        let coord = |(at, scale): (&Vec3, &f32)| TexCoord {
            s: (at.x / (TEXEL as f32 * scale)).rem_euclid(8.0),
            t: (at.y / (TEXEL as f32 * scale)).rem_euclid(8.0),
        };
        positions.zip(scale).map(coord).collect()
    }

    #[test]
    fn a_copy_at_the_pace_of_each_half_does_not_drift() {
        let mut target = plane_of_two_scales();
        let coords = copied(&target);
        let found = Coherence::measure(TILE, &coords, &target.edges());
        assert_eq!((found.half, found.one), (1.0, 1.0));
        for (row, expected) in found.drift.iter().zip([[1.0, 0.0], [0.0, 1.0]]) {
            for (found, expected) in row.iter().zip(expected) {
                assert!((found - expected).abs() < 1e-5, "{row:?}");
            }
        }
        // With one scale everywhere, the right half has half the drift: 0.75 over the edges of both.
        target.scale = None;
        let found = Coherence::measure(TILE, &coords, &target.edges());
        assert!((found.drift[0][0] - 0.75).abs() < 1e-5, "{found:?}");
        assert!((found.drift[1][1] - 0.75).abs() < 1e-5, "{found:?}");
    }
}
