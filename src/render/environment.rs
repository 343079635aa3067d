//! A latitude-longitude image as a few directional lights, placed by importance.
//!
//! The image is split again and again where the part with the most flux has half of it on either
//! side (Debevec 2005, median cut, with any number of parts), so bright places get many lights.
//! Each light stands at its part's centroid of flux and has all its flux: the sum of the
//! lights' irradiances is the integral of radiance over solid angle, whatever their number.

use std::path::Path;

use glam::DVec3;

use crate::error::{Error, Result};
use crate::format::image::{self, Alpha, Flags, FloatImage, Missing, Notes, ReadOptions};
use crate::progress::Progress;
use crate::render::azimuth::AzimuthFrame;
use crate::render::light::{Light, Origin, luminance};
use crate::render::options::RenderOptions;

/// Reads the image of an environment in linear Rec. 709, three channels. Where it is transparent or holds no
/// data there is no light: such places are black.
pub fn read(path: &Path, options: &RenderOptions, progress: Progress<'_>) -> Result<FloatImage> {
    let reading = ReadOptions {
        encoding: options.lights.environment_encoding.unwrap_or_default(),
        alpha: Alpha::OverBlack,
        missing: Missing::Black,
        layer: options.lights.environment_layer.clone(),
        flags: Flags {
            layer: "--environment-layer",
            encoding: "--environment-encoding",
            ..Flags::default()
        },
        ..ReadOptions::default()
    };
    let read = image::read_with(path, &reading)?;
    let mut notes = Notes::default();
    notes.add(path, read.notes);
    notes.warn(progress);
    reading.check_layer_taken(read.layer_taken)?;
    Ok(read.image.into_linear().into_rgb())
}

/// A part of the image: first and last row and column, the last not included.
#[derive(Clone, Copy, Debug)]
struct Part {
    rows: [usize; 2],
    columns: [usize; 2],
}

/// Sums of luminance times solid angle over rectangles from the upper left corner.
struct FluxTable {
    width: usize,
    sums: Vec<f64>,
}

impl FluxTable {
    fn new(image: &FloatImage) -> Self {
        let (width, height) = (image.width as usize, image.height as usize);
        let mut sums = vec![0.0; (width + 1) * (height + 1)];
        for row in 0..height {
            let solid_angle = solid_angle(image, row);
            let mut line = 0.0;
            for column in 0..width {
                line += f64::from(luminance(texel(image, row, column))) * solid_angle;
                sums[(row + 1) * (width + 1) + column + 1] =
                    sums[row * (width + 1) + column + 1] + line;
            }
        }
        Self { width, sums }
    }

    fn of(&self, part: Part) -> f64 {
        let at = |row: usize, column: usize| self.sums[row * (self.width + 1) + column];
        let ([top, bottom], [left, right]) = (part.rows, part.columns);
        at(bottom, right) - at(top, right) - at(bottom, left) + at(top, left)
    }

    /// Cuts a part where half its flux is on either side, across its longer extent.
    fn split(&self, part: Part, height: usize) -> Option<(Part, Part)> {
        let ([top, bottom], [left, right]) = (part.rows, part.columns);
        let middle = (top + bottom) as f64 * 0.5 / height as f64 * std::f64::consts::PI;
        let wide = (right - left) as f64 * middle.sin();
        let across = wide >= (bottom - top) as f64 && right - left > 1 || bottom - top == 1;
        let halves = |cut: usize| {
            let (mut first, mut second) = (part, part);
            if across {
                (first.columns[1], second.columns[0]) = (cut, cut);
            } else {
                (first.rows[1], second.rows[0]) = (cut, cut);
            }
            (first, second)
        };
        let [from, to] = if across { part.columns } else { part.rows };
        if to - from < 2 {
            return None;
        }
        let half = 0.5 * self.of(part);
        let cut = (from + 1..to).min_by(|&a, &b| {
            let error = |cut: usize| (self.of(halves(cut).0) - half).abs();
            error(a).total_cmp(&error(b))
        })?;
        Some(halves(cut))
    }
}

fn texel(image: &FloatImage, row: usize, column: usize) -> [f32; 3] {
    [0, 1, 2].map(|channel| image.get(row as u32, column as u32, channel))
}

/// The solid angle of a texel of a row.
fn solid_angle(image: &FloatImage, row: usize) -> f64 {
    let polar = |row: usize| row as f64 / f64::from(image.height) * std::f64::consts::PI;
    (polar(row).cos() - polar(row + 1).cos()) * std::f64::consts::TAU / f64::from(image.width)
}

/// The direction of a texel's centre. The image's middle lies at azimuth 180° + `turn`; its columns
/// run clockwise seen from above, as one sees them standing inside.
fn direction(
    image: &FloatImage,
    azimuths: &AzimuthFrame,
    turn: f64,
    row: usize,
    column: usize,
) -> DVec3 {
    let u = (column as f64 + 0.5) / f64::from(image.width);
    let v = (row as f64 + 0.5) / f64::from(image.height);
    let azimuth = std::f64::consts::TAU * (1.0 - u) + turn;
    azimuths.direction(azimuth, (0.5 - v) * std::f64::consts::PI)
}

/// At most `count` directional lights for an image of linear radiance (3 channels), rotated by `turn` radians and
/// multiplied by `scale`.
pub fn lights(
    image: &FloatImage,
    azimuths: &AzimuthFrame,
    count: usize,
    scale: f64,
    turn: f64,
) -> Result<Vec<Light>> {
    // Check the radiance.
    if let Some(at) = image
        .data
        .iter()
        .position(|v| !(0.0..f32::INFINITY).contains(v))
    {
        let texel = at / 3;
        let (row, column) = (texel / image.width as usize, texel % image.width as usize);
        return Err(Error::data(
            format!("environment, row {row}, column {column}"),
            format!("radiance {}", image.data[at]),
        )
        .expected("finite and not negative"));
    }
    // Halve the part of most flux until there are enough.
    let flux = FluxTable::new(image);
    let (width, height) = (image.width as usize, image.height as usize);
    let mut parts = vec![Part {
        rows: [0, height],
        columns: [0, width],
    }];
    if flux.of(parts[0]) <= 0.0 {
        return Err(Error::data("environment", "black").expected("some light"));
    }
    while parts.len() < count {
        let brightest = (0..parts.len())
            .filter_map(|index| Some((index, flux.split(parts[index], height)?)))
            .max_by(|a, b| flux.of(parts[a.0]).total_cmp(&flux.of(parts[b.0])));
        let Some((index, (first, second))) = brightest else {
            break;
        };
        parts[index] = first;
        parts.push(second);
    }
    // Put a light into the middle of each part's flux.
    let light = |part: &Part| {
        light_of(
            image,
            *part,
            |row, column| direction(image, azimuths, turn, row, column),
            scale,
        )
    };
    Ok(parts.iter().filter_map(light).collect())
}

/// The light that stands for a part; `None` where it is black.
fn light_of(
    image: &FloatImage,
    part: Part,
    direction: impl Fn(usize, usize) -> DVec3,
    scale: f64,
) -> Option<Light> {
    let mut irradiance = [0.0; 3];
    let mut centroid = DVec3::ZERO;
    for row in part.rows[0]..part.rows[1] {
        let solid_angle = solid_angle(image, row) * scale;
        for column in part.columns[0]..part.columns[1] {
            let radiance = texel(image, row, column);
            for (sum, value) in irradiance.iter_mut().zip(radiance) {
                *sum += f64::from(value) * solid_angle;
            }
            centroid += direction(row, column) * f64::from(luminance(radiance)) * solid_angle;
        }
    }
    let towards = centroid.try_normalize()?;
    Some(Light {
        origin: Origin::Directional { towards },
        irradiance: irradiance.map(|value| value as f32),
        angular_radius: 0.0,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::format::image::{Encoding, Precision};
    use crate::render::azimuth::Axis;

    fn image(value: impl Fn(u32, u32) -> f32) -> FloatImage {
        let (width, height) = (64, 32);
        let texels = (0..height).flat_map(|row| (0..width).map(move |column| (row, column)));
        FloatImage {
            width,
            height,
            channels: 3,
            data: texels
                .flat_map(|(row, column)| [value(row, column); 3])
                .collect(),
            encoding: Encoding::Linear,
            precision: Precision::Float,
        }
    }

    #[test]
    fn flux_is_kept_whatever_the_number_of_lights() {
        let azimuths = AzimuthFrame::facing(Axis::Y, Axis::Z);
        let uniform = image(|_, _| 0.5);
        for count in [1, 2, 7, 64] {
            let lights = lights(&uniform, &azimuths, count, 1.0, 0.0);
            let total: f32 = match lights {
                Ok(lights) => lights.iter().map(|light| light.irradiance[1]).sum(),
                // One light for a uniform sphere has no direction.
                Err(_) => unreachable!(),
            };
            if count > 1 {
                let sphere = 0.5 * 4.0 * std::f32::consts::PI;
                assert!((total - sphere).abs() < 1e-3, "{count} {total}");
            }
        }
    }

    #[test]
    fn a_lambertian_plane_under_a_uniform_sky_shows_its_radiance() {
        let azimuths = AzimuthFrame::facing(Axis::Y, Axis::Z);
        let lights = lights(&image(|_, _| 1.0), &azimuths, 256, 1.0, 0.0).unwrap();
        let radiance: f64 = lights
            .iter()
            .map(|light| match light.origin {
                Origin::Directional { towards } => towards.y.max(0.0),
                Origin::Point { .. } => 0.0,
            } * f64::from(light.irradiance[0]) / std::f64::consts::PI)
            .sum();
        assert!((radiance - 1.0).abs() < 0.01, "{radiance}");
    }

    #[test]
    fn a_bright_spot_is_found_where_it_is() {
        let azimuths = AzimuthFrame::facing(Axis::Y, Axis::Z);
        // In the middle of the image: azimuth 180, on the horizon. A quarter to the right of it,
        // clockwise seen from above: azimuth 90.
        for (column, azimuth) in [(32, 180.0f64), (48, 90.0), (16, 270.0)] {
            let spot = image(|r, c| if r == 16 && c == column { 100.0 } else { 0.0 });
            let lights = lights(&spot, &azimuths, 16, 1.0, 0.0).unwrap();
            assert_eq!(lights.len(), 1);
            let Origin::Directional { towards } = lights[0].origin else {
                panic!("{lights:?}")
            };
            let (found, elevation) = azimuths.angles(towards);
            assert!(
                (found.to_degrees() - azimuth).abs() < 6.0,
                "{column} {found}"
            );
            assert!(elevation.abs() < 0.1);
        }
        let bad = image(|_, _| f32::NAN);
        assert!(super::lights(&bad, &azimuths, 4, 1.0, 0.0).is_err());
    }

    #[test]
    fn transparent_places_are_dark_and_a_layer_must_be_there() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("sky.png");
        ::image::RgbaImage::from_fn(4, 2, |x, _| ::image::Rgba([255, 255, 255, 85 * x as u8]))
            .save(&path)
            .unwrap();
        let mut options = RenderOptions::default();
        let sky = read(&path, &options, Progress::silent()).unwrap();
        let row: Vec<f32> = (0..4).map(|x| sky.get(0, x, 1)).collect();
        for (found, alpha) in row.iter().zip([0.0, 85.0, 170.0, 255.0]) {
            assert!((found - alpha / 255.0).abs() < 1e-6, "{row:?}");
        }
        options.lights.environment_layer = Some("sun".into());
        let error = read(&path, &options, Progress::silent()).unwrap_err();
        let text = error.to_string();
        assert!(text.starts_with("--environment-layer: `sun`"), "{text}");
    }
}
