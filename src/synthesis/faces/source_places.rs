//! Where the sources of a face map lie on the sample.

use glam::Vec3;

use crate::error::{Error, Result};
use crate::grid::TexCoord;
use crate::maps::face_map::{FaceMap, Square};
use crate::sites::faces::triangular_grid::{GridTurn, TriangularGrid};

/// The triangles of the sample's finest grids.
pub(super) struct SourcePlaces {
    grid: TriangularGrid,
    /// Triangles row by row from the top.
    rows: Vec<u32>,
    square: Square,
    /// Columns and rows of the sample.
    exemplar: [u32; 2],
}

impl SourcePlaces {
    /// The grids that a map's sources are of. Errors: sources beyond them.
    pub(super) fn of(map: &FaceMap) -> Result<Self> {
        let grid = TriangularGrid::new(map.square.side, map.subdivisions + 1)?;
        let rows = grid.row_by_row(map.subdivisions as usize);
        let count = 2 * rows.len() as u64;
        let beyond = |source: &u32| u64::from(*source) >= count;
        if let Some(face) = map.sources.iter().position(beyond) {
            let found = map.sources[face].to_string();
            return Err(
                Error::data(format!("face {face}, property source"), found).expected(format!(
                    "below {count}, the triangles of the sample's grids"
                )),
            );
        }
        Ok(Self {
            grid,
            rows,
            square: map.square,
            exemplar: map.header.exemplar,
        })
    }

    /// The centre of the texel that the centre of a source lies in: faces hold whole texels, whose histograms they
    /// keep.
    pub(super) fn center(&self, source: u32) -> TexCoord {
        let (face, turn) = self.triangle(source);
        let level = self.grid.pyramid.levels.len() - 1;
        let TexCoord { s, t } = self.on_sample(self.grid.pyramid.levels[level].centers[face], turn);
        let height = self.exemplar[1] as f32;
        TexCoord {
            s: s.floor() + 0.5,
            t: height - (height - t).floor() - 0.5,
        }
    }

    /// Where the corners of a face lie, if it has a source at a phase.
    pub(super) fn corners(&self, source: u32, phase: u8) -> [TexCoord; 3] {
        let (face, turn) = self.triangle(source);
        let level = self.grid.pyramid.levels.len() - 1;
        let mut corners = self.grid.pyramid.levels[level].mesh.corners(face);
        corners.rotate_left(usize::from(phase));
        corners.map(|corner| self.on_sample(corner, turn))
    }

    fn triangle(&self, source: u32) -> (usize, GridTurn) {
        let (source, count) = (source as usize, self.rows.len());
        match source < count {
            true => (self.rows[source] as usize, GridTurn::Upright),
            false => (self.rows[source - count] as usize, GridTurn::Quarter),
        }
    }

    /// A point of the grid on the whole sample, on its texels.
    fn on_sample(&self, point: Vec3, turn: GridTurn) -> TexCoord {
        let TexCoord { s, t } = self.grid.on_sample(point, turn);
        let [width, height] = self.exemplar.map(|side| side as f32);
        let below = height - (self.square.top + self.square.side) as f32;
        TexCoord {
            s: (s + self.square.left as f32).clamp(0.0, width.next_down()),
            t: (t + below).clamp(f32::MIN_POSITIVE, height),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::maps::face_map::tests::pair;

    #[test]
    fn sources_are_numbered_row_by_row_on_both_grids() {
        let mut map = pair();
        map.square.side = 16;
        let grid = TriangularGrid::new(16, 3).unwrap();
        let count = grid.pyramid.levels[2].count() as u32;
        map.sources = vec![0, count];
        let places = SourcePlaces::of(&map).unwrap();
        // The first triangle lies at the top left; rotated by 90°, at the bottom left. The sample has 24 × 16 texels
        // and the square begins in column 4.
        let first = places.center(0);
        assert!(
            (4.0..6.0).contains(&first.s) && (15.0..16.0).contains(&first.t),
            "{first:?}"
        );
        let turned = places.center(count);
        assert!(
            (4.0..5.0).contains(&turned.s) && (0.0..2.0).contains(&turned.t),
            "{turned:?}"
        );
        let far = places.center(2 * count - 1);
        assert!(
            (19.0..20.0).contains(&far.s) && (13.0..16.0).contains(&far.t),
            "{far:?}"
        );
        for source in [0, 5, count + 7] {
            let [a, b, c] = places.corners(source, 0);
            assert_eq!(places.corners(source, 1), [b, c, a]);
            let area = (b.s - a.s) * (c.t - a.t) - (c.s - a.s) * (b.t - a.t);
            assert!((area - 2.0 / 3f32.sqrt()).abs() < 1e-3, "{area}");
            let center = places.center(source);
            let mean = (a.s + b.s + c.s) / 3.0;
            assert!(center.s == center.s.floor() + 0.5 && (center.s - mean).abs() < 0.501);
        }
        map.sources[1] = 2 * count;
        let error = SourcePlaces::of(&map).err().unwrap().to_string();
        assert!(error.contains("face 1, property source"), "{error}");
    }
}
