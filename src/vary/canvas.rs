//! How a texture's mask continues where the output is larger than the texture.

use ndarray::Array2;

use crate::grid::TexelGrid;

/// What lies beyond the borders of a texture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Extension {
    /// The texture again: its borders continue each other.
    Repeat,
    /// Its mirror image.
    Mirror,
}

impl Extension {
    /// That of a texture.
    pub fn of(grid: TexelGrid) -> Self {
        match grid.tileable {
            true => Self::Repeat,
            false => Self::Mirror,
        }
    }

    /// The texture's place for a place along a side, of a texture of this many pixels.
    pub fn place(self, at: usize, side: usize) -> usize {
        match self {
            Self::Repeat => at % side,
            Self::Mirror => {
                let at = at % (2 * side);
                at.min(2 * side - 1 - at)
            }
        }
    }

    /// The texture's pixel (row, column) for one of the output.
    pub fn pixel(self, (row, col): (usize, usize), grid: TexelGrid) -> (usize, usize) {
        (
            self.place(row, grid.height as usize),
            self.place(col, grid.width as usize),
        )
    }
}

/// A mask continued over an output of (rows, columns).
pub fn extended(mask: &Array2<u8>, tileable: bool, output: (usize, usize)) -> Array2<u8> {
    let (height, width) = mask.dim();
    let grid = TexelGrid {
        width: width as u32,
        height: height as u32,
        tileable,
    };
    let extension = Extension::of(grid);
    Array2::from_shape_fn(output, |at| mask[extension.pixel(at, grid)])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn masks_repeat_or_are_mirrored() {
        let mask = ndarray::arr2(&[[1, 2, 3]]);
        let row = |tileable| extended(&mask, tileable, (2, 8)).row(1).to_vec();
        assert_eq!(row(true), [1, 2, 3, 1, 2, 3, 1, 2]);
        assert_eq!(row(false), [1, 2, 3, 3, 2, 1, 1, 2]);
    }
}
