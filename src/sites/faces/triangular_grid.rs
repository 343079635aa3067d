//! A flat grid of congruent equilateral triangles on a square sample (Castellanos and Williams §3.8).

use glam::Vec3;

use crate::error::{Error, Result};
use crate::grid::TexCoord;
use crate::mesh::shapes::midpoints;
use crate::mesh::subdivision::butterfly::inherited_colors;
use crate::mesh::triangle_mesh::TriangleMesh;
use crate::sites::faces::level::FaceLevel;
use crate::sites::faces::pyramid::{FacePyramid, check_count};

/// How the grid lies on the sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GridTurn {
    /// Rows of triangles along the sample's rows.
    Upright,
    /// Turned by 90° counter-clockwise: rows of triangles along the sample's columns.
    Quarter,
}

/// A grid of triangles on a square sample, and its coarser levels.
///
/// The finest level has one row of triangles per row of pixels. The coarsest has side / 2^(levels − 1) rows of
/// ⌊√3 · rows⌋ triangles each, as many as fit in the sample's width. Positions are in pixels, x to the right and
/// y upwards from the sample's lower left corner. The grid does not continue across its borders.
///
/// Deviation: it is subdivided at the middles of edges. Butterfly subdivision gives the same points inside, but bends
/// the zigzag of the borders.
#[derive(Clone, Debug, PartialEq)]
pub struct TriangularGrid {
    /// Rows and columns of pixels.
    pub side: u32,
    /// The levels.
    pub pyramid: FacePyramid,
}

impl TriangularGrid {
    /// The grid of a square sample of `side` × `side` pixels with this many levels.
    ///
    /// Errors: `levels` of 0, a side that 2^(levels − 1) does not divide, more than 2³² half-edges.
    pub fn new(side: u32, levels: u32) -> Result<Self> {
        let Some(subdivisions) = levels.checked_sub(1) else {
            return Err(Error::option("levels", "0", "1 or more"));
        };
        let divisor = 1u32
            .checked_shl(subdivisions)
            .filter(|d| side.is_multiple_of(*d));
        let Some(divisor) = divisor.filter(|_| side > 0) else {
            return Err(Error::data("sample", format!("{side} pixels per side"))
                .expected(format!(
                    "a multiple of 2^{subdivisions}, for {levels} levels"
                ))
                .advice("crop the sample, or use fewer levels"));
        };
        let rows = side / divisor;
        let per_row = triangles_per_row(rows);
        check_count(rows as usize * per_row as usize, subdivisions)?;
        let (mesh, white) = lattice(side, rows, per_row);
        let mut levels = vec![FaceLevel::new(mesh, white)];
        for number in 0..subdivisions as usize {
            let coarser = &levels[number];
            let white = inherited_colors(&coarser.white);
            levels.push(FaceLevel::new(midpoints(&coarser.mesh), white));
        }
        let pyramid = FacePyramid { levels };
        Ok(Self { side, pyramid })
    }

    /// Where the centre of a face lies on the sample, in texels.
    pub fn place(&self, level: usize, face: usize, turn: GridTurn) -> TexCoord {
        self.on_sample(self.pyramid.levels[level].centers[face], turn)
    }

    /// Where a point of the grid lies on the sample, in texels.
    pub fn on_sample(&self, Vec3 { x, y, .. }: Vec3, turn: GridTurn) -> TexCoord {
        match turn {
            GridTurn::Upright => TexCoord { s: x, t: y },
            GridTurn::Quarter => TexCoord {
                s: self.side as f32 - y,
                t: x,
            },
        }
    }

    /// The faces of a level row by row from the top, each row from left to right.
    pub fn row_by_row(&self, level: usize) -> Vec<u32> {
        let faces = &self.pyramid.levels[level];
        let divisor = 1u32 << (self.pyramid.levels.len() - 1 - level);
        let row_of = |face: u32| {
            let below_top = self.side as f32 - faces.centers[face as usize].y;
            (below_top / divisor as f32) as u32
        };
        let mut order: Vec<(u32, u32)> = (0..faces.count() as u32)
            .map(|face| (row_of(face), face))
            .collect();
        let x = |face: u32| faces.centers[face as usize].x;
        order.sort_by(|a, b| a.0.cmp(&b.0).then(x(a.1).total_cmp(&x(b.1))));
        order.into_iter().map(|(_, face)| face).collect()
    }
}

/// How many triangles a row of the coarsest level has, if it has so many rows.
pub(super) fn triangles_per_row(rows: u32) -> u32 {
    (3f64.sqrt() * f64::from(rows)).floor() as u32
}

/// Rows of alternating triangles; those that point upwards are white.
///
/// Lines of vertices with even numbers start at the left, odd ones half a side further right.
fn lattice(extent: u32, rows: u32, per_row: u32) -> (TriangleMesh, Vec<bool>) {
    // Fit the triangles into the square.
    let height = f64::from(extent) / f64::from(rows);
    let side = height * 2.0 / 3f64.sqrt();
    let left = (f64::from(extent) - f64::from(per_row + 1) / 2.0 * side) / 2.0;
    let mut mesh = TriangleMesh::default();
    let mut first_of_line = Vec::with_capacity(rows as usize + 1);
    // Lay out the lines of vertices.
    for line in 0..=rows {
        first_of_line.push(mesh.positions.len() as u32);
        let odd = line % 2;
        let count = (per_row + 1 - odd) / 2 + 1;
        let y = f64::from(extent) - f64::from(line) * height;
        mesh.positions.extend((0..count).map(|vertex| {
            let x = left + (f64::from(vertex) + 0.5 * f64::from(odd)) * side;
            Vec3::new(x as f32, y as f32, 0.0)
        }));
    }
    // Lay out the rows of triangles.
    let mut white = Vec::with_capacity((rows * per_row) as usize);
    for row in 0..rows {
        let [top, bottom] = [row, row + 1].map(|line| first_of_line[line as usize]);
        let is_even = row % 2 == 0;
        let (even, odd) = if is_even {
            (top, bottom)
        } else {
            (bottom, top)
        };
        for column in 0..per_row {
            let i = column / 2;
            mesh.triangles.push(match (column % 2 == 0, is_even) {
                (true, true) => [even + i, odd + i, even + i + 1],
                (true, false) => [even + i, even + i + 1, odd + i],
                (false, true) => [odd + i, odd + i + 1, even + i + 1],
                (false, false) => [odd + i, even + i + 1, odd + i + 1],
            });
            white.push((row + column) % 2 == 1);
        }
    }
    (mesh, white)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_grid_of_the_paper_has_its_triangles() {
        // Fig. 8: 64 × 64 pixels, 8 rows at the coarsest level, 6,656 triangles at the finest.
        let grid = TriangularGrid::new(64, 4).unwrap();
        let counts: Vec<usize> = grid.pyramid.levels.iter().map(FaceLevel::count).collect();
        assert_eq!(counts, [104, 416, 1664, 6656]);
        for (number, level) in grid.pyramid.levels.iter().enumerate() {
            assert!(level.topology.non_manifold.is_empty());
            let distances = level.adjacent_distances();
            let height = 8.0 / f64::from(1 << number);
            assert!((distances.mean - height * 2.0 / 3.0).abs() < 1e-5);
            assert!((distances.largest / distances.mean - 1.0).abs() < 1e-4);
            for (half_edge, &twin) in level.topology.opposite.iter().enumerate() {
                if twin != crate::mesh::topology::NONE {
                    assert_ne!(level.white[half_edge / 3], level.white[twin as usize / 3]);
                }
            }
            for face in 0..level.count() {
                assert!(level.mesh.area_normal(face).z > 0.0);
                let [a, b, c] = level.mesh.corners(face).map(|corner| corner.y);
                let up = a + b + c - 3.0 * a.min(b).min(c) < 1.5 * height as f32;
                // The centre of a triangle points the other way and has its colour.
                assert_eq!(level.white[face], up == (number % 2 == 0));
            }
        }
    }

    #[test]
    fn centres_lie_on_the_sample_at_both_turns() {
        let grid = TriangularGrid::new(48, 3).unwrap();
        let finest = &grid.pyramid.levels[2];
        let mut sums = [[0.0; 2]; 2];
        for face in 0..finest.count() {
            for (turn, sum) in [GridTurn::Upright, GridTurn::Quarter]
                .into_iter()
                .zip(&mut sums)
            {
                let TexCoord { s, t } = grid.place(2, face, turn);
                assert!((0.0..=48.0).contains(&s) && (0.0..=48.0).contains(&t));
                *sum = [sum[0] + s, sum[1] + t];
            }
        }
        for mean in sums.iter().flatten().map(|sum| sum / finest.count() as f32) {
            assert!((mean - 24.0).abs() < 0.05, "{mean}");
        }
    }

    #[test]
    fn rows_are_listed_from_the_top_and_from_the_left() {
        let grid = TriangularGrid::new(12, 3).unwrap();
        let coarsest: Vec<u32> = (0..15).collect();
        assert_eq!(grid.row_by_row(0), coarsest);
        let order = grid.row_by_row(2);
        assert_eq!(order.len(), 15 * 16);
        let centers = &grid.pyramid.levels[2].centers;
        let mut rows = vec![0; 12];
        for (at, &face) in order.iter().enumerate() {
            let center = centers[face as usize];
            let row = (12.0 - center.y) as usize;
            rows[row] += 1;
            if let Some(&before) = at.checked_sub(1).and_then(|at| order.get(at)) {
                let before = centers[before as usize];
                let is_new_row = (12.0 - before.y) as usize + 1 == row;
                assert!(is_new_row || before.x < center.x);
            }
        }
        assert!(
            rows.iter().all(|&count| (17..=23).contains(&count)),
            "{rows:?}"
        );
    }

    #[test]
    fn sides_that_cannot_be_halved_are_refused() {
        for (side, levels) in [(30, 3), (0, 1), (12, 0), (64, 40)] {
            assert!(
                TriangularGrid::new(side, levels).is_err(),
                "{side} {levels}"
            );
        }
    }
}
