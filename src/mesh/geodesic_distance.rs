//! Geodesic distances from a vertex of a surface to all others: a front that advances triangle by triangle
//! (fast marching, Kimmel and Sethian 1998).
//!
//! A vertex is reached through a triangle from the two others as if the front came from one point: the triangle
//! and that point are drawn in the plane (Novotni and Klein 2002). On a flat surface distances are exact. A vertex
//! whose distance falls is visited again, so that obtuse triangles need no special treatment.

use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;

use glam::DVec2;

use crate::mesh::rings::Rings;
use crate::mesh::topology::NONE;
use crate::mesh::triangle_mesh::TriangleMesh;

/// A distance counts as shorter from this share of it on.
const LEAST_GAIN: f64 = 1e-7;

/// A surface on which distances are measured.
#[derive(Clone, Copy, Debug)]
pub struct GeodesicDistances<'a> {
    /// The surface.
    pub mesh: &'a TriangleMesh,
    /// The edges and triangles round every vertex.
    pub rings: &'a Rings,
}

/// A vertex in the front, the nearest first.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Reached {
    distance: f64,
    vertex: u32,
}

impl Eq for Reached {}

impl Ord for Reached {
    fn cmp(&self, other: &Self) -> Ordering {
        let by_distance = self.distance.total_cmp(&other.distance);
        by_distance.then(self.vertex.cmp(&other.vertex))
    }
}

impl PartialOrd for Reached {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl GeodesicDistances<'_> {
    /// The distances of all vertices from one, in mesh units; infinite on other components.
    pub fn from_vertex(&self, vertex: u32) -> Vec<f64> {
        let mut front = Front {
            surface: *self,
            distances: vec![f64::INFINITY; self.mesh.positions.len()],
            heap: BinaryHeap::new(),
        };
        front.reach(vertex, 0.0);
        while let Some(Reverse(reached)) = front.heap.pop() {
            if reached.distance == front.distances[reached.vertex as usize] {
                front.go_on_from(reached.vertex);
            }
        }
        front.distances
    }
}

/// A front on its way.
struct Front<'a> {
    surface: GeodesicDistances<'a>,
    distances: Vec<f64>,
    heap: BinaryHeap<Reverse<Reached>>,
}

impl Front<'_> {
    /// Notes that a vertex is so near.
    fn reach(&mut self, vertex: u32, distance: f64) {
        let known = &mut self.distances[vertex as usize];
        if distance < *known * (1.0 - LEAST_GAIN) || known.is_infinite() {
            *known = distance;
            self.heap.push(Reverse(Reached { distance, vertex }));
        }
    }

    /// Reaches the other corners of the triangles round a vertex.
    fn go_on_from(&mut self, vertex: u32) {
        let surface = self.surface;
        let edges = surface.rings.edges.row(vertex as usize).iter();
        for edge in edges.filter(|edge| edge.triangle != NONE) {
            let corners = surface.mesh.triangles[edge.triangle as usize];
            for wanted in corners.into_iter().filter(|&corner| corner != vertex) {
                let other = corners.into_iter().find(|&c| c != vertex && c != wanted);
                let distance = self.across(vertex, other.unwrap_or(vertex), wanted);
                self.reach(wanted, distance);
            }
        }
    }

    /// The distance of a triangle's corner c through its corners a and b.
    fn across(&self, a: u32, b: u32, c: u32) -> f64 {
        let at = |vertex: u32| self.surface.mesh.positions[vertex as usize].as_dvec3();
        let (along, to_c) = (at(b) - at(a), at(c) - at(a));
        let [from_a, from_b] = [a, b].map(|vertex| self.distances[vertex as usize]);
        let by_edges = (from_a + to_c.length()).min(from_b + (at(c) - at(b)).length());
        if from_b.is_infinite() {
            return by_edges;
        }
        let side = along.length();
        let beside = (from_a.powi(2) + side.powi(2) - from_b.powi(2)) / (2.0 * side);
        let below = from_a.powi(2) - beside.powi(2);
        if !(below >= 0.0 && side > 0.0) {
            return by_edges;
        }
        let source = DVec2::new(beside, -below.sqrt());
        let height = along.cross(to_c).length() / side;
        let target = DVec2::new(along.dot(to_c) / side, height);
        // Where the line from the source to c crosses ab.
        let crossing = source.x + (target.x - source.x) * (-source.y / (target.y - source.y));
        match (0.0..=side).contains(&crossing) {
            true => source.distance(target).min(by_edges),
            false => by_edges,
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::mesh::shapes;
    use crate::mesh::topology::Topology;

    fn distances(mesh: &TriangleMesh, vertex: u32) -> Vec<f64> {
        let rings = Rings::new(mesh, &Topology::new(&mesh.triangles));
        GeodesicDistances {
            mesh,
            rings: &rings,
        }
        .from_vertex(vertex)
    }

    #[test]
    fn distances_in_the_plane_are_straight_whatever_the_triangles() {
        for stretch in [1.0, 4.0] {
            let mut mesh = shapes::grid(17, 13, 0.25);
            for p in &mut mesh.positions {
                *p = Vec3::new(p.x * stretch, p.y, 0.0);
            }
            let from = 100;
            let position = mesh.positions[from as usize];
            let found = distances(&mesh, from);
            for (p, found) in mesh.positions.iter().zip(found) {
                let straight = f64::from(p.distance(position));
                assert!(
                    (found - straight).abs() < 1e-4 * straight.max(0.1),
                    "{found} {straight}"
                );
            }
        }
    }

    #[test]
    fn distances_on_a_sphere_are_arcs() {
        let mesh = shapes::icosphere(5);
        let found = distances(&mesh, 7);
        let pole = mesh.positions[7];
        for (p, found) in mesh.positions.iter().zip(found) {
            let arc = f64::from(p.angle_between(pole));
            assert!((found - arc).abs() < 0.01 * arc + 1e-6, "{found} {arc}");
        }
    }

    #[test]
    fn distances_on_a_cylinder_unroll() {
        let mesh = shapes::cylinder(96, 40, 1.0, 0.0654);
        let from = 20 * 96;
        let found = distances(&mesh, from);
        let source = mesh.positions[from as usize];
        let angle = |p: Vec3| p.y.atan2(p.x);
        for (p, found) in mesh.positions.iter().zip(found) {
            let turn = (angle(*p) - angle(source)).abs();
            let turn = turn.min(std::f32::consts::TAU - turn);
            let expected = f64::from(turn.hypot(p.z - source.z));
            assert!(
                (found - expected).abs() < 0.005 * expected + 1e-4,
                "{found} {expected}"
            );
        }
    }

    #[test]
    fn other_components_are_out_of_reach() {
        let mut mesh = shapes::icosphere(1);
        let count = mesh.positions.len();
        let other = mesh.triangles.iter().map(|t| t.map(|v| v + count as u32));
        mesh.triangles.extend(other.collect::<Vec<_>>());
        mesh.positions.extend(mesh.positions.clone());
        let found = distances(&mesh, 0);
        assert!(found[..count].iter().all(|d| d.is_finite()));
        assert!(found[count..].iter().all(|d| d.is_infinite()));
    }
}
