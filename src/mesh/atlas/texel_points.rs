//! The surface point of every texel: that whose texture coordinates are the texel's centre.

use glam::{DVec2, Vec3};

use super::charts::Atlas;
use crate::mesh::surface_bvh::SurfacePoint;
use crate::mesh::topology::NONE;
use crate::mesh::triangle_mesh::TriangleMesh;

/// The most texels of an image.
pub const MOST_TEXELS: u64 = 1 << 26;

/// Where each texel's centre lies on the surface. Row-major, row 0 on top: the centre of texel (row, column)
/// has u = (column + 1/2) / width and v = 1 − (row + 1/2) / height.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TexelPoints {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Per texel its triangle, [`NONE`] outside all charts.
    pub triangle: Vec<u32>,
    /// Per texel the weights of its triangle's corners; zeros outside.
    pub weights: Vec<[f32; 3]>,
}

impl TexelPoints {
    /// A texture coordinate in texels from the centre of texel (0, 0): x to the right, y down.
    #[inline]
    pub fn place(&self, uv: DVec2) -> DVec2 {
        DVec2::new(
            uv.x * f64::from(self.width) - 0.5,
            (1.0 - uv.y) * f64::from(self.height) - 0.5,
        )
    }

    /// The texture coordinate of a texel's centre.
    #[inline]
    pub fn centre(&self, texel: usize) -> DVec2 {
        let texel = texel as u32;
        self.centre_of(texel / self.width, texel % self.width)
    }

    #[inline]
    pub(super) fn centre_of(&self, row: u32, column: u32) -> DVec2 {
        DVec2::new(
            (f64::from(column) + 0.5) / f64::from(self.width),
            1.0 - (f64::from(row) + 0.5) / f64::from(self.height),
        )
    }

    /// The texel at a signed row and column; `None` off the image.
    #[inline]
    pub fn texel_at(&self, row: i64, column: i64) -> Option<usize> {
        let on_image = (0..i64::from(self.height)).contains(&row)
            && (0..i64::from(self.width)).contains(&column);
        on_image.then(|| (row * i64::from(self.width) + column) as usize)
    }

    /// The chart of a texel, `None` outside all.
    #[inline]
    pub fn chart(&self, atlas: &Atlas, texel: usize) -> Option<u32> {
        match self.triangle[texel] {
            NONE => None,
            triangle => Some(atlas.chart_of[triangle as usize]),
        }
    }

    /// The surface point of a texel inside a chart.
    #[inline]
    pub fn surface_point(&self, mesh: &TriangleMesh, texel: usize) -> SurfacePoint {
        let (triangle, weights) = (self.triangle[texel], self.weights[texel]);
        if triangle == NONE {
            return SurfacePoint::NOWHERE;
        }
        let corners = mesh.corners(triangle as usize);
        SurfacePoint {
            triangle,
            weights,
            position: (0..3).map(|k| corners[k] * weights[k]).sum::<Vec3>(),
        }
    }

    /// Whether a texel lies in a chart.
    #[inline]
    pub fn is_inside(&self, texel: usize) -> bool {
        self.triangle[texel] != NONE
    }

    /// How many texels lie in charts.
    pub fn inside(&self) -> usize {
        self.triangle.iter().filter(|&&t| t != NONE).count()
    }

    pub(super) fn set(&mut self, texel: usize, point: &SurfacePoint) {
        self.triangle[texel] = point.triangle;
        self.weights[texel] = point.weights;
    }
}

/// The offsets [drow, dcolumn] of largest part `reach`.
pub(super) fn ring(reach: i64) -> impl Iterator<Item = [i64; 2]> {
    (-reach..=reach).flat_map(move |drow| {
        let step = match drow.abs() == reach {
            true => 1,
            false => (2 * reach).max(1),
        };
        (-reach..=reach)
            .step_by(step as usize)
            .map(move |dcolumn| [drow, dcolumn])
    })
}
