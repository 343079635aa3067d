//! How the quadrilaterals of a mesh are connected.

use crate::mesh::compressed_rows::Rows;
use crate::mesh::topology::NONE;

/// Quadrilaterals and their neighbours; knows no positions.
///
/// Half-edge 4·q + k runs from corner k of quadrilateral q to the next corner. At most two quadrilaterals
/// share an edge, and they run along it in opposite directions.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct QuadMesh {
    /// How many vertices there are; some may be in no quadrilateral.
    pub vertices: usize,
    /// Corners, counter-clockwise seen from outside.
    pub quads: Vec<[u32; 4]>,
    /// Per half-edge its twin, [`NONE`] at a boundary.
    pub opposite: Vec<u32>,
}

impl QuadMesh {
    /// Matches the edges of quadrilaterals. Edges that more than two share are left open.
    pub fn new(vertices: usize, quads: Vec<[u32; 4]>) -> Self {
        let mut mesh = Self {
            opposite: vec![NONE; quads.len() * 4],
            vertices,
            quads,
        };
        let key = |half_edge: u32| {
            let [a, b] = mesh.ends(half_edge);
            (a.min(b), a.max(b), half_edge)
        };
        let mut keyed: Vec<_> = (0..mesh.opposite.len() as u32).map(key).collect();
        keyed.sort_unstable();
        for group in keyed.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
            if let [(.., first), (.., second)] = *group
                && mesh.ends(first)[0] != mesh.ends(second)[0]
            {
                mesh.opposite[first as usize] = second;
                mesh.opposite[second as usize] = first;
            }
        }
        mesh
    }

    /// The two ends of a half-edge, in its direction.
    #[inline]
    pub fn ends(&self, half_edge: u32) -> [u32; 2] {
        let quad = self.quads[half_edge as usize / 4];
        let corner = half_edge as usize % 4;
        [quad[corner], quad[(corner + 1) % 4]]
    }

    /// The half-edge that stands for its edge: the smaller of the two.
    #[inline]
    pub fn is_first(&self, half_edge: u32) -> bool {
        half_edge < self.opposite[half_edge as usize]
    }

    /// Edges, boundary edges included.
    pub fn edges(&self) -> usize {
        let half_edges = 0..self.opposite.len() as u32;
        half_edges.filter(|&edge| self.is_first(edge)).count()
    }

    /// The quadrilaterals round every vertex.
    pub fn fans(&self) -> Fans {
        Fans::new(self)
    }
}

/// The quadrilaterals round every vertex, in order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Fans {
    /// Per vertex 4 · quadrilateral + the corner that stands on it, counter-clockwise. At a boundary the first
    /// has the boundary on its right.
    pub corners: Rows<u32>,
    /// Whether the quadrilaterals of a vertex close round it.
    pub is_closed: Vec<bool>,
    /// Per 4 · quadrilateral + corner its place among those of its vertex.
    pub places: Vec<u32>,
}

impl Fans {
    fn new(mesh: &QuadMesh) -> Self {
        let mut first = vec![NONE; mesh.vertices];
        for (corner, &vertex) in mesh.quads.as_flattened().iter().enumerate() {
            let first = &mut first[vertex as usize];
            // The half-edge that leaves a corner has the boundary on its right.
            if *first == NONE || mesh.opposite[corner] == NONE {
                *first = corner as u32;
            }
        }
        let mut fans = Self {
            corners: Rows {
                starts: vec![0],
                entries: Vec::with_capacity(mesh.opposite.len()),
            },
            is_closed: vec![false; mesh.vertices],
            places: vec![0; mesh.opposite.len()],
        };
        for (vertex, &start) in first.iter().enumerate() {
            let begin = fans.corners.entries.len();
            let mut corner = start;
            while corner != NONE {
                fans.places[corner as usize] = (fans.corners.entries.len() - begin) as u32;
                fans.corners.entries.push(corner);
                // Across the half-edge that arrives at the vertex lies the next one.
                let arriving = corner / 4 * 4 + (corner + 3) % 4;
                corner = mesh.opposite[arriving as usize];
                if corner == start {
                    fans.is_closed[vertex] = true;
                    break;
                }
            }
            fans.corners.starts.push(fans.corners.entries.len() as u32);
        }
        fans
    }
}

#[cfg(test)]
pub(in crate::mesh::subdivision) mod tests {
    use super::*;

    /// The six faces of a cube.
    pub(in crate::mesh::subdivision) fn cube() -> QuadMesh {
        let quads = vec![
            [0, 3, 2, 1],
            [4, 5, 6, 7],
            [0, 1, 5, 4],
            [1, 2, 6, 5],
            [2, 3, 7, 6],
            [3, 0, 4, 7],
        ];
        QuadMesh::new(8, quads)
    }

    #[test]
    fn a_cube_has_twelve_edges_and_three_faces_round_each_corner() {
        let cube = cube();
        assert_eq!(cube.edges(), 12);
        let fans = cube.fans();
        for vertex in 0..8 {
            assert!(fans.is_closed[vertex]);
            let row = fans.corners.row(vertex);
            assert_eq!(row.len(), 3);
            for (place, &corner) in row.iter().enumerate() {
                let [from, _] = cube.ends(corner);
                assert_eq!(from as usize, vertex);
                assert_eq!(fans.places[corner as usize] as usize, place);
                // The edge that arrives is the one that leaves in the next face.
                let arriving = corner / 4 * 4 + (corner + 3) % 4;
                let next = row[(place + 1) % 3];
                assert_eq!(
                    cube.ends(next),
                    [cube.ends(arriving)[1], cube.ends(arriving)[0]]
                );
            }
        }
    }

    #[test]
    fn fans_at_a_boundary_begin_there() {
        // Two squares side by side: vertices 0 1 2 below, 3 4 5 above.
        let mesh = QuadMesh::new(7, vec![[0, 1, 4, 3], [1, 2, 5, 4]]);
        assert_eq!(mesh.edges(), 7);
        let fans = mesh.fans();
        // The right square's corner 0, then the left one's corner 1.
        assert_eq!(fans.corners.row(1), [4, 1]);
        assert_eq!(fans.corners.row(4), [2, 7]);
        assert!(fans.corners.row(6).is_empty() && !fans.is_closed[1]);
    }
}
