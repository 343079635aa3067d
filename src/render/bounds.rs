//! The space a mesh fills: where cameras look, how near they may draw, what "far" means.

use glam::DVec3;

use crate::error::{Error, Result};
use crate::mesh::triangle_mesh::TriangleMesh;

/// The box of a mesh's triangles and the sphere round its centre that holds them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// The box's smallest corner.
    pub low: DVec3,
    /// The box's largest corner.
    pub high: DVec3,
    /// The box's centre.
    pub centre: DVec3,
    /// The largest distance of a vertex from the centre.
    pub radius: f64,
}

/// The corners of all triangles, shared ones more than once.
pub fn used_points(mesh: &TriangleMesh) -> impl Iterator<Item = DVec3> + '_ {
    let corners = mesh.triangles.iter().flatten();
    corners.map(|&v| mesh.positions[v as usize].as_dvec3())
}

impl Bounds {
    /// Vertices that no triangle uses do not count; a mesh without triangles has no bounds.
    pub fn of(mesh: &TriangleMesh) -> Result<Self> {
        let used = || used_points(mesh);
        if mesh.triangles.is_empty() {
            return Err(Error::data("mesh", "no triangle").expected("at least one"));
        }
        let (low, high) = used().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| {
            (low.min(p), high.max(p))
        });
        let centre = (low + high) * 0.5;
        let radius = used().map(|p| (p - centre).length()).fold(0.0, f64::max);
        if !radius.is_finite() || radius == 0.0 {
            return Err(Error::data("mesh", format!("a radius of {radius}"))
                .expected("a surface with an extent"));
        }
        Ok(Self {
            low,
            high,
            centre,
            radius,
        })
    }

    /// The depth in front of which nothing is drawn.
    pub fn nearest(&self) -> f64 {
        1e-5 * self.radius
    }

    /// Whether a point lies in the box.
    pub fn contain(&self, point: DVec3) -> bool {
        point.cmpge(self.low).all() && point.cmple(self.high).all()
    }
}
