//! `height.npy`: how high the surface lies at every texel of a sample, an optional member of its folder.
//!
//! In: heights in texels above the plane z = 0, on which the images are rectified; f32 [H, W], row 0 at the top. Out:
//! the same, checked. A sample's id does not cover them: they say where its values come from, and change none.

use std::path::{Path, PathBuf};

use ndarray::ArrayView2;

use crate::btf::description::HEIGHTS;
use crate::error::{Error, Result};
use crate::format::npy::{self, ArrayFile};
use crate::grid::TexelGrid;

/// The largest height, in texels: beyond it a sum of heights is no longer exact to a thousandth of a texel.
pub const LARGEST_HEIGHT: f32 = 1e6;

/// A height per texel.
#[derive(Clone, Debug, PartialEq)]
pub struct HeightMap {
    grid: TexelGrid,
    heights: Vec<f32>,
}

impl HeightMap {
    /// Heights in texels above z = 0, row-major; refused where their number is not the grid's, or one is not finite.
    pub fn new(grid: TexelGrid, heights: Vec<f32>) -> Result<Self> {
        if heights.len() != grid.len() {
            return Err(Error::data("heights", heights.len().to_string())
                .expected(format!("{} × {} texels", grid.width, grid.height)));
        }
        let sound = |height: &f32| height.abs() <= LARGEST_HEIGHT;
        let Some(at) = heights.iter().position(|height| !sound(height)) else {
            return Ok(Self { grid, heights });
        };
        let width = grid.width as usize;
        let (row, col) = (at / width, at % width);
        Err(Error::data(
            format!("row {row}, column {col}"),
            format!("height {}", heights[at]),
        )
        .expected(format!(
            "numbers from −{LARGEST_HEIGHT:e} to {LARGEST_HEIGHT:e}, in texels"
        )))
    }

    /// Heights over any plane, moved so that their mean is z = 0.
    pub fn levelled(grid: TexelGrid, mut heights: Vec<f32>) -> Result<Self> {
        let sum: f64 = heights.iter().map(|&height| f64::from(height)).sum();
        let mean = sum / heights.len().max(1) as f64;
        for height in &mut heights {
            *height = (f64::from(*height) - mean) as f32;
        }
        Self::new(grid, heights)
    }

    /// Where a sample's folder has its heights.
    pub fn path_in(folder: &Path) -> PathBuf {
        folder.join(HEIGHTS)
    }

    /// The heights in a sample's folder; `None` where there are none.
    pub fn read(folder: &Path, grid: TexelGrid) -> Result<Option<Self>> {
        let path = Self::path_in(folder);
        if !path.is_file() {
            return Ok(None);
        }
        let map = Self::read_file(&path, grid).map_err(|error| {
            let advice = "remove it, or `mesotex heights --force` estimates it again";
            error.advice(advice).in_file(&path)
        })?;
        Ok(Some(map))
    }

    fn read_file(path: &Path, grid: TexelGrid) -> Result<Self> {
        let file = ArrayFile::<f32>::open(path)?;
        let expected = [grid.height as usize, grid.width as usize];
        if file.shape() != expected {
            return Err(Error::data("shape", format!("{:?}", file.shape()))
                .expected(format!("{expected:?}, the rows and columns of the sample")));
        }
        let mut heights = vec![0.0; grid.len()];
        file.read(0, &mut heights)?;
        Self::new(grid, heights)
    }

    /// Writes `height.npy` into a folder.
    pub fn write(&self, folder: &Path) -> Result<()> {
        let sides = (self.grid.height as usize, self.grid.width as usize);
        let array = ArrayView2::from_shape(sides, &self.heights)
            .map_err(|error| Error::data("heights", error.to_string()))?;
        npy::write(&Self::path_in(folder), array.into_dyn())
    }

    /// The sample's grid.
    pub fn grid(&self) -> TexelGrid {
        self.grid
    }

    /// All heights in texels, row-major.
    pub fn heights(&self) -> &[f32] {
        &self.heights
    }

    /// The lowest and the highest.
    pub fn range(&self) -> [f32; 2] {
        let heights = self.heights.iter();
        heights.fold([f32::INFINITY, f32::NEG_INFINITY], |[least, most], &h| {
            [least.min(h), most.max(h)]
        })
    }

    /// The deviation from the mean height: the square root of the mean square.
    pub fn deviation(&self) -> f64 {
        let count = self.heights.len() as f64;
        let mean = self.heights.iter().map(|&h| f64::from(h)).sum::<f64>() / count;
        let squares = self.heights.iter().map(|&h| (f64::from(h) - mean).powi(2));
        (squares.sum::<f64>() / count).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GRID: TexelGrid = TexelGrid {
        width: 3,
        height: 2,
        tileable: true,
    };

    #[test]
    fn heights_round_trip() {
        let folder = tempfile::tempdir().unwrap();
        assert_eq!(HeightMap::read(folder.path(), GRID).unwrap(), None);
        let map = HeightMap::levelled(GRID, vec![1.0, 2.0, 3.0, 4.0, 5.0, 6.0]).unwrap();
        assert_eq!(map.heights(), [-2.5, -1.5, -0.5, 0.5, 1.5, 2.5]);
        assert_eq!(map.range(), [-2.5, 2.5]);
        assert!((map.deviation() - (35.0_f64 / 12.0).sqrt()).abs() < 1e-6);
        map.write(folder.path()).unwrap();
        assert_eq!(HeightMap::read(folder.path(), GRID).unwrap(), Some(map));
    }

    #[test]
    fn heights_of_another_size_or_without_a_value_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let refused = |grid: TexelGrid, heights: &[f32], says: &[&str]| {
            let sides = (grid.height as usize, grid.width as usize);
            let array = ArrayView2::from_shape(sides, heights).unwrap();
            npy::write(&HeightMap::path_in(folder.path()), array.into_dyn()).unwrap();
            let error = HeightMap::read(folder.path(), GRID)
                .unwrap_err()
                .to_string();
            for part in says.iter().chain(&["height.npy"]) {
                assert!(error.contains(part), "{error}");
            }
        };
        let turned = TexelGrid {
            width: 2,
            height: 3,
            tileable: true,
        };
        refused(turned, &[0.0; 6], &["[3, 2]", "[2, 3]", "--force"]);
        let mut heights = [0.0; 6];
        for bad in [f32::NAN, f32::INFINITY, -2e6] {
            heights[4] = bad;
            refused(GRID, &heights, &["row 1, column 1", &bad.to_string()]);
        }
        assert!(HeightMap::new(GRID, vec![0.0; 5]).is_err());
    }
}
