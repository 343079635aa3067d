//! The side of a surface that is seen.
//!
//! A closed surface shows its outside alone. One with borders or holes shows its inside too. There frames are turned
//! over: n becomes −n, and s and t stay. View and light then stand above the side that is seen, which shows the
//! texture mirrored, as a cloth does that is coloured through.

use glam::DVec3;
use rayon::prelude::*;

use crate::mesh::triangle_mesh::TriangleMesh;

/// Whether a mesh has a border: a triangle's edge that no other triangle runs along the other way.
pub fn has_border(mesh: &TriangleMesh) -> bool {
    let edges = |triangle: &[u32; 3]| {
        let [a, b, c] = *triangle;
        [[a, b], [b, c], [c, a]]
    };
    let mut known: Vec<[u32; 2]> = mesh.triangles.par_iter().flat_map_iter(edges).collect();
    known.par_sort_unstable();
    known
        .par_iter()
        .any(|&[from, to]| known.binary_search(&[to, from]).is_err())
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
    }

    #[test]
    fn the_inside_is_seen_from_below_a_grid() {
        let grid = shapes::grid(2, 2, 1.0);
        assert!(!shows_inside(&grid, 0, DVec3::new(0.3, 0.0, 1.0)));
        assert!(shows_inside(&grid, 0, DVec3::new(0.3, 0.0, -1.0)));
    }
}
