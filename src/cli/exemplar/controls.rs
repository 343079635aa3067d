//! The control images of an exemplar: the mask, the transition and the orientation of its texels.

use std::path::{Path, PathBuf};

use ndarray::{Array2, Array3};

use crate::cli::exemplar::arguments::Arguments;
use crate::cli::exemplar::channels::grey;
use crate::cli::exemplar::reading::{ImageReader, check_size};
use crate::error::{Error, Result};
use crate::exemplar::controls::{Controls, MASK_LABELS};
use crate::format::image::{FloatImage, Precision};
use crate::grid::TexelGrid;

/// Vectors shorter than this have no direction.
const LEAST_LENGTH: f32 = 0.25;

impl Arguments {
    /// The images of controls.
    pub(super) fn control_files(&self) -> impl Iterator<Item = &PathBuf> {
        let files = [
            &self.controls.mask,
            &self.controls.transition,
            &self.controls.orientation_map,
        ];
        files.into_iter().flatten()
    }
}

/// Reads the controls, which have the images' [width, height].
pub(super) fn read(
    arguments: &Arguments,
    size: [u32; 2],
    reader: &mut ImageReader,
) -> Result<Controls> {
    let controls = &arguments.controls;
    let grid = TexelGrid {
        width: size[0],
        height: size[1],
        tileable: arguments.tile,
    };
    Ok(Controls {
        mask: optional(&controls.mask, |path| read_mask(path, size, reader))?,
        transition: optional(&controls.transition, |path| {
            read_transition(path, grid, reader)
        })?,
        orientation: optional(&controls.orientation_map, |path| {
            read_orientation(path, size, reader)
        })?,
    })
}

fn optional<T>(path: &Option<PathBuf>, read: impl FnOnce(&Path) -> Result<T>) -> Result<Option<T>> {
    path.as_deref().map(read).transpose()
}

/// Rows and columns of an image of [width, height].
fn sides(size: [u32; 2]) -> (usize, usize) {
    (size[1] as usize, size[0] as usize)
}

/// The labels of a mask of [width, height].
pub(in crate::cli) fn read_mask(
    path: &Path,
    size: [u32; 2],
    reader: &mut ImageReader,
) -> Result<Array2<u8>> {
    let image = grey(control(path, size, reader)?, path)?;
    let labels = labels(&image).map_err(|error| error.in_file(path))?;
    shaped(Array2::from_shape_vec(sides(size), labels))
}

/// The values of a transition of a grid.
pub(in crate::cli) fn read_transition(
    path: &Path,
    grid: TexelGrid,
    reader: &mut ImageReader,
) -> Result<Array2<f32>> {
    let size = [grid.width, grid.height];
    let image = grey(control(path, size, reader)?, path)?;
    let controls = Controls {
        transition: Some(shaped(Array2::from_shape_vec(sides(size), image.data))?),
        ..Controls::default()
    };
    controls.check(grid).map_err(|error| error.in_file(path))?;
    Ok(controls.transition.unwrap_or_default())
}

/// The unit vectors of an orientation of [width, height].
pub(in crate::cli) fn read_orientation(
    path: &Path,
    size: [u32; 2],
    reader: &mut ImageReader,
) -> Result<Array3<f32>> {
    let image = control(path, size, reader)?;
    let directions = directions(&image).map_err(|error| error.in_file(path))?;
    let (rows, cols) = sides(size);
    shaped(Array3::from_shape_vec((rows, cols, 2), directions))
}

fn shaped<T>(array: std::result::Result<T, ndarray::ShapeError>) -> Result<T> {
    array.map_err(|error| Error::data("control", error.to_string()))
}

fn control(path: &Path, size: [u32; 2], reader: &mut ImageReader) -> Result<FloatImage> {
    let image = reader.control(path)?;
    check_size(&image, size, path)?;
    Ok(image)
}

/// The labels that a grey image shows: as they stand, or in equal steps from black to white.
fn labels(image: &FloatImage) -> Result<Vec<u8>> {
    let most_label = f32::from(MASK_LABELS - 1);
    let white = match image.precision {
        Precision::Bits8 => 255.0,
        Precision::Bits16 => 65535.0,
        Precision::Float => 1.0,
    };
    // Take whole labels as they stand, else grey in equal steps.
    let step = white / most_label;
    let label = |(texel, value): (usize, &f32)| {
        let stored = match image.precision {
            Precision::Float => *value,
            Precision::Bits8 | Precision::Bits16 => (value * white).round(),
        };
        let in_steps = stored / step;
        let is_label = |value: f32| (0.0..=most_label).contains(&value) && value.fract() == 0.0;
        if is_label(stored) {
            return Ok(stored as u8);
        }
        if image.precision != Precision::Float && is_label(in_steps) {
            return Ok(in_steps as u8);
        }
        // Refuse any other grey.
        let expected = match image.precision {
            Precision::Float => "the labels 0, 1, 2 and 3".to_owned(),
            _ => format!(
                "the labels 0, 1, 2 and 3, or grey 0, {step}, {} and {white}",
                2.0 * step
            ),
        };
        Err(at(image, texel, format!("grey {stored}")).expected(expected))
    };
    image.data.iter().enumerate().map(label).collect()
}

/// Unit vectors (s, t) of red and green.
fn directions(image: &FloatImage) -> Result<Vec<f32>> {
    if image.channels != 3 {
        return Err(Error::data("channels", "grey")
            .expected("red (s, rightwards) and green (t, upwards) of a direction"));
    }
    let signed = |value: f32| match image.precision {
        Precision::Float => value,
        Precision::Bits8 | Precision::Bits16 => 2.0 * value - 1.0,
    };
    let mut directions = Vec::with_capacity(image.data.len() / 3 * 2);
    for (texel, rgb) in image.data.chunks_exact(3).enumerate() {
        let (s, t) = (signed(rgb[0]), signed(rgb[1]));
        let length = s.hypot(t);
        if !length.is_finite() || length < LEAST_LENGTH {
            return Err(at(image, texel, format!("({s}, {t})")).expected(format!(
                "a direction (s, t) of length 1, at least {LEAST_LENGTH}"
            )));
        }
        directions.extend([s / length, t / length]);
    }
    Ok(directions)
}

fn at(image: &FloatImage, texel: usize, found: String) -> Error {
    let (row, col) = (texel / image.width as usize, texel % image.width as usize);
    Error::data(format!("row {row}, column {col}"), found)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::format::image::Encoding;

    fn image(precision: Precision, channels: u32, data: Vec<f32>) -> FloatImage {
        FloatImage {
            width: data.len() as u32 / channels,
            height: 1,
            channels,
            data,
            encoding: Encoding::Data,
            precision,
        }
    }

    #[test]
    fn masks_hold_labels_or_steps_of_grey() {
        let of = |precision, stored: &[f32], white: f32| {
            let numbers = stored.iter().map(|value| value / white).collect();
            labels(&image(precision, 1, numbers))
        };
        let steps = of(Precision::Bits8, &[0.0, 85.0, 170.0, 255.0], 255.0);
        assert_eq!(steps.unwrap(), [0, 1, 2, 3]);
        let plain = of(Precision::Bits8, &[3.0, 0.0, 2.0, 1.0], 255.0);
        assert_eq!(plain.unwrap(), [3, 0, 2, 1]);
        let wide = of(Precision::Bits16, &[0.0, 21845.0, 3.0, 65535.0], 65535.0);
        assert_eq!(wide.unwrap(), [0, 1, 3, 3]);
        let floats = of(Precision::Float, &[0.0, 3.0, 1.0], 1.0);
        assert_eq!(floats.unwrap(), [0, 3, 1]);
        let said = of(Precision::Bits8, &[0.0, 128.0], 255.0)
            .unwrap_err()
            .to_string();
        assert!(said.contains("row 0, column 1: grey 128"), "{said}");
        assert!(said.contains("grey 0, 85, 170 and 255"), "{said}");
        for wrong in [0.5, 4.0, -1.0] {
            assert!(of(Precision::Float, &[wrong], 1.0).is_err(), "{wrong}");
        }
    }

    #[test]
    fn directions_are_red_and_green() {
        let bytes = image(Precision::Bits8, 3, vec![1.0, 0.5, 0.0, 0.5, 0.0, 0.3]);
        assert_eq!(directions(&bytes).unwrap(), [1.0, 0.0, 0.0, -1.0]);
        let floats = image(Precision::Float, 3, vec![-3.0, 4.0, 9.0]);
        assert_eq!(directions(&floats).unwrap(), [-0.6, 0.8]);
        let none = image(Precision::Bits8, 3, vec![0.5, 0.5, 0.5]);
        let said = directions(&none).unwrap_err().to_string();
        assert!(
            said.contains("row 0, column 0: (0, 0); expected a direction"),
            "{said}"
        );
        assert!(directions(&image(Precision::Bits8, 1, vec![0.5])).is_err());
    }
}
