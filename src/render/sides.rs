//! The side of a surface that is seen.
//!
//! A closed surface shows its outside alone. One with borders or holes shows its inside too. There frames are turned
//! over: n becomes −n, and s and t stay. View and light then stand above the side that is seen, which shows the texture
//! mirrored.

use glam::DVec3;
use rayon::prelude::*;

use crate::mesh::triangle_mesh::TriangleMesh;

/// Whether a mesh has a border: a triangle's edge that no other triangle runs along the other way. Vertices at the same
/// place count as one, as faces may have corners of their own.
pub fn has_border(mesh: &TriangleMesh) -> bool {
    let places = places(mesh);
    let edges = |triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(|vertex| places[vertex as usize]);
        [[a, b], [b, c], [c, a]]
    };
    let mut known: Vec<[u32; 2]> = mesh.triangles.par_iter().flat_map_iter(edges).collect();
    known.par_sort_unstable();
    known
        .par_iter()
        .any(|&[from, to]| known.binary_search(&[to, from]).is_err())
}

/// Per vertex the first vertex at its place.
fn places(mesh: &TriangleMesh) -> Vec<u32> {
    // A zero has one sign.
    let bits = |vertex: u32| {
        mesh.positions[vertex as usize]
            .to_array()
            .map(|c| (c + 0.0).to_bits())
    };
    let mut order: Vec<u32> = (0..mesh.positions.len() as u32).collect();
    order.par_sort_by_cached_key(|&vertex| (bits(vertex), vertex));
    let mut places = vec![0; order.len()];
    for same in order.chunk_by(|&a, &b| bits(a) == bits(b)) {
        same.iter()
            .for_each(|&vertex| places[vertex as usize] = same[0]);
    }
    places
}

/// Whether a viewer in this direction sees the inside of a triangle, round which its vertices run clockwise.
#[inline]
pub fn shows_inside(mesh: &TriangleMesh, triangle: u32, towards_viewer: DVec3) -> bool {
    mesh.area_normal_f64(triangle as usize).dot(towards_viewer) < 0.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    #[test]
    fn open_surfaces_have_borders_and_closed_ones_none() {
        assert!(!has_border(&shapes::icosphere(2)));
        assert!(!has_border(&shapes::torus(12, 9, 1.0, 0.4)));
        assert!(has_border(&shapes::grid(3, 2, 1.0)));
        let mut ball = shapes::icosphere(1);
        ball.triangles.pop();
        assert!(has_border(&ball));
        let own_corners = |mesh: &TriangleMesh| TriangleMesh {
            positions: (0..mesh.triangles.len())
                .flat_map(|face| mesh.corners(face))
                .collect(),
            triangles: (0..mesh.triangles.len() as u32)
                .map(|face| [3 * face, 3 * face + 1, 3 * face + 2])
                .collect(),
        };
        assert!(has_border(&own_corners(&ball)));
        assert!(!has_border(&own_corners(&shapes::icosphere(2))));
    }

    #[test]
    fn the_inside_is_seen_from_below_a_grid() {
        let grid = shapes::grid(2, 2, 1.0);
        assert!(!shows_inside(&grid, 0, DVec3::new(0.3, 0.0, 1.0)));
        assert!(shows_inside(&grid, 0, DVec3::new(0.3, 0.0, -1.0)));
    }
}
