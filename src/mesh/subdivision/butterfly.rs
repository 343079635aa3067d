//! Modified butterfly subdivision of triangle meshes (Zorin, Schröder and Sweldens 1996).
//!
//! Every edge gets a vertex and every triangle becomes four. Vertices are neither moved nor renumbered; the limit
//! surface has continuous tangent planes.
//!
//! Triangle t with corners a, b, c becomes 4·t … 4·t + 3: `[a, ab, ca]`, `[ab, b, bc]`, `[ca, bc, c]` and the centre
//! `[ab, bc, ca]`, where ab is the vertex of edge ab. So child k has corner k of its parent as its own corner k.

use glam::DVec3;
use rayon::prelude::*;

use crate::mesh::face_colors::edge_vertices;
use crate::mesh::topology::{NONE, Topology, ends, next, previous};
use crate::mesh::triangle_mesh::TriangleMesh;

/// Children of a triangle; the last is the centre.
pub const CHILDREN: u32 = 4;
/// The cosine of the angle by which a boundary turns at a corner, at most (75°).
const CORNER_COSINE: f64 = 0.258_819_045_102_520_74;

/// A manifold mesh subdivided once.
///
/// - An inner edge between vertices of valence six has the eight-point rule: ½ for its ends, ⅛ for the two vertices
///   opposite, −1/16 for the four beyond.
/// - An end that is inside the surface and has another valence has a rule of its own ring (their §3); two such ends
///   are averaged.
/// - A boundary edge has the four-point rule along the boundary: 9/16 and −1/16.
///
/// Deviation: their rules leave open what stands for points beyond the boundary. They are reflected at the edge's
/// middle, so that planes stay planes. Where a boundary turns by more than 75° it has a corner, and the point beyond is
/// reflected at it, so that straight borders stay straight.
pub fn butterfly(mesh: &TriangleMesh, topology: &Topology) -> TriangleMesh {
    let stencils = Stencils::new(mesh, topology);
    let numbers = edge_vertices(topology, mesh.positions.len() as u32);
    let edges: Vec<u32> = (0..topology.opposite.len() as u32)
        .filter(|&half_edge| half_edge < topology.opposite[half_edge as usize])
        .collect();
    let mut positions = mesh.positions.clone();
    positions.par_extend(
        edges
            .par_iter()
            .map(|&half_edge| stencils.edge_point(half_edge).as_vec3()),
    );
    TriangleMesh {
        positions,
        triangles: quartered(mesh, &numbers),
    }
}

fn quartered(mesh: &TriangleMesh, middles: &[u32]) -> Vec<[u32; 3]> {
    let children = |triangle: usize| {
        let [a, b, c] = mesh.triangles[triangle];
        let [ab, bc, ca] = [0, 1, 2].map(|edge| middles[3 * triangle + edge]);
        [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
    };
    let triangles = (0..mesh.triangles.len()).into_par_iter();
    triangles.flat_map_iter(children).collect()
}

/// The colours of the children: the centre has its parent's, the outer three have the other (Castellanos and Williams
/// §3.5).
pub fn inherited_colors(white: &[bool]) -> Vec<bool> {
    let of_children = |&white: &bool| [!white, !white, !white, white];
    white.iter().flat_map(of_children).collect()
}

struct Stencils<'a> {
    mesh: &'a TriangleMesh,
    topology: &'a Topology,
    /// Per vertex, its valence if it is inside the surface and the valence is not six, else 0.
    irregular: Vec<u32>,
    /// Per vertex the boundary half-edge that leaves it, and the one that reaches it.
    boundary: Vec<[u32; 2]>,
}

impl<'a> Stencils<'a> {
    fn new(mesh: &'a TriangleMesh, topology: &'a Topology) -> Self {
        let count = mesh.positions.len();
        let mut irregular = vec![0; count];
        for &vertex in mesh.triangles.iter().flatten() {
            irregular[vertex as usize] += 1;
        }
        let mut boundary = vec![[NONE; 2]; count];
        for half_edge in topology.boundary_half_edges() {
            let [from, to] = ends(&mesh.triangles, half_edge);
            boundary[from as usize][0] = half_edge;
            boundary[to as usize][1] = half_edge;
        }
        for (valence, boundary) in irregular.iter_mut().zip(&boundary) {
            if boundary[0] != NONE || *valence == 6 {
                *valence = 0;
            }
        }
        Self {
            mesh,
            topology,
            irregular,
            boundary,
        }
    }

    fn twin(&self, half_edge: u32) -> u32 {
        self.topology.opposite[half_edge as usize]
    }

    fn position(&self, vertex: u32) -> DVec3 {
        self.mesh.positions[vertex as usize].as_dvec3()
    }

    /// The two ends of a half-edge.
    fn edge(&self, half_edge: u32) -> [DVec3; 2] {
        ends(&self.mesh.triangles, half_edge).map(|vertex| self.position(vertex))
    }

    /// The vertex of a triangle that is not on a half-edge of it.
    fn apex(&self, half_edge: u32) -> DVec3 {
        self.edge(next(half_edge))[1]
    }

    /// The vertex beyond a half-edge, reflected at its middle where the surface ends.
    fn beyond(&self, half_edge: u32) -> DVec3 {
        match self.twin(half_edge) {
            NONE => {
                let [a, b] = self.edge(half_edge);
                a + b - self.apex(half_edge)
            }
            twin => self.apex(twin),
        }
    }

    fn edge_point(&self, half_edge: u32) -> DVec3 {
        let twin = self.twin(half_edge);
        if twin == NONE {
            return self.boundary_point(half_edge);
        }
        let ends = ends(&self.mesh.triangles, half_edge);
        let irregular = ends.map(|vertex| self.irregular[vertex as usize]);
        match irregular {
            [0, 0] => self.regular_point(half_edge, twin),
            [valence, 0] => self.irregular_point(half_edge, valence),
            [0, valence] => self.irregular_point(twin, valence),
            [one, other] => {
                let point = self.irregular_point(half_edge, one);
                point.midpoint(self.irregular_point(twin, other))
            }
        }
    }

    fn regular_point(&self, half_edge: u32, twin: u32) -> DVec3 {
        let [a, b] = self.edge(half_edge);
        let opposite = self.apex(half_edge) + self.apex(twin);
        let wings: DVec3 = [half_edge, twin]
            .into_iter()
            .map(|side| self.beyond(next(side)) + self.beyond(previous(side)))
            .sum();
        (a + b) / 2.0 + opposite / 8.0 - wings / 16.0
    }

    /// The rule of the vertex at which a half-edge starts, inside the surface and of any valence.
    fn irregular_point(&self, half_edge: u32, valence: u32) -> DVec3 {
        let [center, _] = self.edge(half_edge);
        let (mut spoke, mut point) = (half_edge, 0.75 * center);
        for step in 0..valence {
            point += ring_weight(valence, step) * self.edge(spoke)[1];
            spoke = self.twin(previous(spoke));
        }
        point
    }

    fn boundary_point(&self, half_edge: u32) -> DVec3 {
        let [from, to] = ends(&self.mesh.triangles, half_edge);
        let [a, b] = self.edge(half_edge);
        let before = self.edge(self.boundary[from as usize][1])[0];
        let after = self.edge(self.boundary[to as usize][0])[1];
        let before = past_corner(before, a, b);
        let after = past_corner(after, b, a);
        (9.0 * (a + b) - before - after) / 16.0
    }
}

/// The point before `at` on a boundary that continues to `on`, reflected where `at` is a corner.
fn past_corner(before: DVec3, at: DVec3, on: DVec3) -> DVec3 {
    let cosine = (at - before)
        .normalize_or_zero()
        .dot((on - at).normalize_or_zero());
    match cosine < CORNER_COSINE {
        true => 2.0 * at - on,
        false => before,
    }
}

/// The weight of the neighbour `step` edges round from the one that the new vertex lies towards.
fn ring_weight(valence: u32, step: u32) -> f64 {
    match (valence, step) {
        (3, 0) => 5.0 / 12.0,
        (3, _) => -1.0 / 12.0,
        (4, 0) => 3.0 / 8.0,
        (4, 2) => -1.0 / 8.0,
        (4, _) => 0.0,
        _ => {
            let angle = f64::from(step) / f64::from(valence) * std::f64::consts::TAU;
            (0.25 + angle.cos() + 0.5 * (2.0 * angle).cos()) / f64::from(valence)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;
    use glam::Vec3;

    fn subdivided(mesh: &TriangleMesh) -> TriangleMesh {
        butterfly(mesh, &Topology::new(&mesh.triangles))
    }

    #[test]
    fn weights_sum_to_one() {
        for valence in 3..12 {
            let ring: f64 = (0..valence).map(|step| ring_weight(valence, step)).sum();
            assert!((ring - 0.25).abs() < 1e-12, "{valence}");
        }
    }

    #[test]
    fn quadratics_on_a_lattice_are_kept_inside_and_planes_everywhere() {
        // On an affine lattice the vertex at (x, y) has height q(x, y).
        let lattice = |height: &dyn Fn(f32, f32) -> f32| {
            let mut mesh = shapes::grid(8, 8, 1.0);
            for p in &mut mesh.positions {
                p.z = height(p.x, p.y);
            }
            mesh
        };
        let quadratic = |x: f32, y: f32| 0.5 * x * x - 0.25 * x * y + y * y - 3.0 * x + 1.0;
        let curved = subdivided(&lattice(&quadratic));
        let inside = |p: &&Vec3| {
            p.truncate().cmpgt(glam::Vec2::splat(1.9)).all()
                && p.truncate().cmplt(glam::Vec2::splat(6.1)).all()
        };
        let inner: Vec<&Vec3> = curved.positions.iter().filter(inside).collect();
        assert_eq!(inner.len(), 81);
        for p in inner {
            assert!((p.z - quadratic(p.x, p.y)).abs() < 1e-5, "{p}");
            assert_eq!((p.x * 2.0).fract(), 0.0);
        }
        let plane = |x: f32, y: f32| 0.5 * x - 0.25 * y + 2.0;
        let flat = subdivided(&lattice(&plane));
        for p in &flat.positions {
            assert!((p.z - plane(p.x, p.y)).abs() < 1e-6);
            assert!((p.x * 2.0 - (p.x * 2.0).round()).abs() < 1e-5, "{p}");
        }
    }

    #[test]
    fn children_lie_in_their_parents_and_keep_corners() {
        let mesh = shapes::icosphere(1);
        let (once, middles) = (subdivided(&mesh), shapes::midpoints(&mesh));
        assert_eq!(once.triangles.len(), 4 * mesh.triangles.len());
        assert_eq!(once.positions[..mesh.positions.len()], mesh.positions);
        for (parent, corners) in mesh.triangles.iter().enumerate() {
            for (at, corner) in corners.iter().enumerate() {
                assert_eq!(once.triangles[4 * parent + at][at], *corner);
            }
        }
        for triangle in 0..once.triangles.len() {
            let apart = once.corners(triangle)[0].distance(middles.corners(triangle)[0]);
            assert!(apart < 0.1);
        }
        let radius = |p: &Vec3| (p.length() - 1.0).abs();
        assert!(once.positions.iter().map(radius).fold(0.0, f32::max) < 0.02);
        let twice = subdivided(&once);
        assert_eq!(twice.triangles.len(), 16 * mesh.triangles.len());
        assert_eq!(
            Topology::new(&twice.triangles)
                .shape(&twice)
                .euler_characteristic,
            2
        );
    }

    #[test]
    fn children_inherit_proper_colors() {
        let mesh = shapes::torus(6, 4, 1.0, 0.4);
        let topology = Topology::new(&mesh.triangles);
        let white = crate::mesh::face_colors::two_coloring(&topology).unwrap();
        let once = subdivided(&mesh);
        let inherited = inherited_colors(&white);
        let topology = Topology::new(&once.triangles);
        for (half_edge, &twin) in topology.opposite.iter().enumerate() {
            assert_ne!(inherited[half_edge / 3], inherited[twin as usize / 3]);
        }
        for (parent, &white) in white.iter().enumerate() {
            assert_eq!(inherited[4 * parent + 3], white);
        }
    }

    #[test]
    fn round_boundaries_are_rounded() {
        let ring = shapes::cylinder(16, 4, 1.0, 0.4);
        for p in &subdivided(&ring).positions {
            assert!((p.truncate().length() - 1.0).abs() < 3e-3, "{p}");
            assert!((-1e-6..=1.6 + 1e-6).contains(&p.z));
        }
    }
}
