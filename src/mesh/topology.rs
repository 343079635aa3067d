//! How triangles are connected: neighbours across edges, components, boundaries, Euler characteristic. In: an indexed
//! mesh. Out: flat arrays. Edges with more than two triangles are left unmatched and listed;
//! [`cleaning`](crate::mesh::cleaning) splits them.

use glam::Vec3;
use rayon::prelude::*;

use crate::mesh::triangle_mesh::TriangleMesh;

/// No half-edge: the edge is a boundary.
pub const NONE: u32 = u32::MAX;

/// The half-edge after another in its triangle. Half-edge 3·t + k runs from corner k of triangle
/// t to corner k + 1.
#[inline]
pub fn next(half_edge: u32) -> u32 {
    if half_edge % 3 == 2 {
        half_edge - 2
    } else {
        half_edge + 1
    }
}

/// The half-edge before another in its triangle.
#[inline]
pub fn previous(half_edge: u32) -> u32 {
    if half_edge.is_multiple_of(3) {
        half_edge + 2
    } else {
        half_edge - 1
    }
}

/// Neighbours across every edge.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Topology {
    /// Per half-edge its twin in the neighbouring triangle, [`NONE`] at a boundary.
    pub opposite: Vec<u32>,
    /// Edges (smaller vertex first) shared by more than two triangles, or by two that run along
    /// them in the same direction.
    pub non_manifold: Vec<[u32; 2]>,
}

/// What stays the same when a surface is retiled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shape {
    /// Pieces joined by shared edges or vertices.
    pub components: usize,
    /// Closed chains of boundary edges.
    pub boundaries: usize,
    /// Vertices − edges + triangles.
    pub euler_characteristic: i64,
}

/// The two ends of a half-edge, in its direction.
#[inline]
pub fn ends(triangles: &[[u32; 3]], half_edge: u32) -> [u32; 2] {
    let triangle = triangles[half_edge as usize / 3];
    let corner = half_edge as usize % 3;
    [triangle[corner], triangle[(corner + 1) % 3]]
}

impl Topology {
    /// Matches the half-edges of a mesh.
    pub fn new(triangles: &[[u32; 3]]) -> Self {
        let mut keyed = keyed_half_edges(triangles);
        keyed.par_sort_unstable();
        let mut topology = Self {
            opposite: vec![NONE; triangles.len() * 3],
            non_manifold: Vec::new(),
        };
        for group in keyed.chunk_by(|a, b| a.0 == b.0) {
            topology.match_group(triangles, group);
        }
        topology
    }

    fn match_group(&mut self, triangles: &[[u32; 3]], group: &[(u64, u32)]) {
        match *group {
            [_] => {}
            [(_, first), (_, second)]
                if ends(triangles, first)[0] != ends(triangles, second)[0] =>
            {
                self.opposite[first as usize] = second;
                self.opposite[second as usize] = first;
            }
            _ => {
                let key = group[0].0;
                self.non_manifold.push([(key >> 32) as u32, key as u32]);
            }
        }
    }

    /// The half-edges without a twin.
    pub fn boundary_half_edges(&self) -> impl Iterator<Item = u32> + '_ {
        let unmatched = |&(_, &twin): &(usize, &u32)| twin == NONE;
        let all = self.opposite.iter().enumerate();
        all.filter(unmatched).map(|(half_edge, _)| half_edge as u32)
    }

    /// Components, boundaries and Euler characteristic of a manifold mesh.
    pub fn shape(&self, mesh: &TriangleMesh) -> Shape {
        let boundary = self.boundary_half_edges().count();
        let edges = (self.opposite.len() - boundary) / 2 + boundary;
        Shape {
            components: components(mesh).1,
            boundaries: self.boundary_loops(&mesh.triangles),
            euler_characteristic: mesh.referenced_count() as i64 - edges as i64
                + mesh.triangles.len() as i64,
        }
    }

    /// Closed chains of boundary edges: each boundary vertex of a manifold mesh has one way on.
    fn boundary_loops(&self, triangles: &[[u32; 3]]) -> usize {
        let vertices = 1 + triangles.iter().flatten().max().map_or(0, |&v| v as usize);
        let mut way_on = vec![NONE; vertices];
        for half_edge in self.boundary_half_edges() {
            let [from, to] = ends(triangles, half_edge);
            way_on[from as usize] = to;
        }
        let mut loops = 0;
        for start in 0..vertices {
            let mut at = start;
            let mut walked = false;
            while way_on[at] != NONE {
                at = std::mem::replace(&mut way_on[at], NONE) as usize;
                walked = true;
            }
            loops += usize::from(walked);
        }
        loops
    }
}

fn keyed_half_edges(triangles: &[[u32; 3]]) -> Vec<(u64, u32)> {
    (0..triangles.len() as u32 * 3)
        .into_par_iter()
        .map(|half_edge| {
            let [a, b] = ends(triangles, half_edge);
            (u64::from(a.min(b)) << 32 | u64::from(a.max(b)), half_edge)
        })
        .collect()
}

/// The component of every vertex, numbered by smallest vertex ([`NONE`] for a vertex in no
/// triangle), and how many there are.
pub fn components(mesh: &TriangleMesh) -> (Vec<u32>, usize) {
    let mut root: Vec<u32> = (0..mesh.positions.len() as u32).collect();
    for &[a, b, c] in &mesh.triangles {
        join(&mut root, a, b);
        join(&mut root, b, c);
    }
    let referenced = mesh.referenced();
    let mut labels = vec![NONE; root.len()];
    let mut count = 0;
    for vertex in 0..root.len() {
        if referenced[vertex] {
            let top = find(&mut root, vertex as u32) as usize;
            if labels[top] == NONE {
                labels[top] = count;
                count += 1;
            }
            labels[vertex] = labels[top];
        }
    }
    (labels, count as usize)
}

/// The diagonal of every component's bounding box, in mesh units.
pub fn component_diagonals(mesh: &TriangleMesh) -> Vec<f32> {
    let (labels, count) = components(mesh);
    let mut boxes: Vec<Option<(Vec3, Vec3)>> = vec![None; count];
    for &vertex in mesh.triangles.iter().flatten() {
        let p = mesh.positions[vertex as usize];
        let held = &mut boxes[labels[vertex as usize] as usize];
        *held = Some(held.map_or((p, p), |(low, high)| (low.min(p), high.max(p))));
    }
    boxes
        .into_iter()
        .flatten()
        .map(|(low, high)| (high - low).length())
        .collect()
}

/// The smallest member of an element's set, shortening the way there.
pub fn find(root: &mut [u32], mut element: u32) -> u32 {
    while root[element as usize] != element {
        let above = root[root[element as usize] as usize];
        root[element as usize] = above;
        element = above;
    }
    element
}

/// Joins two sets under the smaller of their smallest members.
pub fn join(root: &mut [u32], a: u32, b: u32) {
    let (a, b) = (find(root, a), find(root, b));
    root[a.max(b) as usize] = a.min(b);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    fn shape(mesh: &TriangleMesh) -> Shape {
        Topology::new(&mesh.triangles).shape(mesh)
    }

    #[test]
    fn known_shapes_have_their_numbers() {
        let of = |components, boundaries, euler_characteristic| Shape {
            components,
            boundaries,
            euler_characteristic,
        };
        assert_eq!(shape(&shapes::grid(4, 3, 1.0)), of(1, 1, 1));
        assert_eq!(shape(&shapes::cylinder(8, 3, 1.0, 0.5)), of(1, 2, 0));
        assert_eq!(shape(&shapes::icosphere(2)), of(1, 0, 2));
        assert_eq!(shape(&shapes::torus(12, 8, 1.0, 0.4)), of(1, 0, 0));
    }

    #[test]
    fn twins_run_against_each_other() {
        let mesh = shapes::torus(12, 8, 1.0, 0.4);
        let topology = Topology::new(&mesh.triangles);
        for half_edge in 0..topology.opposite.len() as u32 {
            let twin = topology.opposite[half_edge as usize];
            assert_eq!(topology.opposite[twin as usize], half_edge);
            let [a, b] = ends(&mesh.triangles, half_edge);
            assert_eq!(ends(&mesh.triangles, twin), [b, a]);
            assert_eq!(next(next(next(half_edge))), half_edge);
            assert_eq!(previous(next(half_edge)), half_edge);
        }
    }

    #[test]
    fn edges_of_three_triangles_are_listed() {
        let fan = [[0, 1, 2], [1, 0, 3], [0, 1, 4]];
        assert_eq!(Topology::new(&fan).non_manifold, [[0, 1]]);
        let twisted = [[0, 1, 2], [0, 1, 3]];
        assert_eq!(Topology::new(&twisted).non_manifold, [[0, 1]]);
    }
}
