//! The faces round a vertex of a control mesh, flattened (Ying 2001 §4.2).
//!
//! The faces are laid out as a regular star of equal rhombs round the origin, with an outer layer of the same
//! rhombs. Subdividing these plane positions as the surface is subdivided gives the map of every face into the
//! plane. It depends on the number of faces alone, so that all vertices with as many share one.
//!
//! The faces of a boundary vertex fill a half plane, a single face a quarter, and the boundary is subdivided
//! as that of the surface is. The paper has closed surfaces.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::DVec2;

use super::cell_finder::CellFinder;
use super::quad_mesh::QuadMesh;
use super::refinement::Refinement;

/// The fewest faces round an inner vertex that make a star: two opposite edges span no rhomb.
const LEAST_VALENCE: usize = 3;
/// The most faces of a star: more are very thin, and refining them takes long.
const MOST_VALENCE: usize = 32;
/// A point this little outside a triangle, in weight, still belongs to it.
const SLACK: f64 = 1e-7;

/// A flattened star.
#[derive(Clone, Debug, PartialEq)]
pub struct Star {
    /// Cells along each side of a face.
    side: u32,
    /// Per face, counter-clockwise, the places of its (side + 1)² vertices: rows in which the first edge of
    /// the face counts, from the centre outwards.
    faces: Vec<Vec<DVec2>>,
    finder: CellFinder,
}

/// A place on a face of a star.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StarPoint {
    /// The face, counter-clockwise from the star's first.
    pub face: usize,
    /// Column and row of the cell, counted from the face's own first corner.
    pub cell: [u32; 2],
    /// The half of the cell: 0 has its corners 0, 1 and 2, 1 has 0, 2 and 3.
    pub half: usize,
    /// Weights of the half's corners.
    pub weights: [f32; 3],
}

impl Star {
    /// The star of a vertex with this many faces, each cut into `2^steps` cells along each side; `None` for numbers
    /// that make none: 2 at an inner vertex, and more than 32.
    pub fn new(valence: usize, is_closed: bool, steps: u32) -> Option<Self> {
        let least = if is_closed { LEAST_VALENCE } else { 1 };
        if !(least..=MOST_VALENCE).contains(&valence) {
            return None;
        }
        let (control, places) = control_star(valence, is_closed);
        let refinement = Refinement::new(control, steps);
        let limit = refinement.limit_values(&places);
        let side = refinement.cells_per_side();
        let faces: Vec<Vec<DVec2>> = (0..valence as u32)
            .map(|face| {
                let grid = (0..=side).flat_map(|row| (0..=side).map(move |column| [column, row]));
                let place = |[column, row]: [u32; 2]| {
                    // The vertex is a corner of the cell before it, at the far borders.
                    let cell = [column.min(side - 1), row.min(side - 1)];
                    let corner = match [column - cell[0], row - cell[1]] {
                        [0, 0] => 0,
                        [_, 0] => 1,
                        [0, _] => 3,
                        [..] => 2,
                    };
                    let quad = refinement.cell(INNER * face, cell);
                    limit[refinement.finest().quads[quad as usize][corner] as usize]
                };
                grid.map(place).collect()
            })
            .collect();
        Some(Self {
            side,
            finder: CellFinder::new(&faces, side),
            faces,
        })
    }

    /// Where a vertex of a face lies: `corner` is the face's corner that stands on the centre, `vertex` its
    /// column and row from the face's own first corner.
    pub fn place(&self, face: usize, corner: u32, vertex: [u32; 2]) -> DVec2 {
        let [along, beside] = seen_from(corner, vertex, self.side);
        self.faces[face][(beside * (self.side + 1) + along) as usize]
    }

    /// The place of a point of the plane; `None` beyond the faces of the star. `corner` says which corner of
    /// each face stands on the centre.
    pub fn locate(&self, at: DVec2, corner: impl Fn(usize) -> u32) -> Option<StarPoint> {
        let per_face = self.side * self.side;
        self.finder.at(at).iter().find_map(|&cell| {
            let face = (cell / per_face) as usize;
            let seen = [cell % per_face % self.side, cell % per_face / self.side];
            self.in_cell(at, face, (corner(face), seen))
        })
    }

    /// The place of a point in one cell, which is given as it is seen from the centre.
    fn in_cell(
        &self,
        at: DVec2,
        face: usize,
        (corner, seen): (u32, [u32; 2]),
    ) -> Option<StarPoint> {
        let [column, row] = turned_back(corner, seen, self.side - 1);
        let places = [[0, 0], [1, 0], [1, 1], [0, 1]]
            .map(|[right, up]| self.place(face, corner, [column + right, row + up]));
        [[0, 1, 2], [0, 2, 3]]
            .into_iter()
            .enumerate()
            .find_map(|(half, corners)| {
                let [a, b, c] = corners.map(|k: usize| places[k]);
                let doubled = (b - a).perp_dot(c - a);
                let first = (b - at).perp_dot(c - at) / doubled;
                let second = (c - at).perp_dot(a - at) / doubled;
                let weights = [first, second, 1.0 - first - second];
                weights
                    .iter()
                    .all(|&weight| weight >= -SLACK)
                    .then(|| StarPoint {
                        face,
                        cell: [column, row],
                        half,
                        weights: weights.map(|weight| weight as f32),
                    })
            })
    }
}

/// Columns and rows of a face as they are seen from one of its corners: along the edge that leaves the corner,
/// and along the one that arrives. `end` is the greatest.
fn seen_from(corner: u32, [column, row]: [u32; 2], end: u32) -> [u32; 2] {
    match corner {
        0 => [column, row],
        1 => [row, end - column],
        2 => [end - column, end - row],
        _ => [end - row, column],
    }
}

/// The way back from [`seen_from`].
fn turned_back(corner: u32, [along, beside]: [u32; 2], end: u32) -> [u32; 2] {
    match corner {
        0 => [along, beside],
        1 => [end - beside, along],
        2 => [end - along, end - beside],
        _ => [beside, end - along],
    }
}

/// Control faces of a sector: the face itself, first, and those of the outer layer.
const INNER: u32 = 4;
/// Vertices of a sector: two on its first edge, four between its edges.
const SECTOR: u32 = 6;

/// The control mesh of a star with its outer layer, and where its vertices lie. Face 4·i is the inner one of
/// sector i.
fn control_star(valence: usize, is_closed: bool) -> (QuadMesh, Vec<DVec2>) {
    let sectors = valence as u32;
    let angle = match (is_closed, valence) {
        (true, _) => TAU / valence as f64,
        (false, 1) => FRAC_PI_2,
        (false, _) => PI / valence as f64,
    };
    let edge = |sector: u32| DVec2::from_angle(angle * f64::from(sector));
    // The vertex at `along` on the sector's first edge and `beside` on its second.
    let vertex = |sector: u32, along: u32, beside: u32| match (along, beside) {
        (0, 0) => 0,
        (along, 0) => 1 + SECTOR * sector + along - 1,
        (0, beside) if is_closed => 1 + SECTOR * ((sector + 1) % sectors) + beside - 1,
        (0, beside) => 1 + SECTOR * (sector + 1) + beside - 1,
        (along, beside) => 1 + SECTOR * sector + 2 + (along - 1) + 2 * (beside - 1),
    };
    let mut places = vec![DVec2::ZERO];
    let mut quads = Vec::new();
    for sector in 0..sectors {
        let (first, second) = (edge(sector), edge(sector + 1));
        places.extend([first, first * 2.0]);
        for beside in [1.0, 2.0] {
            places.extend([1.0, 2.0].map(|along| first * along + second * beside));
        }
        for (along, beside) in [(0, 0), (1, 0), (1, 1), (0, 1)] {
            quads.push([
                vertex(sector, along, beside),
                vertex(sector, along + 1, beside),
                vertex(sector, along + 1, beside + 1),
                vertex(sector, along, beside + 1),
            ]);
        }
    }
    if !is_closed {
        places.extend([edge(sectors), edge(sectors) * 2.0]);
    }
    (QuadMesh::new(places.len(), quads), places)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The corners of both halves of every cell, as the star lies.
    fn triangles(star: &Star) -> Vec<[DVec2; 3]> {
        let mut all = Vec::new();
        for face in 0..star.faces.len() {
            for row in 0..star.side {
                for column in 0..star.side {
                    let [a, b, c, d] = [[0, 0], [1, 0], [1, 1], [0, 1]]
                        .map(|[right, up]| star.place(face, 0, [column + right, row + up]));
                    all.extend([[a, b, c], [a, c, d]]);
                }
            }
        }
        all
    }

    #[test]
    fn stars_never_fold() {
        let closed = (3..=8).map(|valence| (valence, true));
        for (valence, is_closed) in closed.chain((1..=6).map(|valence| (valence, false))) {
            let star = Star::new(valence, is_closed, 4).unwrap();
            let triangles = triangles(&star);
            // All turn the same way, and together they go round the centre once: the map is one to one.
            let area: f64 = triangles
                .iter()
                .map(|[a, b, c]| {
                    let doubled = (*b - *a).perp_dot(*c - *a);
                    assert!(doubled > 0.0, "{valence}");
                    doubled / 2.0
                })
                .sum();
            // No point is covered twice: points drawn in each triangle are found in it.
            let covered = triangles.iter().enumerate().all(|(number, [a, b, c])| {
                let at = *a * 0.3 + *b * 0.3 + *c * 0.4;
                let found = star.locate(at, |_| 0).unwrap();
                let cell = found.cell[1] * star.side + found.cell[0];
                let cells = star.side * star.side;
                number as u32 == 2 * (found.face as u32 * cells + cell) + found.half as u32
            });
            assert!(covered && area > 0.0, "{valence}");
        }
        assert_eq!(Star::new(2, true, 2), None);
        assert_eq!(Star::new(33, true, 2), None);
        assert_eq!(Star::new(0, false, 2), None);
    }

    #[test]
    fn regular_stars_are_lattices() {
        for (valence, is_closed) in [(4, true), (2, false), (1, false)] {
            let star = Star::new(valence, is_closed, 3).unwrap();
            for face in 0..valence {
                for row in 0..=8 {
                    for column in 0..=8 {
                        let along = DVec2::from_angle(FRAC_PI_2 * face as f64);
                        let wanted =
                            (along * f64::from(column) + along.perp() * f64::from(row)) / 8.0;
                        let found = star.place(face, 0, [column, row]);
                        assert!(found.distance(wanted) < 1e-12, "{found}, {wanted}");
                    }
                }
            }
        }
    }

    #[test]
    fn faces_may_stand_on_any_corner() {
        let star = Star::new(5, true, 2).unwrap();
        for corner in 0..4 {
            // The centre and the ends of the face's two edges there.
            let end = star.side;
            let corners = [[0, 0], [end, 0], [end, end], [0, end]];
            let at = |k: u32| star.place(1, corner, corners[(corner + k) as usize % 4]);
            assert!(at(0).length() < 1e-12);
            assert!(at(1).perp_dot(at(3)) > 0.0);
            assert_eq!(at(1), star.place(1, 0, [end, 0]));
            let inside = star.place(1, corner, [1, 2]) * 0.5
                + star.place(1, corner, [2, 2]) * 0.25
                + star.place(1, corner, [2, 3]) * 0.25;
            let found = star.locate(inside, |_| corner).unwrap();
            assert_eq!((found.face, found.cell, found.half), (1, [1, 2], 0));
            for (weight, wanted) in found.weights.into_iter().zip([0.5, 0.25, 0.25]) {
                assert!((weight - wanted).abs() < 1e-6);
            }
        }
    }

    #[test]
    fn neighbors_agree_on_the_edge_between_them() {
        for (valence, is_closed) in [(3, true), (5, true), (3, false)] {
            let star = Star::new(valence, is_closed, 3).unwrap();
            let last = if is_closed { valence } else { valence - 1 };
            for face in 0..last {
                for step in 0..=8 {
                    let left = star.place(face, 0, [0, step]);
                    let right = star.place((face + 1) % valence, 0, [step, 0]);
                    assert!(left.distance(right) < 1e-12);
                }
            }
        }
    }
}
