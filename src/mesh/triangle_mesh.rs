//! An indexed triangle mesh: positions in mesh units, triangles counter-clockwise seen from outside.

use glam::{DVec3, Vec3};

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
    #[inline]
    pub fn corners(&self, triangle: usize) -> [Vec3; 3] {
        let [a, b, c] = self.triangles[triangle];
        let corner = |v: u32| self.positions[v as usize];
        [corner(a), corner(b), corner(c)]
    }

    /// Twice the area of a triangle times its unit normal.
    pub fn area_normal(&self, triangle: usize) -> Vec3 {
        let [a, b, c] = self.corners(triangle);
        (b - a).cross(c - a)
    }

    /// Twice the area of a triangle times its unit normal, in double precision.
    pub fn area_normal_f64(&self, triangle: usize) -> DVec3 {
        let [a, b, c] = self.corners(triangle).map(Vec3::as_dvec3);
        (b - a).cross(c - a)
    }

    /// The surface's area, in mesh units squared.
    pub fn area(&self) -> f64 {
        (0..self.triangles.len())
            .map(|t| 0.5 * self.area_normal_f64(t).length())
            .sum()
    }

    /// The volume that the triangles enclose, in mesh units cubed; negative where they face inwards. Means
    /// something for a closed surface alone.
    pub fn volume(&self) -> f64 {
        let reference = self.bounds().0.as_dvec3();
        (0..self.triangles.len())
            .map(|t| {
                let [a, b, c] = self.corners(t).map(|corner| corner.as_dvec3() - reference);
                a.dot(b.cross(c)) / 6.0
            })
            .sum()
    }

    /// Which vertices stand in a triangle.
    pub fn referenced(&self) -> Vec<bool> {
        let mut referenced = vec![false; self.positions.len()];
        for &vertex in self.triangles.iter().flatten() {
            referenced[vertex as usize] = true;
        }
        referenced
    }

    /// How many vertices stand in a triangle.
    pub fn referenced_count(&self) -> usize {
        self.referenced().into_iter().filter(|&yes| yes).count()
    }

    /// Lower and upper corner of the box round all referenced vertices; zeros for no triangle.
    pub fn bounds(&self) -> (Vec3, Vec3) {
        let corners = self.triangles.iter().flatten();
        let mut points = corners.map(|&v| self.positions[v as usize]);
        let Some(first) = points.next() else {
            return (Vec3::ZERO, Vec3::ZERO);
        };
        points.fold((first, first), |(low, high), p| (low.min(p), high.max(p)))
    }

    /// The diagonal of the bounding box, in mesh units.
    pub fn diagonal(&self) -> f32 {
        let (low, high) = self.bounds();
        (high - low).length()
    }

    /// A third of the area of the triangles round each vertex: the surface it stands for.
    pub fn vertex_areas(&self) -> Vec<f32> {
        let mut areas = vec![0.0f64; self.positions.len()];
        for (index, triangle) in self.triangles.iter().enumerate() {
            let share = self.area_normal_f64(index).length() / 6.0;
            for &vertex in triangle {
                areas[vertex as usize] += share;
            }
        }
        areas.into_iter().map(|area| area as f32).collect()
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn areas_sum_to_the_surface() {
        let mesh = crate::mesh::shapes::grid(4, 3, 0.5);
        assert!((mesh.area() - 3.0).abs() < 1e-6);
        let sum: f32 = mesh.vertex_areas().iter().sum();
        assert!((sum - 3.0).abs() < 1e-5);
        let ball = crate::mesh::shapes::icosphere(4);
        let full = 4.0 / 3.0 * std::f64::consts::PI;
        assert!((ball.volume() / full - 1.0).abs() < 0.01);
        assert_eq!(mesh.referenced_count(), 20);
        assert!((mesh.diagonal() - 2.5).abs() < 1e-6);
    }
}
