//! A triangle mesh whose edges can be split, collapsed and flipped in place.
//!
//! Half-edge 3·t + k runs from corner k of triangle t to corner k + 1. Every operation keeps the
//! surface's topology (components, boundaries, genus); one that would not is refused.

use glam::Vec3;

use crate::mesh::topology::{NONE, Topology, ends, next, previous};
use crate::mesh::triangle_mesh::TriangleMesh;

/// How free a vertex is to move.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Freedom {
    /// Anywhere on the surface.
    Surface,
    /// Along a boundary or crease.
    Line,
    /// Not at all: the end or meeting of lines.
    Fixed,
}

/// A mesh that is being edited.
#[derive(Clone, Debug)]
pub struct EditMesh {
    /// Vertex positions; those of removed vertices linger.
    pub positions: Vec<Vec3>,
    /// Triangles; a removed one is `[NONE; 3]`.
    pub triangles: Vec<[u32; 3]>,
    /// Twins of half-edges.
    pub opposite: Vec<u32>,
    /// Half-edges on a boundary or crease.
    pub sharp: Vec<bool>,
    /// Per vertex a half-edge that leaves it; [`NONE`] for a vertex removed or in no triangle.
    pub leaving: Vec<u32>,
    /// Per vertex its freedom.
    pub freedom: Vec<Freedom>,
    vertices: usize,
}

impl EditMesh {
    /// Opens a manifold mesh; `sharp` says which half-edges are creases (boundaries are added).
    pub fn new(mesh: &TriangleMesh, sharp: Vec<bool>, freedom: Vec<Freedom>) -> Self {
        let topology = Topology::new(&mesh.triangles);
        let mut leaving = vec![NONE; mesh.positions.len()];
        for half_edge in 0..topology.opposite.len() as u32 {
            leaving[ends(&mesh.triangles, half_edge)[0] as usize] = half_edge;
        }
        Self {
            positions: mesh.positions.clone(),
            triangles: mesh.triangles.clone(),
            opposite: topology.opposite,
            sharp,
            vertices: leaving.iter().filter(|&&h| h != NONE).count(),
            leaving,
            freedom,
        }
    }

    /// Vertices in a triangle.
    pub fn vertex_count(&self) -> usize {
        self.vertices
    }

    /// Whether a half-edge belongs to a triangle that is still there.
    #[inline]
    pub fn is_alive(&self, half_edge: u32) -> bool {
        self.triangles[half_edge as usize / 3][0] != NONE
    }

    /// Start and end of a half-edge.
    #[inline]
    pub fn ends(&self, half_edge: u32) -> [u32; 2] {
        ends(&self.triangles, half_edge)
    }

    /// The length of a half-edge, squared.
    #[inline]
    pub fn length_squared(&self, half_edge: u32) -> f32 {
        let [a, b] = self.ends(half_edge);
        self.positions[a as usize].distance_squared(self.positions[b as usize])
    }

    /// The corner opposite a half-edge in its triangle.
    #[inline]
    pub fn apex(&self, half_edge: u32) -> u32 {
        self.ends(previous(half_edge))[0]
    }

    /// One half-edge of every edge: the one without a twin, or with the larger twin.
    #[inline]
    pub fn stands_for_edge(&self, half_edge: u32) -> bool {
        let twin = self.opposite[half_edge as usize];
        self.is_alive(half_edge) && (twin == NONE || half_edge < twin)
    }

    /// Visits the half-edges that leave a vertex; says whether the vertex is an inner one.
    #[inline]
    pub fn each_leaving(&self, vertex: u32, mut visit: impl FnMut(u32)) -> bool {
        let first = self.leaving[vertex as usize];
        if first == NONE {
            return false;
        }
        let mut at = first;
        loop {
            visit(at);
            at = self.opposite[previous(at) as usize];
            if at == first {
                return true;
            }
            if at == NONE {
                break;
            }
        }
        at = self.opposite[first as usize];
        while at != NONE {
            let leaving = next(at);
            visit(leaving);
            at = self.opposite[leaving as usize];
        }
        false
    }

    /// Collects the neighbours of a vertex; says whether the vertex is an inner one.
    pub fn neighbors(&self, vertex: u32, out: &mut Vec<u32>) -> bool {
        out.clear();
        let mut last = NONE;
        let inner = self.each_leaving(vertex, |half_edge| {
            out.push(self.ends(half_edge)[1]);
            let incoming = previous(half_edge);
            if self.opposite[incoming as usize] == NONE {
                last = self.ends(incoming)[0];
            }
        });
        if last != NONE {
            out.push(last);
        }
        inner
    }

    fn link(&mut self, a: u32, b: u32) {
        if a != NONE {
            self.opposite[a as usize] = b;
        }
        if b != NONE {
            self.opposite[b as usize] = a;
        }
    }

    /// Writes a triangle: corners, twins and sharpness of its three edges.
    fn write(&mut self, triangle: u32, corners: [u32; 3], twins: [u32; 3], sharp: [bool; 3]) {
        self.triangles[triangle as usize] = corners;
        for k in 0..3 {
            let half_edge = triangle * 3 + k as u32;
            self.sharp[half_edge as usize] = sharp[k];
            self.link(half_edge, twins[k]);
            self.leaving[corners[k] as usize] = half_edge;
        }
    }

    fn add_triangle(&mut self) -> u32 {
        self.triangles.push([NONE; 3]);
        self.opposite.extend([NONE; 3]);
        self.sharp.extend([false; 3]);
        self.triangles.len() as u32 - 1
    }

    /// Cuts an edge in two at `position`; hands back the new vertex.
    pub fn split(&mut self, half_edge: u32, position: Vec3) -> u32 {
        let twin = self.opposite[half_edge as usize];
        let crease = self.sharp[half_edge as usize];
        let middle = self.positions.len() as u32;
        self.positions.push(position);
        self.leaving.push(NONE);
        self.freedom.push(if crease {
            Freedom::Line
        } else {
            Freedom::Surface
        });
        self.vertices += 1;
        let [near, far] = self.split_side(half_edge, middle, crease);
        if twin != NONE {
            let [twin_near, twin_far] = self.split_side(twin, middle, crease);
            self.link(near, twin_far);
            self.link(far, twin_near);
        }
        middle
    }

    /// Cuts the triangle left of a half-edge a → b at its new middle; hands back the half-edges
    /// a → middle and middle → b, yet without twins.
    fn split_side(&mut self, half_edge: u32, middle: u32, crease: bool) -> [u32; 2] {
        let ([a, b], c) = (self.ends(half_edge), self.apex(half_edge));
        let (bc, ca) = (next(half_edge) as usize, previous(half_edge) as usize);
        let (twin_bc, twin_ca) = (self.opposite[bc], self.opposite[ca]);
        let (sharp_bc, sharp_ca) = (self.sharp[bc], self.sharp[ca]);
        let (old, new) = (half_edge / 3, self.add_triangle());
        self.write(
            old,
            [a, middle, c],
            [NONE, NONE, twin_ca],
            [crease, false, sharp_ca],
        );
        self.write(
            new,
            [middle, b, c],
            [NONE, twin_bc, old * 3 + 1],
            [crease, sharp_bc, false],
        );
        [old * 3, new * 3]
    }

    /// Whether an edge may collapse without changing the topology (the link condition).
    pub fn may_collapse(&self, half_edge: u32, ring: &mut [Vec<u32>; 2]) -> bool {
        let [a, b] = self.ends(half_edge);
        let twin = self.opposite[half_edge as usize];
        let [ring_a, ring_b] = ring;
        let inner = [self.neighbors(a, ring_a), self.neighbors(b, ring_b)];
        if twin != NONE && !inner[0] && !inner[1] {
            return false;
        }
        let shared = ring_a.iter().filter(|v| ring_b.contains(v)).count();
        if shared != if twin == NONE { 1 } else { 2 } {
            return false;
        }
        let apexes = [Some(half_edge), (twin != NONE).then_some(twin)];
        apexes.into_iter().flatten().all(|side| {
            let mut valence = 0;
            let inner = self.each_leaving(self.apex(side), |_| valence += 1);
            valence > if inner { 3 } else { 1 }
        }) && (inner[0] || inner[1] || ring_a.len().max(ring_b.len()) > 2)
    }

    /// Collapses a half-edge a → b: a disappears, b moves to `position`.
    pub fn collapse(&mut self, half_edge: u32, position: Vec3) {
        let [a, b] = self.ends(half_edge);
        let twin = self.opposite[half_edge as usize];
        let mut around = Vec::with_capacity(8);
        self.each_leaving(a, |leaving| around.push(leaving));
        for leaving in around {
            self.triangles[leaving as usize / 3][leaving as usize % 3] = b;
        }
        self.leaving[a as usize] = NONE;
        self.positions[b as usize] = position;
        self.vertices -= 1;
        self.close_side(half_edge, b);
        if twin != NONE {
            self.close_side(twin, b);
        }
    }

    /// Removes the triangle left of a collapsed half-edge and joins its neighbours.
    fn close_side(&mut self, half_edge: u32, kept: u32) {
        let apex = self.apex(half_edge);
        let (one, other) = (next(half_edge) as usize, previous(half_edge) as usize);
        let (x, y) = (self.opposite[one], self.opposite[other]);
        let sharp = self.sharp[one] || self.sharp[other];
        self.triangles[half_edge as usize / 3] = [NONE; 3];
        self.link(x, y);
        for outer in [x, y] {
            if outer != NONE {
                self.sharp[outer as usize] = sharp;
                for leaving in [outer, next(outer)] {
                    let from = self.ends(leaving)[0];
                    if from == apex || from == kept {
                        self.leaving[from as usize] = leaving;
                    }
                }
            }
        }
    }

    /// Whether an edge may be turned: it is inner, no crease, and its new place is free.
    pub fn may_flip(&self, half_edge: u32, ring: &mut Vec<u32>) -> bool {
        let twin = self.opposite[half_edge as usize];
        if twin == NONE || self.sharp[half_edge as usize] {
            return false;
        }
        let (c, d) = (self.apex(half_edge), self.apex(twin));
        self.neighbors(c, ring);
        c != d && !ring.contains(&d)
    }

    /// Turns an edge a → b into the one between the apexes of its two triangles.
    pub fn flip(&mut self, half_edge: u32) {
        let twin = self.opposite[half_edge as usize];
        let ([a, b], c, d) = (self.ends(half_edge), self.apex(half_edge), self.apex(twin));
        let outer = [
            next(half_edge),
            previous(half_edge),
            next(twin),
            previous(twin),
        ];
        let [bc, ca, ad, db] = outer.map(|h| (self.opposite[h as usize], self.sharp[h as usize]));
        let (one, two) = (half_edge / 3, twin / 3);
        self.write(one, [a, d, c], [ad.0, NONE, ca.0], [ad.1, false, ca.1]);
        self.write(
            two,
            [d, b, c],
            [db.0, bc.0, one * 3 + 1],
            [db.1, bc.1, false],
        );
    }

    /// Twice the area of a triangle times its normal, with one vertex moved.
    #[inline]
    pub fn area_normal_with(&self, triangle: [u32; 3], moved: u32, to: Vec3) -> Vec3 {
        let [a, b, c] = triangle.map(|v| {
            if v == moved {
                to
            } else {
                self.positions[v as usize]
            }
        });
        (b - a).cross(c - a)
    }

    /// The same mesh under new numbers: `vertices` and `triangles` list the old ones (second) in
    /// their new order, `numbers` holds the new number of each old vertex.
    pub(super) fn renumbered(
        &self,
        vertices: &[(u64, u32)],
        numbers: &[u32],
        triangles: &[(u32, u32)],
    ) -> Self {
        // Find the new number of each half-edge.
        let mut places = vec![NONE; self.triangles.len()];
        for (place, &(_, old)) in triangles.iter().enumerate() {
            places[old as usize] = place as u32;
        }
        let half_edge = |old: u32| match old {
            NONE => NONE,
            _ => places[old as usize / 3] * 3 + old % 3,
        };
        let sides = |old: u32| old as usize * 3..old as usize * 3 + 3;
        let olds = || triangles.iter().map(|&(_, old)| old);
        // Copy vertices, then triangles, in the new order.
        Self {
            positions: vertices
                .iter()
                .map(|&(_, v)| self.positions[v as usize])
                .collect(),
            freedom: vertices
                .iter()
                .map(|&(_, v)| self.freedom[v as usize])
                .collect(),
            leaving: vertices
                .iter()
                .map(|&(_, v)| half_edge(self.leaving[v as usize]))
                .collect(),
            triangles: olds()
                .map(|old| self.triangles[old as usize].map(|v| numbers[v as usize]))
                .collect(),
            opposite: olds()
                .flat_map(sides)
                .map(|h| half_edge(self.opposite[h]))
                .collect(),
            sharp: olds().flat_map(sides).map(|h| self.sharp[h]).collect(),
            vertices: self.vertices,
        }
    }

    /// Closes up: the mesh without removed vertices and triangles, order kept.
    pub fn finish(&self) -> TriangleMesh {
        let mut numbers = vec![NONE; self.positions.len()];
        let mut mesh = TriangleMesh::default();
        for (vertex, &leaving) in self.leaving.iter().enumerate() {
            if leaving != NONE {
                numbers[vertex] = mesh.positions.len() as u32;
                mesh.positions.push(self.positions[vertex]);
            }
        }
        let alive = self.triangles.iter().filter(|triangle| triangle[0] != NONE);
        mesh.triangles = alive.map(|t| t.map(|v| numbers[v as usize])).collect();
        mesh
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;
    use crate::random;
    use rand::Rng;

    fn open(mesh: &TriangleMesh) -> EditMesh {
        let boundary = Topology::new(&mesh.triangles).opposite;
        let sharp: Vec<bool> = boundary.iter().map(|&twin| twin == NONE).collect();
        EditMesh::new(mesh, sharp, vec![Freedom::Surface; mesh.positions.len()])
    }

    fn check(edited: &EditMesh) {
        for half_edge in 0..edited.opposite.len() as u32 {
            if !edited.is_alive(half_edge) {
                continue;
            }
            let twin = edited.opposite[half_edge as usize];
            let [a, b] = edited.ends(half_edge);
            if twin != NONE {
                assert_eq!(edited.opposite[twin as usize], half_edge);
                assert_eq!(edited.ends(twin), [b, a]);
            }
            let leaving = edited.leaving[a as usize];
            assert!(edited.is_alive(leaving) && edited.ends(leaving)[0] == a);
        }
    }

    #[test]
    fn random_operations_keep_the_topology() {
        for mesh in [
            shapes::torus(10, 8, 1.0, 0.4),
            shapes::cylinder(8, 5, 1.0, 0.5),
            shapes::icosphere(1),
        ] {
            let shape = Topology::new(&mesh.triangles).shape(&mesh);
            let mut edited = open(&mesh);
            let mut random = random::stream(3, "edited test", 0, 0);
            let mut rings = [Vec::new(), Vec::new()];
            for _ in 0..3000 {
                let half_edge = random.gen_range(0..edited.opposite.len() as u32);
                if !edited.is_alive(half_edge) {
                    continue;
                }
                let [a, b] = edited.ends(half_edge);
                let middle = edited.positions[a as usize].midpoint(edited.positions[b as usize]);
                match random.gen_range(0..4) {
                    0 => {
                        edited.split(half_edge, middle);
                    }
                    1 if edited.may_flip(half_edge, &mut rings[0]) => edited.flip(half_edge),
                    2 | 3 if edited.may_collapse(half_edge, &mut rings) => {
                        edited.collapse(half_edge, middle);
                    }
                    _ => {}
                }
            }
            check(&edited);
            let after = edited.finish();
            assert_eq!(after.positions.len(), edited.vertex_count());
            let topology = Topology::new(&after.triangles);
            assert!(topology.non_manifold.is_empty());
            assert_eq!(topology.shape(&after), shape);
        }
    }
}
