//! The sample's texel grid: rows, columns, wrapping, pyramid parents, texture coordinates.
//!
//! Texture coordinates are in texels: s = column + ½ to the right, t = height − row − ½ upwards,
//! at a texel's centre (so u = s/W, v = t/H are OBJ's uv).

use crate::index::TexelIndex;

/// A position on the sample, in texels of its level: 0 ≤ s < width, 0 < t ≤ height on the grid.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TexCoord {
    /// Rightwards, along the columns.
    pub s: f32,
    /// Upwards, against the rows.
    pub t: f32,
}

/// Size and border of one level of the sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TexelGrid {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Whether opposite borders continue each other.
    pub tileable: bool,
}

impl TexelGrid {
    /// Texels in all.
    pub fn len(self) -> usize {
        self.width as usize * self.height as usize
    }

    /// Whether the grid holds no texel.
    pub fn is_empty(self) -> bool {
        self.len() == 0
    }

    /// The texel at a row and column of the grid.
    #[inline]
    pub fn texel(self, row: u32, col: u32) -> TexelIndex {
        debug_assert!(row < self.height && col < self.width);
        TexelIndex(row * self.width + col)
    }

    /// Row and column of a texel.
    pub fn row_col(self, texel: TexelIndex) -> (u32, u32) {
        (texel.0 / self.width, texel.0 % self.width)
    }

    /// The texel at a signed row and column: wrapped when tileable, else `None` off the grid.
    #[inline]
    pub fn texel_at(self, row: i64, col: i64) -> Option<TexelIndex> {
        let (height, width) = (i64::from(self.height), i64::from(self.width));
        let (row, col) = if (0..height).contains(&row) && (0..width).contains(&col) {
            (row, col)
        } else if self.tileable {
            (row.rem_euclid(height), col.rem_euclid(width))
        } else {
            return None;
        };
        Some(self.texel(row as u32, col as u32))
    }

    /// The texel `drow` rows below and `dcol` columns right of another.
    pub fn offset(self, texel: TexelIndex, drow: i32, dcol: i32) -> Option<TexelIndex> {
        let (row, col) = self.row_col(texel);
        self.texel_at(
            i64::from(row) + i64::from(drow),
            i64::from(col) + i64::from(dcol),
        )
    }

    /// The texture coordinate of a texel's centre.
    pub fn centre(self, texel: TexelIndex) -> TexCoord {
        let (row, col) = self.row_col(texel);
        TexCoord {
            s: col as f32 + 0.5,
            t: self.height as f32 - row as f32 - 0.5,
        }
    }

    /// The texel that holds a coordinate, (⌊H − t⌋, ⌊s⌋): wrapped when tileable, else `None` off
    /// the grid.
    #[inline]
    pub fn texel_holding(self, at: TexCoord) -> Option<TexelIndex> {
        let row = floor(self.height as f32 - at.t);
        self.texel_at(row, floor(at.s))
    }

    /// The nearest texel on the grid: wrapped when tileable, else clamped to the border.
    #[inline]
    pub fn texel_nearest(self, at: TexCoord) -> TexelIndex {
        let row = floor(self.height as f32 - at.t);
        let col = floor(at.s);
        self.texel_at(row, col).unwrap_or_else(|| {
            self.texel(
                row.clamp(0, i64::from(self.height) - 1) as u32,
                col.clamp(0, i64::from(self.width) - 1) as u32,
            )
        })
    }

    /// The next coarser level: ⌈H/2⌉ × ⌈W/2⌉.
    #[must_use]
    pub fn coarser(self) -> Self {
        Self {
            width: self.width.div_ceil(2),
            height: self.height.div_ceil(2),
            tileable: self.tileable,
        }
    }

    /// The parent of a texel on the [`coarser`](Self::coarser) level: (row ≫ 1, col ≫ 1).
    pub fn parent(self, texel: TexelIndex) -> TexelIndex {
        let (row, col) = self.row_col(texel);
        self.coarser().texel(row >> 1, col >> 1)
    }

    /// The texels of this level whose parent on the [`coarser`](Self::coarser) level this is, row by row.
    pub fn children(self, parent: TexelIndex) -> impl Iterator<Item = TexelIndex> {
        let (row, col) = self.coarser().row_col(parent);
        (2 * row..(2 * row + 2).min(self.height)).flat_map(move |row| {
            (2 * col..(2 * col + 2).min(self.width)).map(move |col| self.texel(row, col))
        })
    }

    /// The coordinate so many texels right of the grid's left border and below its upper one: wrapped when
    /// tileable, else clamped to the borders.
    #[must_use]
    pub fn coordinate(self, right: f32, down: f32) -> TexCoord {
        let (width, height) = (self.width as f32, self.height as f32);
        let on = |value: f32, side: f32| match self.tileable {
            true => {
                let rest = value.rem_euclid(side);
                // The remainder of a tiny negative number rounds up to the side itself.
                if rest < side { rest } else { 0.0 }
            }
            false => value.clamp(0.0, side.next_down()),
        };
        TexCoord {
            s: on(right, width),
            t: height - on(down, height),
        }
    }

    /// The shortest way between two coordinates, `to − from`: wrapped when tileable.
    pub fn difference(self, from: TexCoord, to: TexCoord) -> (f32, f32) {
        let (ds, dt) = (to.s - from.s, to.t - from.t);
        if !self.tileable {
            return (ds, dt);
        }
        let wrap = |d: f32, side: u32| {
            let side = side as f32;
            d - side * (d / side).round()
        };
        (wrap(ds, self.width), wrap(dt, self.height))
    }
}

/// ⌊value⌋, without the call that `f32::floor` is on processors of old.
#[inline(always)]
fn floor(value: f32) -> i64 {
    let whole = value as i64;
    whole - i64::from(whole as f32 > value)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TILE: TexelGrid = TexelGrid {
        width: 6,
        height: 4,
        tileable: true,
    };
    const PATCH: TexelGrid = TexelGrid {
        tileable: false,
        ..TILE
    };

    #[test]
    fn coordinates_name_their_texel() {
        for index in 0..TILE.len() as u32 {
            let texel = TexelIndex(index);
            assert_eq!(TILE.texel_holding(TILE.centre(texel)), Some(texel));
        }
        // Row 0 is the top of the image: t close to H.
        let top_left = TexCoord { s: 0.0, t: 4.0 };
        assert_eq!(PATCH.texel_holding(top_left), Some(TexelIndex(0)));
    }

    #[test]
    fn borders_wrap_or_end() {
        let corner = TILE.texel(0, 0);
        assert_eq!(TILE.offset(corner, -1, -1), Some(TILE.texel(3, 5)));
        assert_eq!(PATCH.offset(corner, -1, 0), None);
        let outside = TexCoord { s: -3.0, t: 9.0 };
        assert_eq!(PATCH.texel_nearest(outside), PATCH.texel(0, 0));
        assert_eq!(TILE.texel_nearest(outside), TILE.texel(3, 3));
    }

    #[test]
    fn parents_halve_rows_and_columns() {
        assert_eq!(TILE.coarser().len(), 6);
        assert_eq!(TILE.parent(TILE.texel(3, 5)), TILE.coarser().texel(1, 2));
    }

    #[test]
    fn differences_take_the_short_way_round() {
        let (a, b) = (TexCoord { s: 0.5, t: 0.5 }, TexCoord { s: 5.5, t: 3.5 });
        assert_eq!(TILE.difference(a, b), (-1.0, -1.0));
        assert_eq!(PATCH.difference(a, b), (5.0, 3.0));
    }
}
