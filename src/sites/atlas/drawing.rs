//! How a planar chart is laid on the plane of a template, for one site (Ying 2001 §4.2, steps 1 to 3).

use glam::{Mat2, Quat, Vec2, Vec3};

use super::geometry::Geometry;
use super::texels::LevelTexels;

/// How a chart is laid on the template's plane.
#[derive(Clone, Copy, Debug)]
pub struct Drawing {
    /// Where the site lies in the chart.
    pub centre: Vec2,
    /// From texels along s and t to the chart.
    pub chart_from_texels: Mat2,
}

impl Drawing {
    /// The drawing in which s and t become the axes in the triangle of a site; `corners` is where the chart has
    /// that triangle. `None` where the chart folds there.
    pub fn new(
        geometry: &Geometry<'_>,
        level: &LevelTexels,
        site: usize,
        corners: [Vec2; 3],
    ) -> Option<Self> {
        let point = level.point(geometry, site);
        let [a, b, c] = corners;
        let [x, y, z] = point.weights;
        let axes = axes_on_triangle(geometry, level, site, point.triangle as usize)?;
        let [along_s, along_t] = axes.map(|[first, second]| (b - a) * first + (c - a) * second);
        let chart_from_texels = Mat2::from_cols(along_s, along_t);
        (chart_from_texels.determinant() > 0.0).then(|| Self {
            centre: a * x + b * y + c * z,
            chart_from_texels,
        })
    }
}

/// One texel along s and one along t at a site, each in parts of the first two edges of its triangle.
fn axes_on_triangle(
    geometry: &Geometry<'_>,
    level: &LevelTexels,
    site: usize,
    triangle: usize,
) -> Option<[[f32; 2]; 2]> {
    let [a, b, c] = geometry.mesh.corners(triangle);
    let (first, second) = (b - a, c - a);
    let normal = first.cross(second).try_normalize()?;
    let frame = level.frames[site];
    let turn = Quat::from_rotation_arc(frame.n, normal);
    let doubled = first.cross(second).dot(normal);
    let parts = |axis: Vec3| {
        let axis = turn * axis * level.spacing[site];
        [
            axis.cross(second).dot(normal) / doubled,
            first.cross(axis).dot(normal) / doubled,
        ]
    };
    Some([parts(frame.s), parts(frame.t)])
}
