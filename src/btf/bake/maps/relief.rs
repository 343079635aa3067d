//! The relief of a recipe: a height map or an integrated normal map, checked for what commonly goes
//! wrong (terraces of 8-bit maps, borders that do not meet, the wrong handedness).

use std::path::Path;

use crate::btf::bake::maps::normal_map::normals;
use crate::btf::bake::maps::normals::{Handedness, NormalY, Slopes};
use crate::btf::bake::maps::reading::MapReader;
use crate::btf::bake::maps::recipe::Recipe;
use crate::btf::bake::maps::resample::resampled;
use crate::btf::bake::maps::{DEFAULT_DEPTH, Terraces};
use crate::error::{Error, Result};
use crate::format::image::{self, FloatImage, Precision, ReadOptions};
use crate::progress::Progress;

/// Steps of an 8-bit map lower than this slope are not seen, in texels per texel (2°).
const VISIBLE_STEP: f64 = 0.035;
/// A terraced map has more equal neighbours than this.
const TERRACED: f64 = 0.5;
/// How much wider than usual the step across a border may be.
const SEAM: f64 = 4.0;
/// Passes of smoothing within half a step; terraces much wider than √passes stay.
const SMOOTHING_PASSES: usize = 600;

/// Heights at a map's own resolution.
pub(super) struct Relief {
    pub(super) width: u32,
    pub(super) height: u32,
    /// In widths of the map, any level.
    heights: Vec<f32>,
    /// Height of map value 1, in widths of the map; `None` where no height map gives the relief.
    pub(super) depth: Option<f64>,
    /// What a report should say.
    pub(super) notes: Vec<String>,
}

impl Relief {
    /// Heights in texels of a grid of other sides.
    pub(super) fn resampled(&self, width: u32, height: u32) -> Vec<f32> {
        let image = FloatImage::gray(self.width, self.height, self.heights.clone());
        let mut heights = resampled(&image, width, height).data;
        heights.iter_mut().for_each(|h| *h *= width as f32);
        heights
    }
}

/// Reads the relief of a recipe; a recipe without any is a plane.
///
/// `size` is what the longer side will be reduced to: terraces shrink with it.
pub(super) fn read(
    recipe: &Recipe,
    terraces: Terraces,
    size: u32,
    reader: &MapReader<'_>,
) -> Result<Relief> {
    let progress = reader.progress;
    let read = |file: &Path| reader.data(&recipe.folder.join(file));
    let relief = match (&recipe.relief.height, &recipe.relief.normal) {
        (Some(file), _) => from_heights(recipe, read(file)?.into_gray(), terraces, size, progress)?,
        (None, Some(file)) => {
            let path = recipe.folder.join(file);
            let (map, alpha) = reader.normals(&path)?;
            from_normals(recipe, map, alpha, progress).map_err(|error| error.in_file(&path))?
        }
        (None, None) => plane(recipe)?,
    };
    if recipe.tileable {
        warn_of_seams(&relief, progress);
    }
    Ok(relief)
}

/// A plane with the sides of the first map there is.
fn plane(recipe: &Recipe) -> Result<Relief> {
    let (width, height) = match recipe.files().first() {
        Some(path) => {
            let sizes_alone = ReadOptions::data();
            let read = image::read_with(path, &sizes_alone)?;
            (read.image.width, read.image.height)
        }
        None => (1, 1),
    };
    Ok(Relief {
        width,
        height,
        heights: vec![0.0; width as usize * height as usize],
        depth: None,
        notes: Vec::new(),
    })
}

/// Height of map value 1, as a share of the map's width.
fn depth(recipe: &Recipe, columns: u32, progress: Progress<'_>) -> Result<f64> {
    match (recipe.relief.height_mm, recipe.width_of(columns)?) {
        (Some(height), Some(width)) => Ok(height / width),
        (Some(_), None) => Err(Error::data("height-mm", "given without the map's size")
            .expected("width-mm or texel-mm as well")),
        (None, _) => Ok(recipe.relief.depth.unwrap_or_else(|| {
            progress.warn(format!(
                "the material does not state its depth; {DEFAULT_DEPTH} of its width is assumed \
                 (--depth, or --height-mm with --width-mm)"
            ));
            DEFAULT_DEPTH
        })),
    }
}

fn from_heights(
    recipe: &Recipe,
    image: FloatImage,
    terraces: Terraces,
    size: u32,
    progress: Progress<'_>,
) -> Result<Relief> {
    let depth = depth(recipe, image.width, progress)?;
    let mut map = Relief {
        width: image.width,
        height: image.height,
        heights: image.data,
        depth: Some(depth),
        notes: Vec::new(),
    };
    // Area means over n × n texels leave a step of 1/n of it on every texel of theirs.
    let reduction = f64::from(map.width.max(map.height)) / f64::from(size);
    let step = depth * f64::from(map.width) / 255.0 / reduction.max(1.0);
    if image.precision == Precision::Bits8 && terraces == Terraces::Smooth {
        map.heights = smoothed_within_steps(&map);
    } else if image.precision == Precision::Bits8 && step > VISIBLE_STEP && terraced(&map) {
        progress.warn(format!(
            "the height map has 8 bits: its terraces make steps of {step:.2} texels and may show; \
             use a 16-bit map, or --terraces smooth"
        ));
    }
    map.heights.iter_mut().for_each(|h| *h *= depth as f32);
    Ok(map)
}

fn from_normals(
    recipe: &Recipe,
    map: FloatImage,
    alpha: Option<Vec<f32>>,
    progress: Progress<'_>,
) -> Result<Relief> {
    if recipe.relief.height_mm.is_some() || recipe.relief.depth.is_some() {
        return Err(Error::data("height-mm or depth", "given for a normal map")
            .expected("neither: normals determine the slopes"));
    }
    let (width, height) = (map.width as usize, map.height as usize);
    let normals = normals(map, alpha, recipe.relief.normal_kind)?;
    if let Some(warning) = &normals.warning {
        progress.warn(warning.as_str());
    }
    let slopes = Slopes::of_map(&normals);
    let slopes = match chosen_handedness(recipe.relief.normal_y, slopes.handedness(), progress) {
        NormalY::Down => slopes.flipped(),
        NormalY::Up | NormalY::Auto => slopes,
    };
    let heights = slopes.heights(recipe.tileable);
    Ok(Relief {
        width: width as u32,
        height: height as u32,
        heights: heights.iter().map(|h| (h / width as f64) as f32).collect(),
        depth: None,
        notes: vec![normals.note],
    })
}

fn chosen_handedness(asked: NormalY, found: Handedness, progress: Progress<'_>) -> NormalY {
    let name = |y: NormalY| if y == NormalY::Down { "down" } else { "up" };
    match asked {
        NormalY::Auto if found.clear => found.likely,
        NormalY::Auto => {
            progress.warn(
                "the normal map does not show whether its green points up or down; taken as up \
                 (--normal-y)",
            );
            NormalY::Up
        }
        asked => {
            if found.clear && found.likely != asked {
                progress.warn(format!(
                    "the normal map's green seems to point {}, not {}: its slopes fit no surface \
                     otherwise (--normal-y)",
                    name(found.likely),
                    name(asked)
                ));
            }
            asked
        }
    }
}

/// Whether most neighbours of a map are equal.
fn terraced(map: &Relief) -> bool {
    let width = map.width as usize;
    let pairs = map
        .heights
        .chunks_exact(width)
        .flat_map(|row| row.windows(2));
    let (equal, all) = pairs.fold((0_usize, 0_usize), |(equal, all), pair| {
        (equal + usize::from(pair[0] == pair[1]), all + 1)
    });
    equal as f64 > TERRACED * all.max(1) as f64
}

/// The smoothest map (harmonic where it may be) that rounds to the same 8-bit numbers.
fn smoothed_within_steps(map: &Relief) -> Vec<f32> {
    const HALF_STEP: f32 = 0.5 / 255.0;
    let (width, height) = (map.width as usize, map.height as usize);
    let mut heights = map.heights.clone();
    for pass in 0..SMOOTHING_PASSES {
        for row in 0..height {
            for col in (0..width).filter(|col| (row + col) % 2 == pass % 2) {
                let at = |row: usize, col: usize| heights[(row % height) * width + col % width];
                let mean = 0.25
                    * (at(row + 1, col)
                        + at(row + height - 1, col)
                        + at(row, col + 1)
                        + at(row, col + width - 1));
                let here = row * width + col;
                let said = map.heights[here];
                heights[here] = mean.clamp(said - HALF_STEP, said + HALF_STEP);
            }
        }
    }
    heights
}

/// Warns where the step across a border is far wider than those inside.
fn warn_of_seams(relief: &Relief, progress: Progress<'_>) {
    let (width, height) = (relief.width as usize, relief.height as usize);
    let at = |row: usize, col: usize| f64::from(relief.heights[row * width + col]);
    let mean = |steps: &mut dyn Iterator<Item = f64>| {
        let (sum, count) = steps.fold((0.0, 0), |(sum, count), step| (sum + step, count + 1));
        sum / f64::from(count.max(1))
    };
    let across = |left: usize, right: usize| {
        mean(&mut (0..height).map(|row| (at(row, left) - at(row, right)).abs()))
    };
    let down = |upper: usize, lower: usize| {
        mean(&mut (0..width).map(|col| (at(upper, col) - at(lower, col)).abs()))
    };
    let inside_x = mean(&mut (1..width).map(|col| across(col - 1, col)));
    let inside_y = mean(&mut (1..height).map(|row| down(row - 1, row)));
    let least = 1e-3; // of the width: lower seams are not seen
    let gapes = across(width - 1, 0) > SEAM * inside_x + least
        || down(height - 1, 0) > SEAM * inside_y + least;
    if gapes {
        progress.warn(
            "the relief jumps at its borders: it does not seem tileable \
             (--tiling mirror, or tileable = false)",
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn smoothing_stays_within_half_a_step_and_removes_terraces() {
        let truth = |col: usize| 0.5 + 0.02 * (std::f32::consts::TAU * col as f32 / 64.0).sin();
        let stored: Vec<f32> = (0..64 * 8)
            .map(|i| (truth(i % 64) * 255.0).round() / 255.0)
            .collect();
        let map = Relief {
            width: 64,
            height: 8,
            heights: stored.clone(),
            depth: None,
            notes: Vec::new(),
        };
        assert!(terraced(&map));
        let smooth = smoothed_within_steps(&map);
        let error = |heights: &[f32]| {
            let slope = |h: &[f32], col: usize| h[col + 1] - h[col];
            (0..63)
                .map(|col| (slope(heights, col) - (truth(col + 1) - truth(col))).powi(2))
                .sum::<f32>()
        };
        assert!(error(&smooth[..64]) < 0.1 * error(&stored[..64]));
        for (smooth, stored) in smooth.iter().zip(&stored) {
            assert!((smooth - stored).abs() <= 0.5 / 255.0 + 1e-6);
        }
    }
}
