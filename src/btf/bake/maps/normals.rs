//! Normal maps to heights: the surface whose slopes are nearest to the map's in the least squares
//! sense (Frankot and Chellappa 1988), on a torus, by Fourier transform.
//!
//! A map's green channel points up the image (OpenGL) or down (DirectX); slopes
//! of a real surface have no curl, so the convention with less curl is the right one. Heights come out
//! in texels of the map. Normals lower than [`LEAST_Z`] are lifted to it.

use clap::ValueEnum;
use glam::DVec3;
use rustfft::num_complex::Complex64;
use rustfft::{FftDirection, FftPlannerScalar};
use serde::Deserialize;

use crate::btf::bake::maps::normal_map::Normals;

/// Steeper normals are noise: their slope would be infinite.
const LEAST_Z: f64 = 0.05;
/// The better convention must have less curl than this times the other to count as known.
const CLEARLY_LESS: f64 = 0.7;

/// Where green points in a normal map.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum NormalY {
    /// Whichever makes the slopes fit a surface.
    #[default]
    Auto,
    /// Up the image (OpenGL).
    Up,
    /// Down the image (DirectX).
    Down,
}

/// Slopes of a surface over a torus: dh/dx rightwards and dh/dy upwards, row 0 at the top.
pub(in crate::btf) struct Slopes {
    width: usize,
    height: usize,
    along_x: Vec<f64>,
    along_y: Vec<f64>,
}

/// What the map says of its own convention.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Handedness {
    pub(super) likely: NormalY,
    /// Whether the other convention has clearly more curl.
    pub(super) clear: bool,
}

impl Slopes {
    /// The slopes a map shows, its green taken to point up.
    pub(super) fn of_map(map: &Normals) -> Self {
        Self::of_normals([map.width, map.height], &map.vectors)
    }

    /// The slopes of a surface with these unit normals, row-major, +y up.
    pub(in crate::btf) fn of_normals([width, height]: [usize; 2], normals: &[DVec3]) -> Self {
        let slopes = |axis: usize| {
            normals
                .iter()
                .map(|normal| -normal[axis] / normal.z.max(LEAST_Z))
                .collect()
        };
        Self {
            width,
            height,
            along_x: slopes(0),
            along_y: slopes(1),
        }
    }

    /// The same with green pointing down.
    #[must_use]
    pub(super) fn flipped(mut self) -> Self {
        self.along_y.iter_mut().for_each(|slope| *slope = -*slope);
        self
    }

    /// The slopes of the surface continued by mirroring, on twice the rows and columns.
    #[must_use]
    pub(super) fn mirrored(&self) -> Self {
        let (width, height) = (2 * self.width, 2 * self.height);
        let source = |index: usize| {
            let (row, col) = (index / width, index % width);
            let fold = |i: usize, side: usize| {
                if i < side {
                    (i, 1.0)
                } else {
                    (2 * side - 1 - i, -1.0)
                }
            };
            let (col, sign_x) = fold(col, self.width);
            let (row, sign_y) = fold(row, self.height);
            (row * self.width + col, sign_x, sign_y)
        };
        let all = 0..width * height;
        Self {
            width,
            height,
            along_x: all
                .clone()
                .map(source)
                .map(|(at, sign, _)| sign * self.along_x[at])
                .collect(),
            along_y: all
                .map(source)
                .map(|(at, _, sign)| sign * self.along_y[at])
                .collect(),
        }
    }

    /// Which convention makes less curl, by central differences.
    pub(super) fn handedness(&self) -> Handedness {
        let (width, height) = (self.width, self.height);
        let at = |map: &[f64], row: usize, col: usize| map[(row % height) * width + col % width];
        let (mut up, mut down) = (0.0, 0.0);
        for row in 0..height {
            for col in 0..width {
                let x_along_y =
                    at(&self.along_x, row + height - 1, col) - at(&self.along_x, row + 1, col);
                let y_along_x =
                    at(&self.along_y, row, col + 1) - at(&self.along_y, row, col + width - 1);
                up += (x_along_y - y_along_x).powi(2);
                down += (x_along_y + y_along_x).powi(2);
            }
        }
        Handedness {
            likely: if up <= down {
                NormalY::Up
            } else {
                NormalY::Down
            },
            clear: f64::min(up, down) < CLEARLY_LESS * f64::max(up, down),
        }
    }

    /// Heights in texels, mean 0, of a surface that is continued by mirroring where it is not `tileable`.
    pub(in crate::btf) fn heights(&self, tileable: bool) -> Vec<f64> {
        if tileable {
            return self.integrated();
        }
        let whole = self.mirrored().integrated();
        let rows = whole.chunks_exact(2 * self.width).take(self.height);
        rows.flat_map(|row| &row[..self.width]).copied().collect()
    }

    /// Heights in texels, mean 0: ĥ = −i(ωx p̂ + ωy q̂)/(ωx² + ωy²).
    pub(super) fn integrated(&self) -> Vec<f64> {
        let (width, height) = (self.width, self.height);
        let along_x = transformed(&self.along_x, width, height);
        let along_y = transformed(&self.along_y, width, height);
        let mut spectrum = vec![Complex64::ZERO; width * height];
        for row in 0..height {
            for col in 0..width {
                let at = row * width + col;
                // Rows run downwards, so a row's frequency is minus that along y.
                let (wx, wy) = (frequency(col, width), -frequency(row, height));
                let squared = wx * wx + wy * wy;
                if squared > 0.0 {
                    let curl_free = wx * along_x[at] + wy * along_y[at];
                    spectrum[at] = -Complex64::I * curl_free / squared;
                }
            }
        }
        transform(&mut spectrum, width, height, FftDirection::Inverse);
        let scale = 1.0 / (width * height) as f64;
        spectrum.iter().map(|value| value.re * scale).collect()
    }
}

/// Angular frequency of a Fourier index, radians a texel; 0 at Nyquist, where no slope has a sign.
fn frequency(index: usize, count: usize) -> f64 {
    let signed = if 2 * index == count {
        0.0
    } else if 2 * index < count {
        index as f64
    } else {
        index as f64 - count as f64
    };
    std::f64::consts::TAU * signed / count as f64
}

fn transformed(values: &[f64], width: usize, height: usize) -> Vec<Complex64> {
    let mut spectrum: Vec<Complex64> = values.iter().map(|&v| Complex64::new(v, 0.0)).collect();
    transform(&mut spectrum, width, height, FftDirection::Forward);
    spectrum
}

/// A 2D transform in place, rows then columns, not scaled.
fn transform(values: &mut [Complex64], width: usize, height: usize, direction: FftDirection) {
    let mut planner = FftPlannerScalar::new();
    planner.plan_fft(width, direction).process(values);
    let mut columns: Vec<Complex64> = (0..width * height)
        .map(|i| values[(i % height) * width + i / height])
        .collect();
    planner.plan_fft(height, direction).process(&mut columns);
    for (i, value) in columns.into_iter().enumerate() {
        values[(i % height) * width + i / height] = value;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    const WIDTH: usize = 24;
    const HEIGHT: usize = 16;

    /// A smooth wrapped surface and its normal map, green up.
    fn surface() -> (Vec<f64>, Normals) {
        let (mut heights, mut vectors) = (Vec::new(), Vec::new());
        for row in 0..HEIGHT {
            for col in 0..WIDTH {
                let x = TAU * col as f64 / WIDTH as f64;
                let y = TAU * (HEIGHT - 1 - row) as f64 / HEIGHT as f64;
                heights.push((x + 0.3).sin() + 0.5 * (2.0 * y + x).cos());
                let p = ((x + 0.3).cos() - 0.5 * (2.0 * y + x).sin()) * TAU / WIDTH as f64;
                let q = -(2.0 * y + x).sin() * TAU / HEIGHT as f64;
                vectors.push(DVec3::new(-p, -q, 1.0).normalize());
            }
        }
        let map = Normals {
            width: WIDTH,
            height: HEIGHT,
            vectors,
            note: String::new(),
            warning: None,
        };
        (heights, map)
    }

    #[test]
    fn the_surface_comes_back() {
        let (heights, map) = surface();
        let found = Slopes::of_map(&map).integrated();
        for (found, wanted) in found.iter().zip(&heights) {
            assert!((found - wanted).abs() < 1e-4, "{found} {wanted}");
        }
    }

    #[test]
    fn the_other_handedness_is_found_out() {
        let (_, map) = surface();
        let up = Slopes::of_map(&map).handedness();
        assert_eq!((up.likely, up.clear), (NormalY::Up, true));
        let down = Slopes::of_map(&map).flipped().handedness();
        assert_eq!((down.likely, down.clear), (NormalY::Down, true));
    }

    #[test]
    fn mirrored_slopes_integrate_without_a_seam() {
        // A ramp cannot wrap, but mirrored it is a roof.
        let ramp = Slopes {
            width: 16,
            height: 4,
            along_x: vec![0.5; 64],
            along_y: vec![0.0; 64],
        };
        let heights = ramp.mirrored().integrated();
        let rise = heights[12] - heights[4];
        assert!((rise - 4.0).abs() < 0.2, "{rise}");
        assert!((heights[15] - heights[16]).abs() < 0.1);
    }
}
