//! A square of the image for each face of a control mesh of quadrilaterals (Ying 2001 §4.2: one texture map
//! per face).
//!
//! All squares have as many texels. They begin and end between texels, and two texels lie between any two of
//! them, so that mixing four texels never reaches into another square.

use glam::Vec2;

use super::charts::Atlas;
use crate::error::{Error, Result};
use crate::mesh::subdivision::Refinement;

/// Texels round each square that belong to no other.
const MARGIN: u32 = 1;
/// The fewest texels along a square's side.
const LEAST_SIDE: u32 = 2;
/// Cells of the surface along a square's side: at least one for this many texels.
const TEXELS_PER_CELL: u32 = 4;
/// The fewest steps of subdivision: with fewer a surface looks angular.
const LEAST_STEPS: u32 = 2;
/// The most steps of subdivision.
const MOST_STEPS: u32 = 6;
/// The most cells of a subdivided surface: half a million, a million triangles.
const MOST_CELLS: u64 = 1 << 19;

/// Where the squares of all faces lie: row by row from the top left, in the order of the faces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FaceSquares {
    faces: u32,
    resolution: u32,
    columns: u32,
    /// Texels from one square to the next.
    pitch: u32,
}

impl FaceSquares {
    /// Lays out as many squares in an image of `resolution` texels per side. Refuses more faces than can be
    /// subdivided or than have room.
    pub fn new(faces: usize, resolution: u32) -> Result<Self> {
        if faces == 0 || faces as u64 > MOST_CELLS {
            return Err(Error::data("mesh", format!("{faces} faces"))
                .expected(format!("1 to {MOST_CELLS}, for --charts faces"))
                .advice("--unwrap makes charts of any mesh"));
        }
        let faces = faces as u32;
        let columns = ceil_sqrt(faces);
        let pitch = resolution / columns;
        let least = 2 * MARGIN + LEAST_SIDE;
        if pitch < least {
            return Err(Error::option(
                "resolution",
                format!("{resolution} for the squares of {faces} faces"),
                format!("at least {}", columns * least),
            ));
        }
        Ok(Self {
            faces,
            resolution,
            columns,
            pitch,
        })
    }

    /// Texels along each side of a square.
    pub fn side(&self) -> u32 {
        self.pitch - 2 * MARGIN
    }

    /// The share of the image that squares fill.
    pub fn filled(&self) -> f64 {
        f64::from(self.faces) * (f64::from(self.side()) / f64::from(self.resolution)).powi(2)
    }

    /// Steps of subdivision after which a cell of the surface is 2 to 4 texels wide, though no fewer than 2, no
    /// more than 6, and as few as leave 2¹⁹ cells at the most.
    pub fn steps(&self) -> u32 {
        let cells = self.side().div_ceil(TEXELS_PER_CELL).next_power_of_two();
        let wanted = cells.ilog2().clamp(LEAST_STEPS, MOST_STEPS);
        let fits = |steps: &u32| u64::from(self.faces) << (2 * steps) <= MOST_CELLS;
        (0..=wanted).rev().find(fits).unwrap_or(0)
    }

    /// The texture coordinate of a place in a face, from 0 to 1 along its first edge and along its last.
    fn uv(&self, face: u32, place: Vec2) -> Vec2 {
        let first = [face % self.columns, face / self.columns].map(|of| of * self.pitch + MARGIN);
        let (left, top) = (first[0] as f32, first[1] as f32);
        let side = self.side() as f32;
        let texels = Vec2::new(left + side * place.x, top + side * (1.0 - place.y));
        let uv = texels / self.resolution as f32;
        Vec2::new(uv.x, 1.0 - uv.y)
    }

    /// The atlas of a subdivided mesh whose cells are cut in two, each from its first corner to its third.
    pub fn atlas(&self, refinement: &Refinement) -> Atlas {
        let step = (refinement.cells_per_side() as f32).recip();
        let cells = refinement.finest().quads.len() as u32;
        let mut atlas = Atlas {
            charts: self.faces as usize,
            ..Atlas::default()
        };
        for cell in 0..cells {
            let (face, [column, row]) = refinement.place_of(cell);
            let corner = |right: u32, up: u32| {
                let place = Vec2::new((column + right) as f32, (row + up) as f32);
                self.uv(face, place * step)
            };
            let [a, b, c, d] = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
            atlas.corner_uvs.extend([[a, b, c], [a, c, d]]);
            atlas.chart_of.extend([face; 2]);
        }
        atlas
    }
}

/// The smallest whole number whose square is no less.
fn ceil_sqrt(number: u32) -> u32 {
    let floor = number.isqrt();
    floor + u32::from(floor * floor < number)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::atlas::overlap;
    use crate::mesh::subdivision::QuadMesh;

    #[test]
    fn squares_have_room_between_them_and_the_same_texels() {
        // 7 faces: 3 columns of 10 texels each.
        let squares = FaceSquares::new(7, 32).unwrap();
        assert_eq!((squares.columns, squares.pitch, squares.side()), (3, 10, 8));
        let texels = |face: u32| {
            let [low, high] = [Vec2::ZERO, Vec2::ONE].map(|place| squares.uv(face, place) * 32.0);
            [low.x, 32.0 - high.y, high.x, 32.0 - low.y].map(f32::round)
        };
        assert_eq!(texels(0), [1.0, 1.0, 9.0, 9.0]);
        assert_eq!(texels(4), [11.0, 11.0, 19.0, 19.0]);
        assert_eq!(texels(6), [1.0, 21.0, 9.0, 29.0]);
        assert!((squares.filled() - 7.0 * 64.0 / 1024.0).abs() < 1e-12);
    }

    #[test]
    fn every_face_is_a_chart_that_turns_the_right_way() {
        let quads = vec![[0, 1, 4, 3], [1, 2, 5, 4]];
        let refinement = Refinement::new(QuadMesh::new(6, quads), 2);
        let squares = FaceSquares::new(2, 24).unwrap();
        let atlas = squares.atlas(&refinement);
        assert_eq!((atlas.charts, atlas.corner_uvs.len()), (2, 64));
        assert_eq!(overlap::first_overlap(&atlas.corner_uvs), None);
        for ([a, b, c], chart) in atlas.corner_uvs.iter().zip(&atlas.chart_of) {
            assert!((*b - *a).perp_dot(*c - *a) > 0.0);
            assert_eq!(a.x > 0.5, *chart == 1);
        }
    }

    #[test]
    fn surfaces_are_as_fine_as_their_texels_ask_for() {
        let steps = |faces, resolution| FaceSquares::new(faces, resolution).unwrap().steps();
        // Squares of 8, 16, 18 and 510 texels.
        assert_eq!([steps(1, 10), steps(1, 18), steps(1, 20)], [2, 2, 3]);
        assert_eq!(steps(4, 1024), 6);
        // No more than 2¹⁹ cells.
        assert_eq!(steps(1 << 17, 8192), 1);
    }

    #[test]
    fn too_many_faces_are_refused() {
        let error = FaceSquares::new(100, 39).unwrap_err().to_string();
        assert!(
            error.contains("--resolution") && error.contains("at least 40"),
            "{error}"
        );
        assert!(FaceSquares::new(100, 40).is_ok());
        let error = FaceSquares::new((1 << 19) + 1, 8192)
            .unwrap_err()
            .to_string();
        assert!(error.contains("524289 faces"), "{error}");
        assert!(FaceSquares::new(0, 8192).is_err());
    }
}
