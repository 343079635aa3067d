//! Finds the cells of a flattened star that may hold a point of the plane.

use glam::DVec2;

use crate::mesh::compressed_rows::Rows;

/// Squares of the plane, and the cells that reach into each.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct CellFinder {
    low: DVec2,
    /// Squares per unit of length.
    density: f64,
    columns: u32,
    rows: u32,
    cells: Rows<u32>,
}

impl CellFinder {
    /// For faces of side² cells; a cell's number is face · side² + row · side + column.
    pub(super) fn new(faces: &[Vec<DVec2>], side: u32) -> Self {
        // Lay squares over all places.
        let all = || faces.iter().flatten();
        let low = all().fold(DVec2::INFINITY, |low, &place| low.min(place));
        let high = all().fold(DVec2::NEG_INFINITY, |high, &place| high.max(place));
        let density = f64::from(side);
        let size = ((high - low) * density).floor() + 1.0;
        let mut finder = Self {
            low,
            density,
            columns: size.x as u32,
            rows: size.y as u32,
            cells: Rows::default(),
        };
        // List the cells that each square meets.
        let mut pairs = Vec::new();
        for (face, places) in faces.iter().enumerate() {
            for cell in 0..side * side {
                let first = cell / side * (side + 1) + cell % side;
                let corners = [first, first + 1, first + side + 1, first + side + 2];
                let corners = corners.map(|corner| places[corner as usize]);
                let number = face as u32 * side * side + cell;
                finder.squares_of(corners, |square| pairs.push((square, number)));
            }
        }
        // Sort them by square.
        pairs.sort_unstable();
        let start = |square| pairs.partition_point(|pair| pair.0 < square) as u32;
        finder.cells = Rows {
            starts: (0..=finder.columns * finder.rows).map(start).collect(),
            entries: pairs.iter().map(|&(_, cell)| cell).collect(),
        };
        finder
    }

    /// The squares that a cell with these corners may reach into.
    fn squares_of(&self, corners: [DVec2; 4], mut visit: impl FnMut(u32)) {
        let margin = DVec2::splat(1e-6);
        let place = |at: DVec2| {
            let square = (at - self.low) * self.density;
            let last = DVec2::new(f64::from(self.columns - 1), f64::from(self.rows - 1));
            square.clamp(DVec2::ZERO, last).as_uvec2()
        };
        let [a, b, c, d] = corners;
        let from = place(a.min(b).min(c).min(d) - margin);
        let to = place(a.max(b).max(c).max(d) + margin);
        for row in from.y..=to.y {
            (from.x..=to.x).for_each(|column| visit(row * self.columns + column));
        }
    }

    /// The cells near a point.
    pub(super) fn at(&self, point: DVec2) -> &[u32] {
        let square = ((point - self.low) * self.density).floor();
        let size = DVec2::new(f64::from(self.columns), f64::from(self.rows));
        if !(square.cmpge(DVec2::ZERO).all() && square.cmplt(size).all()) {
            return &[];
        }
        self.cells
            .row(square.y as usize * self.columns as usize + square.x as usize)
    }
}
