//! The tangent plane of every vertex, as the surface itself measures it: the edges round a vertex
//! in order, with their lengths and angles (Knöppel 2013 §3, "discrete tangent spaces").
//!
//! Angles are interior angles of the triangles, stretched at an inner vertex so that they sum to
//! 2π; at a boundary they are kept. In: a manifold mesh. Out: flat rows, and per vertex a normal
//! and an axis that fix where angle 0 points in space.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3, Vec3};
use rayon::prelude::*;

use crate::mesh::compressed_rows::Rows;
use crate::mesh::topology::{NONE, Topology, ends, previous};
use crate::mesh::triangle_mesh::TriangleMesh;

/// One edge, seen from the vertex it starts at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RingEdge {
    /// The vertex it leads to.
    pub target: u32,
    /// The triangle on its left, [`NONE`] for the last edge round a boundary vertex.
    pub triangle: u32,
    /// Its angle from the vertex's axis, counter-clockwise seen from outside, in radians.
    pub angle: f64,
    /// Its length, in mesh units.
    pub length: f32,
    /// The same edge seen from the other end: an index into the entries of all rings.
    pub reverse: u32,
}

/// The rings of all vertices and the tangent planes they lie in.
#[derive(Clone, Debug, PartialEq)]
pub struct Rings {
    /// Per vertex its edges, counter-clockwise; empty for a vertex in no triangle.
    pub edges: Rows<RingEdge>,
    /// Unit normals, (0, 0, 1) for a vertex in no triangle.
    pub normals: Vec<Vec3>,
    /// Unit tangents at angle 0, (1, 0, 0) for a vertex in no triangle.
    pub axes: Vec<Vec3>,
    /// Whether a vertex lies on a boundary (or in no triangle).
    pub boundary: Vec<bool>,
}

impl Rings {
    /// Walks round every vertex of a manifold mesh.
    pub fn new(mesh: &TriangleMesh, topology: &Topology) -> Self {
        let first = first_half_edges(mesh, topology);
        let mut edges = Rows::collect(
            mesh.positions.len(),
            || (),
            |(), vertex, ring| walk(mesh, topology, first[vertex], vertex, ring),
        );
        let normals = vertex_normals(mesh);
        let axes: Vec<Vec3> = (0..normals.len())
            .into_par_iter()
            .map(|vertex| axis(mesh, normals[vertex], vertex, edges.row(vertex)))
            .collect();
        link_reverse(&mut edges);
        let boundary = (0..edges.len())
            .map(|vertex| edges.row(vertex).last().is_none_or(|e| e.triangle == NONE))
            .collect();
        Self {
            edges,
            normals,
            axes,
            boundary,
        }
    }

    /// The tangent at an angle from a vertex's axis.
    pub fn direction(&self, vertex: usize, angle: f64) -> Vec3 {
        let (sin, cos) = angle.sin_cos();
        let (n, axis) = (self.normals[vertex], self.axes[vertex]);
        axis * cos as f32 + n.cross(axis) * sin as f32
    }

    /// The angle of a direction in space projected on a vertex's tangent plane; `None` when it
    /// stands on it.
    pub fn angle_of(&self, vertex: usize, direction: Vec3) -> Option<f64> {
        let (n, axis) = (
            self.normals[vertex].as_dvec3(),
            self.axes[vertex].as_dvec3(),
        );
        let unit = direction.as_dvec3().try_normalize()?;
        let (x, y) = (unit.dot(axis), unit.dot(n.cross(axis)));
        (x.hypot(y) > 1e-4).then(|| y.atan2(x))
    }

    /// The rotation that carries vectors from the tangent plane at an edge's far end into the one
    /// at its start, in radians.
    #[inline]
    pub fn transport(&self, entry: usize) -> f64 {
        let edge = self.edges.entries[entry];
        let reverse = self.edges.entries[edge.reverse as usize];
        edge.angle - reverse.angle - std::f64::consts::PI
    }
}

/// Where the walk round each vertex starts: the boundary edge with the surface on its left, or
/// the first half-edge that leaves it.
fn first_half_edges(mesh: &TriangleMesh, topology: &Topology) -> Vec<u32> {
    let mut first = vec![NONE; mesh.positions.len()];
    for half_edge in 0..mesh.triangles.len() as u32 * 3 {
        let [from, _] = ends(&mesh.triangles, half_edge);
        let held = &mut first[from as usize];
        if *held == NONE || topology.opposite[half_edge as usize] == NONE {
            *held = half_edge;
        }
    }
    first
}

fn walk(
    mesh: &TriangleMesh,
    topology: &Topology,
    first: u32,
    vertex: usize,
    ring: &mut Vec<RingEdge>,
) {
    if first == NONE {
        return;
    }
    // Walk round the vertex until a border or the first edge.
    let begin = ring.len();
    let origin = mesh.positions[vertex].as_dvec3();
    let arm = |target: u32| mesh.positions[target as usize].as_dvec3() - origin;
    let (mut half_edge, mut angle) = (first, 0.0);
    let closed = loop {
        let target = ends(&mesh.triangles, half_edge)[1];
        let back = previous(half_edge);
        let far = ends(&mesh.triangles, back)[0];
        ring.push(ring_edge(target, half_edge / 3, angle, arm(target)));
        angle += angle_between(arm(target), arm(far));
        match topology.opposite[back as usize] {
            NONE => {
                ring.push(ring_edge(far, NONE, angle, arm(far)));
                break false;
            }
            onward if onward == first => break true,
            onward => half_edge = onward,
        }
    };
    // Stretch the angles of a closed ring to a full turn.
    if closed && angle > 0.0 {
        let stretch = TAU / angle;
        ring[begin..].iter_mut().for_each(|e| e.angle *= stretch);
    }
}

fn ring_edge(target: u32, triangle: u32, angle: f64, arm: DVec3) -> RingEdge {
    RingEdge {
        target,
        triangle,
        angle,
        length: arm.length() as f32,
        reverse: NONE,
    }
}

/// The angle between two vectors, exact near 0 and π (Kahan).
pub fn angle_between(a: DVec3, b: DVec3) -> f64 {
    a.cross(b).length().atan2(a.dot(b))
}

/// Chooses an axis in the tangent plane and turns the ring's angles so that, on average over its edges, an edge's
/// angle is that of its projection.
fn axis(mesh: &TriangleMesh, normal: Vec3, vertex: usize, ring: &[RingEdge]) -> Vec3 {
    if ring.is_empty() {
        return Vec3::X;
    }
    let n = normal.as_dvec3();
    let guess = n.any_orthonormal_vector();
    let (x, y) = (guess, n.cross(guess));
    let origin = mesh.positions[vertex].as_dvec3();
    let mut sum = DVec2::ZERO;
    for edge in ring {
        let arm = mesh.positions[edge.target as usize].as_dvec3() - origin;
        let projected = DVec2::new(arm.dot(x), arm.dot(y));
        sum += DVec2::from_angle(-edge.angle).rotate(projected);
    }
    let turned = sum.try_normalize().unwrap_or(DVec2::X);
    (x * turned.x + y * turned.y).normalize().as_vec3()
}

fn link_reverse(edges: &mut Rows<RingEdge>) {
    let reverse: Vec<u32> = (0..edges.len())
        .into_par_iter()
        .flat_map_iter(|vertex| {
            let edges = &*edges;
            edges.row(vertex).iter().map(move |edge| {
                let far = edge.target as usize;
                let place = edges
                    .row(far)
                    .iter()
                    .position(|e| e.target == vertex as u32);
                place.map_or(NONE, |place| edges.starts[far] + place as u32)
            })
        })
        .collect();
    for (edge, reverse) in edges.entries.iter_mut().zip(reverse) {
        edge.reverse = reverse;
    }
}

/// Unit normals, triangles weighted by their angle at the vertex; (0, 0, 1) for a vertex in no
/// triangle.
pub fn vertex_normals(mesh: &TriangleMesh) -> Vec<Vec3> {
    let weighted: Vec<[DVec3; 3]> = (0..mesh.triangles.len())
        .into_par_iter()
        .map(|triangle| corner_normals(mesh, triangle))
        .collect();
    let mut sums = vec![DVec3::ZERO; mesh.positions.len()];
    for (triangle, normals) in mesh.triangles.iter().zip(&weighted) {
        for (&vertex, &normal) in triangle.iter().zip(normals) {
            sums[vertex as usize] += normal;
        }
    }
    let unit = |sum: DVec3| {
        sum.try_normalize()
            .unwrap_or(DVec3::Z)
            .as_vec3()
            .normalize()
    };
    sums.into_par_iter().map(unit).collect()
}

fn corner_normals(mesh: &TriangleMesh, triangle: usize) -> [DVec3; 3] {
    let [a, b, c] = mesh.corners(triangle).map(Vec3::as_dvec3);
    let normal = (b - a).cross(c - a).normalize_or_zero();
    [
        normal * angle_between(b - a, c - a),
        normal * angle_between(c - b, a - b),
        normal * angle_between(a - c, b - c),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    fn rings(mesh: &TriangleMesh) -> Rings {
        Rings::new(mesh, &Topology::new(&mesh.triangles))
    }

    #[test]
    fn a_flat_ring_measures_as_the_plane_does() {
        let rings = rings(&shapes::grid(4, 4, 1.0));
        let centre = 12;
        assert_eq!(rings.normals[centre], Vec3::Z);
        assert_eq!(rings.edges.row(centre).len(), 6);
        let mesh = shapes::grid(4, 4, 1.0);
        for vertex in 0..25 {
            for edge in rings.edges.row(vertex) {
                let arm = mesh.positions[edge.target as usize] - mesh.positions[vertex];
                let along = rings.direction(vertex, edge.angle) * edge.length;
                assert!((arm - along).length() < 1e-5, "{vertex} {edge:?}");
            }
        }
    }

    #[test]
    fn transport_there_and_back_is_no_rotation() {
        let rings = rings(&shapes::torus(12, 9, 1.0, 0.4));
        for entry in 0..rings.edges.entries.len() {
            let reverse = rings.edges.entries[entry].reverse as usize;
            let turn = rings.transport(entry) + rings.transport(reverse);
            assert!((turn / TAU - (turn / TAU).round()).abs() < 1e-9);
        }
    }

    #[test]
    fn normals_of_a_sphere_are_radial() {
        let mesh = shapes::icosphere(3);
        let rings = rings(&mesh);
        for (n, p) in rings.normals.iter().zip(&mesh.positions) {
            assert!(n.dot(*p) > 0.999);
        }
        assert!(rings.boundary.iter().all(|&b| !b));
    }

    #[test]
    fn angles_and_directions_are_inverse() {
        let rings = rings(&shapes::icosphere(1));
        for vertex in 0..rings.normals.len() {
            let angle = rings
                .angle_of(vertex, rings.direction(vertex, 0.7))
                .unwrap();
            assert!((angle - 0.7).abs() < 1e-5);
            assert_eq!(rings.angle_of(vertex, rings.normals[vertex]), None);
        }
    }
}
