//! An indexed triangle mesh: positions in mesh units, triangles counter-clockwise seen from outside.

use glam::Vec3;

/// Positions and triangles; everything else is derived from them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriangleMesh {
    /// Vertex positions, in mesh units, in the user's order.
    pub positions: Vec<Vec3>,
    /// Vertex indices of each triangle, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
}

impl TriangleMesh {
    /// The corners of a triangle.
    pub fn corners(&self, triangle: usize) -> [Vec3; 3] {
        self.triangles[triangle].map(|v| self.positions[v as usize])
    }

    /// Twice the area of a triangle times its unit normal.
    pub fn area_normal(&self, triangle: usize) -> Vec3 {
        let [a, b, c] = self.corners(triangle);
        (b - a).cross(c - a)
    }

    /// The surface's area, in mesh units squared.
    pub fn area(&self) -> f64 {
        (0..self.triangles.len())
            .map(|t| 0.5 * f64::from(self.area_normal(t).length()))
            .sum()
    }
}
