//! Projective maps of the plane.

use nalgebra::{Matrix3, SMatrix, SVector};

/// A map of (u, v) in the unit square, v down, to the plane of a picture.
#[derive(Clone, Debug)]
pub(super) struct Homography(Matrix3<f64>);

impl Homography {
    /// The map that takes (0, 0), (1, 0), (1, 1), (0, 1) to these points; `None` where they are no convex
    /// quadrilateral in this order, either way round.
    pub(super) fn from_unit_square(points: [[f64; 2]; 4]) -> Option<Self> {
        if !is_convex(points) {
            return None;
        }
        let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let mut matrix = SMatrix::<f64, 8, 8>::zeros();
        let mut wanted = SVector::<f64, 8>::zeros();
        for (at, ([u, v], [x, y])) in corners.into_iter().zip(points).enumerate() {
            let rows = [
                [u, v, 1.0, 0.0, 0.0, 0.0, -u * x, -v * x],
                [0.0, 0.0, 0.0, u, v, 1.0, -u * y, -v * y],
            ];
            for (offset, (row, coordinate)) in rows.into_iter().zip([x, y]).enumerate() {
                matrix.row_mut(2 * at + offset).copy_from_slice(&row);
                wanted[2 * at + offset] = coordinate;
            }
        }
        let h = matrix.lu().solve(&wanted)?;
        let map = Matrix3::new(h[0], h[1], h[2], h[3], h[4], h[5], h[6], h[7], 1.0);
        map.iter()
            .all(|entry| entry.is_finite())
            .then_some(Self(map))
    }

    /// Where a point of the square lies in the picture.
    pub(super) fn apply(&self, [u, v]: [f64; 2]) -> [f64; 2] {
        let point = self.0 * nalgebra::Vector3::new(u, v, 1.0);
        [point.x / point.z, point.y / point.z]
    }
}

/// Whether each corner turns the same way, and none by nearly nothing.
fn is_convex(points: [[f64; 2]; 4]) -> bool {
    let turn = |at: usize| {
        let [a, b, c] = [0, 1, 2].map(|step| points[(at + step) % 4]);
        let (p, q) = ([b[0] - a[0], b[1] - a[1]], [c[0] - b[0], c[1] - b[1]]);
        (p[0] * q[1] - p[1] * q[0]) / (p[0].hypot(p[1]) * q[0].hypot(q[1]))
    };
    let turns = [0, 1, 2, 3].map(turn);
    turns.iter().all(|turn| *turn > 1e-6) || turns.iter().all(|turn| *turn < -1e-6)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_and_the_meeting_of_diagonals_are_kept() {
        let points = [[10.0, 20.0], [110.0, 5.0], [120.0, 90.0], [0.0, 70.0]];
        let map = Homography::from_unit_square(points).unwrap();
        for (at, wanted) in [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]
            .into_iter()
            .zip(points)
        {
            let found = map.apply(at);
            assert!((found[0] - wanted[0]).hypot(found[1] - wanted[1]) < 1e-9);
        }
        // The middle of the square lies on both diagonals.
        let middle = map.apply([0.5, 0.5]);
        for [from, to] in [[points[0], points[2]], [points[1], points[3]]] {
            let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
            let off = dx * (middle[1] - from[1]) - dy * (middle[0] - from[0]);
            assert!(off.abs() < 1e-6);
        }
    }

    #[test]
    fn crossed_and_flat_quadrilaterals_are_refused() {
        let of = Homography::from_unit_square;
        assert!(of([[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]]).is_none());
        assert!(of([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [0.0, 1.0]]).is_none());
        assert!(of([[0.0, 0.0], [0.0, 0.0], [1.0, 1.0], [0.0, 1.0]]).is_none());
        // Mirrored pictures are taken: two corners were swapped on purpose.
        assert!(of([[1.0, 0.0], [0.0, 0.0], [0.0, 1.0], [1.0, 1.0]]).is_some());
    }
}
