//! Where a point or a ray meets a surface: nearest point and nearest crossing, through a bounding
//! volume hierarchy.

use glam::{Vec3, Vec3A};
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::ploc::{PlocBuilder, PlocSearchDistance, SortPrecision};

use crate::mesh::triangle_mesh::TriangleMesh;

/// A point of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// The triangle it lies in; [`NONE`](crate::mesh::topology::NONE) in [`SurfacePoint::NOWHERE`].
    pub triangle: u32,
    /// Weights of the triangle's corners; they sum to 1, none is negative.
    pub weights: [f32; 3],
    /// Where it is.
    pub position: Vec3,
}

impl SurfacePoint {
    /// No point: the parent of a vertex in no triangle.
    pub const NOWHERE: Self = Self {
        triangle: crate::mesh::topology::NONE,
        weights: [0.0; 3],
        position: Vec3::ZERO,
    };

    /// Whether this is a point at all.
    pub fn is_somewhere(&self) -> bool {
        self.triangle != Self::NOWHERE.triangle
    }
}

/// The triangles of a mesh, or any set of segments given as thin triangles, ready for queries.
pub struct SurfaceBvh {
    bvh: Bvh2,
    /// Corners in the tree's order.
    corners: Vec<[Vec3; 3]>,
}

impl SurfaceBvh {
    /// Builds the hierarchy over a mesh's triangles.
    pub fn new(mesh: &TriangleMesh) -> Self {
        let all: Vec<_> = (0..mesh.triangles.len()).map(|t| mesh.corners(t)).collect();
        Self::of_corners(&all)
    }

    /// Builds the hierarchy over triangles given by their corners.
    pub fn of_corners(all: &[[Vec3; 3]]) -> Self {
        let boxes: Vec<Aabb> = all
            .iter()
            .map(|corners| Aabb::from_points(&corners.map(Vec3A::from)))
            .collect();
        let indices = (0..all.len() as u32).collect();
        let bvh = PlocBuilder::with_capacity(all.len()).build(
            PlocSearchDistance::Low,
            &boxes,
            indices,
            SortPrecision::U64,
            1,
        );
        let corners = bvh
            .primitive_indices
            .iter()
            .map(|&t| all[t as usize])
            .collect();
        Self { bvh, corners }
    }

    /// The nearest point of the surface; `None` for an empty one. Ties go to the first met.
    pub fn nearest(&self, point: Vec3) -> Option<SurfacePoint> {
        self.nearest_accepted(point, f32::INFINITY, |_| true)
    }

    /// The nearest point on the side towards which a triangle faces, else the nearest at all.
    pub fn nearest_alike(&self, point: Vec3, [a, b, c]: &[Vec3; 3]) -> Option<SurfacePoint> {
        let normal = (b - a).cross(c - a);
        let alike = |[a, b, c]: &[Vec3; 3]| (b - a).cross(c - a).dot(normal) > 0.0;
        self.nearest_accepted(point, f32::INFINITY, alike)
            .or_else(|| self.nearest(point))
    }

    /// The nearest point closer than `reach` in a triangle that `accept` takes (given its corners).
    pub fn nearest_accepted(
        &self,
        point: Vec3,
        reach: f32,
        accept: impl Fn(&[Vec3; 3]) -> bool,
    ) -> Option<SurfacePoint> {
        // Visit the tree, the nearer box first.
        let root = self.bvh.nodes.first()?;
        let at = Vec3A::from(point);
        let mut best = (reach * reach, None);
        let mut stack: Vec<(f32, u32)> = Vec::with_capacity(64);
        stack.push((box_distance(&root.aabb, at), 0));
        while let Some((distance, index)) = stack.pop() {
            if distance >= best.0 {
                continue;
            }
            let node = &self.bvh.nodes[index as usize];
            // Try the triangles of a leaf.
            if node.prim_count > 0 {
                for slot in node.first_index..node.first_index + node.prim_count {
                    let corners = &self.corners[slot as usize];
                    let (weights, position) = nearest_in_triangle(point, corners);
                    let squared = position.distance_squared(point);
                    if squared < best.0 && accept(corners) {
                        best = (squared, Some((slot, weights, position)));
                    }
                }
            } else {
                // Put off the farther child.
                let left = node.first_index;
                let d = [left, left + 1].map(|child| {
                    (
                        box_distance(&self.bvh.nodes[child as usize].aabb, at),
                        child,
                    )
                });
                let (near, far) = if d[0].0 <= d[1].0 {
                    (d[0], d[1])
                } else {
                    (d[1], d[0])
                };
                stack.push(far);
                stack.push(near);
            }
        }
        best.1.map(|(slot, weights, position)| SurfacePoint {
            triangle: self.bvh.primitive_indices[slot as usize],
            weights,
            position,
        })
    }

    /// The crossing nearest to `origin` along the line through it, both ways, no farther than
    /// `reach`, with a triangle that faces along `direction` (unit).
    pub fn along_line(&self, origin: Vec3, direction: Vec3, reach: f32) -> Option<SurfacePoint> {
        // Visit the boxes that the line meets within reach.
        let mut best: Option<(f32, u32, [f32; 3])> = None;
        let mut stack: Vec<u32> = vec![0];
        if self.bvh.nodes.is_empty() {
            return None;
        }
        while let Some(index) = stack.pop() {
            let node = &self.bvh.nodes[index as usize];
            let limit = best.map_or(reach, |(t, ..)| t);
            if !line_meets_box(&node.aabb, origin, direction, limit) {
                continue;
            }
            if node.prim_count == 0 {
                stack.extend([node.first_index + 1, node.first_index]);
                continue;
            }
            // Try the triangles of a leaf.
            for slot in node.first_index..node.first_index + node.prim_count {
                let limit = best.map_or(reach, |(t, ..)| t);
                if let Some((t, weights)) =
                    line_crossing(origin, direction, &self.corners[slot as usize])
                    && t.abs() < limit
                {
                    best = Some((t.abs(), slot, weights));
                }
            }
        }
        best.map(|(_, slot, weights)| {
            let [a, b, c] = self.corners[slot as usize];
            SurfacePoint {
                triangle: self.bvh.primitive_indices[slot as usize],
                weights,
                position: a * weights[0] + b * weights[1] + c * weights[2],
            }
        })
    }
}

#[inline]
fn box_distance(aabb: &Aabb, point: Vec3A) -> f32 {
    let outside = (aabb.min - point).max(point - aabb.max).max(Vec3A::ZERO);
    outside.length_squared()
}

/// Whether the part of a line within `reach` of its origin comes near a box.
fn line_meets_box(aabb: &Aabb, origin: Vec3, direction: Vec3, reach: f32) -> bool {
    let (mut enter, mut leave) = (-reach, reach);
    for axis in 0..3 {
        let (low, high) = (aabb.min[axis] - origin[axis], aabb.max[axis] - origin[axis]);
        if direction[axis].abs() < 1e-12 {
            if low > 0.0 || high < 0.0 {
                return false;
            }
            continue;
        }
        let (a, b) = (low / direction[axis], high / direction[axis]);
        enter = enter.max(a.min(b));
        leave = leave.min(a.max(b));
    }
    let slack = 1e-5 * (enter.abs() + leave.abs());
    enter <= leave + slack
}

/// Where a line crosses a triangle that faces along it: signed distance and weights.
fn line_crossing(origin: Vec3, direction: Vec3, corners: &[Vec3; 3]) -> Option<(f32, [f32; 3])> {
    let [a, b, c] = corners.map(|corner| (corner - origin).as_dvec3());
    let along = direction.as_dvec3();
    let volumes = [b.cross(c), c.cross(a), a.cross(b)].map(|cross| cross.dot(along));
    let sum: f64 = volumes.iter().sum();
    if sum <= 0.0 || volumes.iter().any(|&volume| volume < -1e-9 * sum) {
        return None;
    }
    let weights = volumes.map(|volume| (volume / sum).max(0.0));
    let position = a * weights[0] + b * weights[1] + c * weights[2];
    Some((position.dot(along) as f32, weights.map(|w| w as f32)))
}

/// The nearest point of a triangle and its weights (Ericson, Real-Time Collision Detection §5.1.5).
pub fn nearest_in_triangle(point: Vec3, &[a, b, c]: &[Vec3; 3]) -> ([f32; 3], Vec3) {
    // Look beyond corner a.
    let (ab, ac, ap) = (b - a, c - a, point - a);
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return ([1.0, 0.0, 0.0], a);
    }
    // Look beyond corner b.
    let bp = point - b;
    let (d3, d4) = (ab.dot(bp), ac.dot(bp));
    if d3 >= 0.0 && d4 <= d3 {
        return ([0.0, 1.0, 0.0], b);
    }
    // Look beyond edge ab.
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        let v = d1 / (d1 - d3);
        return ([1.0 - v, v, 0.0], a + ab * v);
    }
    // Look beyond corner c.
    let cp = point - c;
    let (d5, d6) = (ab.dot(cp), ac.dot(cp));
    if d6 >= 0.0 && d5 <= d6 {
        return ([0.0, 0.0, 1.0], c);
    }
    // Look beyond edge ac.
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        let w = d2 / (d2 - d6);
        return ([1.0 - w, 0.0, w], a + ac * w);
    }
    // Look beyond edge bc.
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
        let w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return ([0.0, 1.0 - w, w], b + (c - b) * w);
    }
    // Take the point inside.
    let sum = va + vb + vc;
    let (v, w) = (vb / sum, vc / sum);
    ([1.0 - v - w, v, w], a + ab * v + ac * w)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;
    use crate::random;
    use rand::Rng;

    #[test]
    fn nearest_points_are_those_of_a_full_search() {
        let mesh = shapes::torus(20, 12, 1.0, 0.4);
        let tree = SurfaceBvh::new(&mesh);
        let mut random = random::stream(1, "tree test", 0, 0);
        for _ in 0..200 {
            let point = Vec3::from_array(std::array::from_fn(|_| random.gen_range(-2.0..2.0)));
            let slow = (0..mesh.triangles.len())
                .map(|t| {
                    nearest_in_triangle(point, &mesh.corners(t))
                        .1
                        .distance(point)
                })
                .fold(f32::INFINITY, f32::min);
            let found = tree.nearest(point).unwrap();
            assert!((found.position.distance(point) - slow).abs() < 1e-5);
            let corners = mesh.corners(found.triangle as usize);
            let sum = (0..3).map(|k| corners[k] * found.weights[k]).sum::<Vec3>();
            assert!(sum.distance(found.position) < 1e-5);
        }
    }

    #[test]
    fn lines_meet_the_side_they_leave_through() {
        let mesh = shapes::icosphere(2);
        let tree = SurfaceBvh::new(&mesh);
        let inside = Vec3::new(0.1, 0.2, 0.05);
        let hit = tree.along_line(inside, Vec3::X, 10.0).unwrap();
        assert!(hit.position.x > 0.9);
        assert!(tree.along_line(inside, Vec3::X, 0.5).is_none());
        let beyond = tree.along_line(Vec3::X * 1.5, Vec3::X, 10.0).unwrap();
        assert!((beyond.position.x - 1.0).abs() < 0.05);
    }
}
